"""Scalar waves in a layer of any structure between two half-spaces, in a cell that repeats sideways.

The field u of div grad u + k0^2 eps u = 0 is that of a homogeneous layer, u0, and what its departures send out,

    u = u0 + G V u,    V = k0^2 (eps - eps_b)

For a lateral mode q with gamma = sqrt(eps_b k0^2 - q^2) in the layer, gamma_0 and gamma_1 above and below it,
r0 = (gamma - gamma_0) / (gamma + gamma_0), r1 likewise, and E = exp(i gamma H),

    G(z, z') = i / (2 gamma) {exp(i gamma |z - z'|) + [r0 exp(i gamma (z + z')) + r1 exp(i gamma (2 H - z - z'))
               + r0 r1 E^2 (exp(i gamma (z - z')) + exp(-i gamma (z - z')))] / (1 - r0 r1 E^2)}

so that nothing comes back from where there is nothing: no absorbing border, no padding. The field is a mean over each
cell's height (Galerkin), which keeps reciprocity and, with a real eps_b, energy exactly. The first term is two recursions
along z, the others are of rank two: every application costs as many operations as there are cells, and two FFT.

References
----------
K. M. Watson, J. Nuttall: Topics in Several Particle Dynamics, 1967 (Lippmann's and Schwinger's equation). R. Petit (ed.):
Electromagnetic Theory of Gratings, 1980 (Rayleigh's expansions of periodic layers).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import SceneError
from .krylov import Found, solve_linear, solve_short
from .resolvent import Resolvent

LEAST_KEPT, MOST_KEPT = 30, 200
"""Directions that the iteration keeps before it starts anew; what strong scatterers take it learns only from many."""

MOST_MEMORY = 1 << 30
"""Of them beyond the least. [byte]"""

PLAIN_ITERATIONS = 120
"""Iterations after which waves that run along the layer are held to be the cause, and damped."""

MOST_ITERATIONS = 600

DAMPING = 0.2
"""Absorption by which they are damped, over the largest departure of the permittivity."""

STRONG = 3.0
"""Largest departure of the permittivity from its mean from which on particles resonate by themselves."""

MOST_SHORT = 6000
"""Iterations for such."""

SHORT_TOLERANCE = 0.3
"""What is left of their equation when they end, over the tolerance: its norm counts what resonates for little."""

GRAZING = 1e-6
"""Least |gamma| relative to k0: a mode that runs exactly along the layer has no amplitude of its own."""

SMALL = 1e-4
"""Phases across a cell below which series take the place of quotients."""


@dataclass(frozen=True, eq=False)
class Cell:
    """A piece of a layer that repeats sideways.

    Parameters
    ----------
    permittivity : (z, y, x) array    Squares of indices in cells of the grid, the uppermost first. [-]
    width : float    Along x and y. [um]
    thickness : float    [um]
    above, below : float    Real indices of the half-spaces.
    """

    permittivity: np.ndarray
    width: float
    thickness: float
    above: float = 1.0
    below: float = 1.0

    def turned_over(self) -> "Cell":
        """The same seen from below."""
        return Cell(self.permittivity[::-1], self.width, self.thickness, self.below, self.above)


@dataclass(frozen=True, eq=False)
class Scattered:
    """What becomes of a wave of one mode.

    Parameters
    ----------
    up, down : (y, x) complex128 arrays    Amplitudes of the modes that go out above and below.
    reflected, transmitted : (y, x) float64 arrays    Shares of the power, 0 of modes that do not carry any. [-]
    absorbed : float
        Share of the power by the field in the layer, the mean over each cell; with a real eps_b it makes the sum 1, but for
        the residual. [-]
    iterations : int
    """

    up: np.ndarray
    down: np.ndarray
    reflected: np.ndarray
    transmitted: np.ndarray
    absorbed: float
    iterations: int


class Waves:
    """Waves of one wavelength in a cell."""

    def __init__(self, cell: Cell, wavelength: float, tangential=(0.0, 0.0), background=None):
        """Prepare.

        Parameters
        ----------
        wavelength : float    In vacuum. [um]
        tangential : (float, float)    Wave vector of mode 0 along x and y (Bloch). [1/um]
        background : complex or None    eps_b, the mean where it is None.
        """
        self.cell = cell
        self.k0 = 2.0 * np.pi / wavelength
        layers, rows, columns = cell.permittivity.shape
        self._step = step = cell.thickness / layers
        self._tangential = tangential
        self._background = complex(cell.permittivity.mean() if background is None else background)
        self._strength = self.k0**2 * (cell.permittivity - self._background)
        along = 2.0 * np.pi * np.fft.fftfreq(columns, cell.width / columns) + tangential[0]
        across = 2.0 * np.pi * np.fft.fftfreq(rows, cell.width / rows) + tangential[1]
        self.modes = along[None, :] + 0.0 * across[:, None], across[:, None] + 0.0 * along[None, :]
        square = along[None, :] ** 2 + across[:, None] ** 2
        self.above, self.below = (
            _root(index**2 * self.k0**2 - square) for index in (cell.above, cell.below)
        )
        inner = _root(self._background * self.k0**2 - square)
        self._inner = inner = np.where(np.abs(inner) < GRAZING * self.k0, GRAZING * self.k0, inner)
        self._upper = (inner - self.above) / (inner + self.above)
        self._lower = (inner - self.below) / (inner + self.below)
        self._through = np.exp(1j * inner * cell.thickness)
        self._loop = 1.0 - self._upper * self._lower * self._through**2
        half = 0.5 * inner * step
        self._mean = np.where(
            np.abs(half) < SMALL, 1.0 - half**2 / 6.0, np.sin(half) / np.where(half == 0, 1, half)
        )
        whole = 1j * inner * step
        own = np.where(
            np.abs(whole) < 1e-3,
            step * (1.0 + whole / 3.0 + whole**2 / 12.0 + whole**3 / 60.0),
            2.0 * step * (np.expm1(whole) - whole) / np.where(whole == 0, 1, whole**2),
        )
        self._own, self._other = 0.5j / inner * own, 0.5j / inner * self._mean**2 * step
        self._stride, self._half_stride = np.exp(whole), np.exp(0.5 * whole)

    def scatter(self, order=(0, 0), tolerance: float = 1e-4) -> Scattered:
        """Let light come from above in one of the modes.

        Parameters
        ----------
        order : (int, int)    Mode, along y and x.
        tolerance : float    Residual of the equation, relative.

        Raises
        ------
        SceneError    The iteration does not get there.
        """
        start, up, down = self._undisturbed(order)
        kept = kept_directions(start.size)
        found = solve_linear(self._disturb, start, tolerance, kept, PLAIN_ITERATIONS)
        if found.residual > tolerance and self._is_strong:
            return self._scatter_strongly(order, tolerance, found.iterations)
        if found.residual > tolerance:
            found = self._solve_damped(start, tolerance, found.iterations)
        if found.residual > tolerance:
            raise self._unsettled(f"residual {found.residual:.2g}", found.iterations, tolerance)
        return self._scattered(order, found, up, down)

    def _scattered(self, order, found: Found, up: complex, down: complex) -> Scattered:
        """What goes out, of the field and of the waves in the homogeneous layer."""
        sent = self._send_out(self._strength * found.answer)
        sent[0][order] += up
        sent[1][order] += down
        come = self.above[order].real
        shares = [
            np.abs(each) ** 2 * gamma.real / come
            for each, gamma in zip(sent, (self.above, self.below), strict=True)
        ]
        loss = (self.cell.permittivity.imag * np.abs(found.answer) ** 2).mean()
        absorbed = self.k0**2 * self.cell.thickness * float(loss) / come
        return Scattered(*sent, *shares, absorbed, found.iterations)

    def _unsettled(self, what: str, iterations: int, tolerance: float) -> SceneError:
        return SceneError(
            f"waves of {2000.0 * np.pi / self.k0:.0f} nm do not settle in the layer: {what} after {iterations} iterations, "
            f"expected {tolerance:g}; change the cell's width by a hundredth, or take smaller particles or an index nearer "
            "to the binder's"
        )

    @property
    def _is_strong(self) -> bool:
        return float(np.abs(self._strength).max()) > STRONG * self.k0**2

    def _scatter_strongly(self, order, tolerance: float, used: int) -> Scattered:
        """Solve where every particle resonates by itself, so that the eigenvalues of 1 - G V lie all around 0.

        With c = i d, d the largest departure |V| from the middle of the permittivities, V' = V - c and G' = G (1 - c G)^-1,

            (i V' / d) (1 - G' V') u = (i V' / d) (1 - c G)^-1 u0

        has the same answer, and no eigenvalue is farther from 1 than 1: as G lets no energy come from nowhere, the norm of
        (1 + c G) / (1 - c G) is at most 1 (Osnabrugge et al. 2016, see `resolvent`). What is left of this equation says
        little of what is left of energy, so that is looked at too: it is kept exactly by the answer, as the background is
        real here.
        """
        parts = self.cell.permittivity.real
        middle = 0.5 * (float(parts.min()) + float(parts.max()))
        waves = Waves(self.cell, 2.0 * np.pi / self.k0, self._tangential, middle)
        start, up, down = waves._undisturbed(order)
        departure = float(np.abs(waves._strength).max())
        c = 1j * departure
        damped = Resolvent(
            waves._chain,
            waves._stride,
            waves._other,
            waves._own - waves._other,
            len(self.cell.permittivity),
            c,
        )
        strength = waves._strength - c
        weight = 1j / departure * strength
        found = solve_short(
            lambda field: weight * (field - damped.spread(strength * field)),
            weight * damped.apply(start),
            SHORT_TOLERANCE * tolerance,
            MOST_SHORT,
        )
        found = Found(found.answer, used + found.iterations, found.residual)
        made = waves._scattered(order, found, up, down)
        missing = abs(made.reflected.sum() + made.transmitted.sum() + made.absorbed - 1.0)
        # Written so that what is no number is refused too.
        if not (found.residual <= tolerance and missing <= tolerance):
            what = f"residual {found.residual:.2g}, energy off by {missing:.2g}"
            raise self._unsettled(what, found.iterations, tolerance)
        return made

    def _disturb(self, field: np.ndarray) -> np.ndarray:
        """What is left of a field without what it sends out itself, u - G V u."""
        return field - self.spread(self._strength * field)

    def _solve_damped(self, start: np.ndarray, tolerance: float, used: int) -> Found:
        """Solve the same equations where waves run along the layer for long, and sums of what they send out do not settle.

        A layer that absorbs, eps_b + i d, has waves that die, of which the function G' is: that of G (1 - c G)^-1 with
        c = i d k0^2. So 1 + c G' nearly undoes 1 - c G, and (1 - G V) (1 + c G') w = u0 has no long waves to sum up. The
        residual and, with u = (1 + c G') w, the answer are those of 1 - G V: energy is kept as before.
        """
        strength = 1j * DAMPING * float(np.abs(self._strength).max())
        damped = Waves(
            self.cell,
            2.0 * np.pi / self.k0,
            self._tangential,
            self._background + strength / self.k0**2,
        )

        def damp(field):
            return field + strength * damped.spread(field)

        kept = kept_directions(start.size)
        found = solve_linear(
            lambda field: self._disturb(damp(field)), start, tolerance, kept, MOST_ITERATIONS
        )
        return Found(damp(found.answer), used + found.iterations, found.residual)

    def spread(self, source: np.ndarray) -> np.ndarray:
        """Field that a source in the layer makes, G. (z, y, x) -> (z, y, x)"""
        modes = np.fft.fft2(source, axes=(1, 2))
        made = self._between(modes)
        made *= self._other
        modes *= self._own
        made += modes
        return np.fft.ifft2(made, axes=(1, 2))

    def _chain(self, modes: np.ndarray) -> np.ndarray:
        """What layers send to each other and to themselves, but for a factor of the mode; S of `resolvent`."""
        return self._between(modes) + modes

    def _between(self, modes: np.ndarray) -> np.ndarray:
        """What layers send to each other, and get back by the faces, but for a factor of the mode."""
        down, up = self._sums(modes)
        down, up = down / self._half_stride, up / self._half_stride
        # What both faces send back of it, at the middles of the first and the last cell; these go on like the rest.
        both = self._upper * self._lower * self._through / self._loop
        falling = (self._upper / self._loop * up + both * down) * self._half_stride
        rising = (self._lower / self._loop * down + both * up) * self._half_stride
        made = np.empty_like(modes)
        for k in range(len(modes)):
            made[k] = falling
            falling += modes[k]
            falling *= self._stride
        for k in range(len(modes) - 1, -1, -1):
            made[k] += rising
            rising += modes[k]
            rising *= self._stride
        return made

    def _sums(self, modes) -> tuple[np.ndarray, np.ndarray]:
        """What a source sends to one cell below and to one above the layer."""
        down = np.zeros_like(modes[0])
        for each in modes:
            down += each
            down *= self._stride
        up = np.zeros_like(modes[0])
        for each in modes[::-1]:
            up += each
            up *= self._stride
        return down, up

    def _undisturbed(self, order):
        """Field of a wave in the homogeneous layer, as means over cells, and its amplitudes outside."""
        layers, rows, columns = self.cell.permittivity.shape
        inner, above, upper, lower, through, loop, mean = (
            each[order]
            for each in (
                self._inner, self.above, self._upper, self._lower, self._through, self._loop, self._mean,
            )
        )  # fmt: skip
        z = (np.arange(layers) + 0.5) * self._step
        entered = 2.0 * above / (above + inner)
        back = np.exp(1j * inner * (self.cell.thickness - z))
        profile = entered * (np.exp(1j * inner * z) + lower * through * back) / loop * mean
        waves = [
            np.exp(2j * np.pi * np.arange(count) * np.fft.fftfreq(count)[number])
            for number, count in zip(order, (rows, columns), strict=True)
        ]
        up = -upper + (1.0 - upper**2) * lower * through**2 / loop
        down = entered * through * (1.0 + lower) / loop
        return profile[:, None, None] * waves[0][None, :, None] * waves[1], up, down

    def _send_out(self, source) -> list[np.ndarray]:
        """Amplitudes that a source sends out above and below."""
        _, rows, columns = source.shape
        down, up = self._sums(np.fft.fft2(source, axes=(1, 2)))
        scale = 0.5j / self._inner * self._step * self._mean / self._loop
        scale = scale / self._half_stride / (rows * columns)
        return [
            scale * (1.0 + self._upper) * (up + self._lower * self._through * down),
            scale * (1.0 + self._lower) * (down + self._upper * self._through * up),
        ]

    @cached_property
    def carrying(self) -> tuple[np.ndarray, np.ndarray]:
        """Which modes carry power away above and below, (y, x)."""
        return self.above.imag == 0.0, self.below.imag == 0.0


def kept_directions(cells: int) -> int:
    """How many fields of a grid the iteration keeps."""
    return min(max(MOST_MEMORY // (16 * cells), LEAST_KEPT), MOST_KEPT)


def _root(square) -> np.ndarray:
    """Square root that decays or goes outwards."""
    root = np.sqrt(square + 0j)
    return np.where(root.imag < 0.0, -root, root)
