"""A matt body under a clear boundary: paint, plastic, wet ground; light that the boundary throws back inside comes again.

With E(i) the share that the boundary reflects of light from outside, T = 1 - E, and E averaged over the cosine e, the
boundary throws back r = 1 - (1 - e) / n^2 of even light inside, and a body of the reflectance rho gives

    f = T(i) T(o) rho / (pi n^2 (1 - rho r)),

which is reciprocal and, for rho = 1, sends out all that the boundary does not (Saunderson's correction by direction).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from . import fresnel
from .microfacets import smooth_to_rough

NODES = 0.5 * (np.polynomial.legendre.leggauss(48)[0] + 1.0)
"""Cosines at which shares of a boundary are known, besides 0 and 1."""

WEIGHTS = 0.5 * np.polynomial.legendre.leggauss(48)[1]
"""Of `NODES`, for integrals over the cosine."""

EIGHT = np.cos(np.radians(8.0))
"""Cosine of the incidence at which spectrophotometers with a sphere measure. (ISO 7724-2, 8/d with the gloss included)"""


@dataclass(frozen=True)
class Coat:
    """A clear boundary.

    Parameters
    ----------
    index : float    Refractive index below it. [-]
    alpha : float    Roughness of GGX; 0: smooth, and its mirror image belongs to the direct part. [-]
    """

    index: float = 1.5
    alpha: float = 0.0

    def fresnel(self, cosine) -> np.ndarray:
        """Reflectance of a facet. [-]"""
        return fresnel.reflectance(cosine, self.index)

    def share(self, cosine) -> np.ndarray:
        """Share of light from outside that it reflects. (n,) -> (n,) [-]"""
        if self.alpha == 0.0:
            return self.fresnel(cosine)
        return np.interp(cosine, *_rough_shares(self.index, self.alpha))

    @property
    def mean_share(self) -> float:
        """Of even light from outside. [-]"""
        return float(2.0 * (WEIGHTS * NODES * self.share(NODES)).sum())

    @property
    def held_back(self) -> float:
        """Share of even light inside that it throws back. [-]"""
        return 1.0 - (1.0 - self.mean_share) / self.index**2

    def gloss(self, wi, wo) -> np.ndarray:
        """What its facets reflect; nothing if it is smooth. (n, 1) [1/sr]"""
        if self.alpha == 0.0:
            return np.zeros((len(wi), 1))
        return smooth_to_rough(self.alpha).reflection(wi, wo, self.fresnel)

    def passed(self, wi, wo) -> np.ndarray:
        """Factor T(i) T(o) / (pi n^2) on what comes from the body. (n, 1) [1/sr]"""
        both = (1.0 - self.share(wi[:, 2])) * (1.0 - self.share(wo[:, 2]))
        return both[:, None] / (np.pi * self.index**2)

    def direct(self, incidences) -> np.ndarray:
        """Share of light that is mirrored. (s,) [rad] -> (s, 1) [-]"""
        made = self.fresnel(np.cos(incidences)) if self.alpha == 0.0 else 0.0 * incidences
        return made[:, None]

    def reflectance_over(self, body, cosine: float = EIGHT) -> np.ndarray:
        """Hemispherical reflectance with a body of a reflectance below, gloss included. (w,) -> (w,) [-]"""
        share = float(self.share(np.array([cosine]))[0])
        left = 1.0 - self.held_back
        return share + (1.0 - share) * left * body / (1.0 - body * self.held_back)


@lru_cache
def _rough_shares(index: float, alpha: float) -> tuple[np.ndarray, np.ndarray]:
    cosines = np.concatenate([[1e-4], NODES, [1.0]])
    return cosines, smooth_to_rough(alpha).albedo(cosines, lambda c: fresnel.reflectance(c, index))


@dataclass(frozen=True, eq=False)
class Paint:
    """A coat over a matt body of a reflectance. ``body``: (w,) [-]"""

    coat: Coat
    body: np.ndarray

    def evaluate(self, wi, wo) -> np.ndarray:
        """BRDF without what is mirrored. (n, w) [1/sr]"""
        inside = self.body / (1.0 - self.body * self.coat.held_back)
        return self.coat.gloss(wi, wo) + self.coat.passed(wi, wo) * inside

    def direct(self, incidences) -> np.ndarray:
        """Share of light that is mirrored. (s,) [rad] -> (s, w) [-]"""
        return np.broadcast_to(self.coat.direct(incidences), (len(incidences), len(self.body)))


@dataclass(frozen=True, eq=False)
class Slab:
    """A sheet that scatters inside, with a clear boundary on both sides: opal acrylic and glass.

    Parameters
    ----------
    coat : Coat    Of both sides.
    reflectance, transmittance : (w,) arrays    Of the scattering layer alone, for even light inside of it. [-]
    """

    coat: Coat
    reflectance: np.ndarray
    transmittance: np.ndarray

    def _leaving(self) -> tuple[np.ndarray, np.ndarray]:
        """Even light at the inside of the near and of the far side, for 1 that entered."""
        r = self.coat.held_back
        far = self.transmittance / (1.0 - r * self.reflectance)
        near = self.reflectance + r * self.transmittance * far
        entered = 1.0 / (1.0 - r * near)
        return entered * near, entered * far

    def reflect(self, wi, wo) -> np.ndarray:
        """BRDF without what is mirrored. (n, w) [1/sr]"""
        return self.coat.gloss(wi, wo) + self.coat.passed(wi, wo) * self._leaving()[0]

    def transmit(self, wi, wo) -> np.ndarray:
        """BTDF. (n, w) [1/sr]"""
        return self.coat.passed(wi, wo) * self._leaving()[1]

    def direct(self, incidences) -> np.ndarray:
        """Share of light that is mirrored. (s,) [rad] -> (s, w) [-]"""
        return np.broadcast_to(
            self.coat.direct(incidences), (len(incidences), len(self.reflectance))
        )

    def totals(self, cosine: float = EIGHT) -> tuple[np.ndarray, np.ndarray]:
        """Hemispherical reflectance and transmittance. (w,), (w,) [-]"""
        share = float(self.coat.share(np.array([cosine]))[0])
        near, far = self._leaving()
        left = (1.0 - share) * (1.0 - self.coat.held_back)
        return share + left * near, left * far
