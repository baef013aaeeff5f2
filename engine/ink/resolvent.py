"""Waves in a layer that absorbs everywhere, of the very equations that those of the layer itself have on their grid.

Of each lateral mode Green's function on the grid is G = a S + b, where S has a tridiagonal inverse B, as it belongs to a
differential equation of second order. So (1 - c G)^-1, by which G turns into the function of a layer whose permittivity is
larger by c / k0^2, costs as much as G itself:

    x = (1 - c G)^-1 s    by    [(1 - c b) B - c a] y = s,    x = B y

References
----------
G. Osnabrugge, S. Leedumrongwatthanakul, I. M. Vellekoop: A convergent Born series for solving the inhomogeneous Helmholtz
equation in arbitrarily large media, J. Comput. Phys. 322, 2016, 113-124 (where the function itself is that of the
continuum, which on coarse grids is another than ours, and loses energy).
"""

import numpy as np


class Resolvent:
    """(1 - c G)^-1 for all modes.

    Parameters
    ----------
    chain : callable    S of fields of modes, (z, y, x) -> (z, y, x).
    stride : (y, x) complex128 array    What S has beside its diagonal, relative to that, where faces send nothing back.
    scale, rest : (y, x) complex128 arrays    a and b above.
    layers : int
    strength : complex    c.
    """

    def __init__(self, chain, stride, scale, rest, layers: int, strength: complex):
        first, last = (self._column(chain, k, layers, stride) for k in (0, layers - 1))
        square = 1.0 - stride**2
        self._beside = -stride / square
        # Faces only change how B begins and ends.
        begin = (1.0 - self._beside * first[1]) / first[0]
        end = (1.0 - self._beside * last[-2]) / last[-1]
        inner = (1.0 + stride**2) / square
        self._diagonal = [begin, *[inner] * (layers - 2), end]
        much, self._strength = 1.0 - strength * rest, strength
        self._moved = much * self._beside
        self._pivots = []
        for each in self._diagonal:
            pivot = much * each - strength * scale
            if self._pivots:
                pivot = pivot - self._moved**2 * self._pivots[-1]
            self._pivots.append(1.0 / pivot)

    def apply(self, source: np.ndarray) -> np.ndarray:
        """(1 - c G)^-1 of a source. (z, y, x) -> (z, y, x)"""
        modes = np.fft.fft2(source, axes=(1, 2))
        solved, moved, beside = modes, self._moved, self._beside
        solved[0] *= self._pivots[0]
        for k in range(1, len(solved)):
            solved[k] = (solved[k] - moved * solved[k - 1]) * self._pivots[k]
        for k in range(len(solved) - 2, -1, -1):
            solved[k] -= moved * self._pivots[k] * solved[k + 1]
        made = np.empty_like(solved)
        for k, diagonal in enumerate(self._diagonal):
            made[k] = diagonal * solved[k]
        made[1:] += beside * solved[:-1]
        made[:-1] += beside * solved[1:]
        return np.fft.ifft2(made, axes=(1, 2))

    def spread(self, source: np.ndarray) -> np.ndarray:
        """Field that a source makes in the layer that absorbs, (1 - c G)^-1 G. (z, y, x) -> (z, y, x)"""
        return (self.apply(source) - source) / self._strength

    @staticmethod
    def _column(chain, number: int, layers: int, stride) -> np.ndarray:
        """S of a source in one layer."""
        source = np.zeros((layers, *stride.shape), np.complex128)
        source[number] = 1.0
        return chain(source)
