"""Metallic and pearlescent paint: flat flakes in a clear binder, lying nearly parallel to the surface, over a matt base.

The light of one reflection at a flake is computed in closed form. What of it is thrown back by the inside of the surface, a
few per cent near the normal and a third at a slant, meets flakes again; over metal flakes it is spread as evenly as
reciprocity allows, so that white flakes over a white base send everything out.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .coats import NODES, WEIGHTS, Coat
from .microfacets import dot, unit

POINTS = 160
"""Points along each side of the square on which totals are found."""

COSINES = np.linspace(0.0, 1.0, 181)
"""At which flakes' reflectances are known."""


@dataclass(frozen=True, eq=False)
class Flakes:
    """A layer of flakes under a smooth surface.

    Parameters
    ----------
    reflectance : callable    Of a flake in the binder, from cosines (n,) to (n, w). [-]
    base : (w,) array    Reflectance of the matt base. [-]
    spread : float    Standard deviation of the flakes' slope along x and along y. [-]
    number : float    Flakes that a line through the layer along the normal crosses, in the mean. [-]
    absorption : (w,) array    Of the coloured binder, along the normal through the layer. [-]
    binder : float    Refractive index. [-]
    is_clear : bool    Whether flakes let through what they don't reflect, as interference pigments do; metal does not.
    is_wide : bool
        Whether flakes are wide beside their distance, so that light finds the gap again through which it came.
    """

    reflectance: Callable
    base: np.ndarray
    spread: float
    number: float
    absorption: np.ndarray
    binder: float = 1.5
    is_clear: bool = False
    is_wide: bool = False

    def __post_init__(self):
        object.__setattr__(self, "_known", self.reflectance(np.maximum(COSINES, 1e-4)))

    def _flake(self, cosine) -> np.ndarray:
        """Reflectance of a flake. (n,) -> (n, w)"""
        place = np.clip(cosine, 0.0, 1.0) * (len(COSINES) - 1)
        below = np.minimum(place.astype(int), len(COSINES) - 2)
        share = (place - below)[:, None]
        return self._known[below] * (1.0 - share) + self._known[below + 1] * share

    def _inside(self, v) -> np.ndarray:
        """Directions refracted into the binder, z up. (n, 3)"""
        flat = v[:, :2] / self.binder
        return np.concatenate([flat, np.sqrt(1.0 - (flat**2).sum(axis=1))[:, None]], axis=1)

    def evaluate(self, wi, wo) -> np.ndarray:
        """BRDF without what is mirrored. (n, w) [1/sr]"""
        return (
            self.reflect_once(wi, wo)
            if self.is_clear
            else self.reflect_once(wi, wo) + self._again(wi, wo)
        )

    def reflect_once(self, wi, wo) -> np.ndarray:
        """Of light that is reflected once, by a flake or the base. (n, w) [1/sr]"""
        i, o = self._inside(wi), self._inside(wo)
        h = unit(i + o)
        slope = (h[:, 0] ** 2 + h[:, 1] ** 2) / h[:, 2] ** 2
        density = np.exp(-0.5 * slope / self.spread**2)
        density /= 2.0 * np.pi * self.spread**2 * h[:, 2] ** 3
        scattered = self.number * self._flake(dot(i, h)) * (0.25 * density)[:, None]
        left, share = self._depth(i, o)
        flakes = scattered * share / (i[:, 2] * o[:, 2])[:, None]
        coat = Coat(self.binder)
        both = (1.0 - coat.fresnel(wi[:, 2])) * (1.0 - coat.fresnel(wo[:, 2])) / self.binder**2
        return both[:, None] * (flakes + left * self.base / np.pi)

    def _depth(self, i, o) -> tuple[np.ndarray, np.ndarray]:
        """Share of light that comes to the base and back, and mean of that over the depths of flakes. (n, w) each"""
        # Flakes lie flat: a slanted ray meets no more of them than an upright one.
        flatness = 1.0 - self.spread**2
        met = (
            self.number * flatness * (self._met(i) + self._met(o)) * (0.5 if self.is_wide else 1.0)
        )
        lost = met + self.absorption * (1.0 / i[:, 2] + 1.0 / o[:, 2])[:, None]
        left = np.exp(-lost)
        return left, (1.0 - left) / lost

    def _again(self, wi, wo) -> np.ndarray:
        """Of light that meets flakes more than once. (n, w) [1/sr]"""
        missing, mean, colour = self._missing
        both = np.interp(wi[:, 2], NODES, missing) * np.interp(wo[:, 2], NODES, missing)
        return (both / (np.pi * mean))[:, None] * colour

    @cached_property
    def _missing(self) -> tuple[np.ndarray, float, np.ndarray]:
        """Share that white flakes over a white base do not send out at once, by `NODES`, its mean, and its colour."""
        white = replace(
            self,
            reflectance=lambda cosine: np.ones((len(cosine), 1)),
            base=np.ones(1),
            absorption=np.zeros(1),
        )
        points = (np.arange(POINTS) + 0.5) / POINTS
        radius, turn = (m.ravel() for m in np.meshgrid(np.sqrt(points), np.pi * points))
        wo = np.stack(
            [radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1.0 - radius**2)], axis=1
        )
        missing = []
        for cosine in NODES:
            wi = np.broadcast_to([np.sqrt(1.0 - cosine**2), 0.0, cosine], wo.shape)
            once = np.pi * white.reflect_once(wi, wo).mean()
            missing.append(1.0 - Coat(self.binder).fresnel(cosine) - once)
        missing = np.maximum(missing, 0.0)
        mean = float(2.0 * (WEIGHTS * NODES * missing).sum())
        up = np.array([[0.0, 0.0, 1.0]])
        # Reflected twice at least, each time as strongly as by the layer seen from above.
        (left, share), (white_left, white_share) = self._depth(up, up), white._depth(up, up)
        layer = self.number * share * self._flake(np.ones(1)) + left * self.base
        layer = layer / (self.number * white_share + white_left)
        return missing, mean, layer[0] ** 2

    def _met(self, v) -> np.ndarray:
        """Share of light that a flake stops. (n, w) or (n, 1)"""
        return self._flake(v[:, 2]) if self.is_clear else np.ones((len(v), 1))

    def direct(self, incidences) -> np.ndarray:
        """Share of light that the clear coat mirrors. (s,) [rad] -> (s, w) [-]"""
        made = Coat(self.binder).direct(incidences)
        return np.broadcast_to(made, (len(incidences), len(self.base)))
