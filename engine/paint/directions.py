"""Directions in the layers of a paint at which light is followed, as Fresnel's law ties them together.

Across parallel interfaces s = n sin(theta) is kept, and so is d(s2) = n2 2 cos d(cos), which flux goes by. Directions that
leave the paint have s < 1; beyond every index of a layer those above it are met by light that is reflected totally. Between
these limits stand Gauss's places in the cosine of the least dense medium that light of that panel passes: it is what
becomes 0 at the panel's end, and cosines of denser media are smooth in it.
"""

from dataclasses import dataclass

import numpy as np

SAME_INDEX = 1e-6
"""Indices that differ by less are one."""


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions of light by their s = n sin(theta), those that leave the paint first.

    Parameters
    ----------
    sines : (n,) float64 array    s of each.
    weights : (n,) float64 array    Of integrals over s2, which add up to the square of the largest index.
    leaving : int    How many leave.
    places : (l,) float64 array    Cosines in `medium` of those that leave, by which values are interpolated.
    medium : float    Index of the least dense layer.
    """

    sines: np.ndarray
    weights: np.ndarray
    leaving: int
    places: np.ndarray
    medium: float

    def cosines(self, index: float) -> np.ndarray:
        """Cosines in a layer of those directions that exist in it; others are beyond its limit and left out. (k,)"""
        return np.sqrt(1.0 - (self.sines[: self.count(index)] / index) ** 2)

    def count(self, index: float) -> int:
        """How many directions exist in a layer: the first so many."""
        return int(np.count_nonzero(self.sines < index))

    def interpolation(self, sines) -> np.ndarray:
        """Weights by which values at the directions that leave give those at others that leave. (k,) -> (k, l)

        They are exact for polynomials of the cosine, as which the even modes of the azimuth run.
        """
        x = np.sqrt(1.0 - (np.minimum(sines, 1.0) / self.medium) ** 2)
        away = x[:, None] - self.places[None]
        is_same = np.abs(away) < 1e-14
        share = self._barycentric / np.where(is_same, 1.0, away)
        share = np.where(is_same.any(axis=1, keepdims=True), is_same, share)
        return share / share.sum(axis=1, keepdims=True)

    def interpolations(self, sines) -> np.ndarray:
        """The same for even modes, and for odd ones, which run as a sine times such a polynomial. (k,) -> (2, k, l)"""
        even = self.interpolation(sines)
        return np.stack([even, even * np.asarray(sines)[:, None] / self.sines[: self.leaving]])

    @property
    def _barycentric(self) -> np.ndarray:
        away = self.places[:, None] - self.places[None]
        np.fill_diagonal(away, 1.0)
        span = 0.25 * (self.places.max() - self.places.min())
        return 1.0 / np.prod(away / span, axis=1)


def place_directions(indices, count: int) -> Directions:
    """Place directions in layers.

    Parameters
    ----------
    indices : sequence of float    Real refractive indices of the layers.
    count : int    Directions in all, half of them leave; a few more where layers differ.
    """
    media = []
    for index in sorted(indices):
        if not media or index - media[-1] > SAME_INDEX:
            media.append(float(index))
    limits = [0.0, *([1.0] if media[0] > 1.0 + SAME_INDEX else []), *media]
    sines, weights, places = [], [], None
    for low, high in zip(limits[:-1], limits[1:], strict=True):
        medium = max(high, media[0])
        first, last = (np.sqrt(1.0 - (end / medium) ** 2) for end in (high, low))
        share = (high**2 - low**2) / media[-1] ** 2
        here = count // 2 if high <= media[0] else max(4, round(count * share))
        x, weight = np.polynomial.legendre.leggauss(here)
        x, weight = 0.5 * (last - first) * x + 0.5 * (first + last), 0.5 * (last - first) * weight
        sines.append(medium * np.sqrt(1.0 - x**2))
        weights.append(2.0 * medium**2 * x * weight)
        places = x if places is None else places
    return Directions(np.concatenate(sines), np.concatenate(weights), len(places), places, media[0])
