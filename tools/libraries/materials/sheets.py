"""Sheets with holes: curtains, sun screens, perforated metal. Through the holes light passes straight."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .coats import NODES, WEIGHTS


@dataclass(frozen=True, eq=False)
class Cloth:
    """A plain weave of round yarns, alike both ways; yarns reflect and let through evenly.

    Parameters
    ----------
    openness : float    Share of light along the normal that meets no yarn. [-]
    reflectance, transmittance : (w,) arrays    Of light that meets yarns. [-]
    """

    openness: float
    reflectance: np.ndarray
    transmittance: np.ndarray

    def open_share(self, cosine) -> np.ndarray:
        """Share of light that meets no yarn: slanted, yarns across its way close up. (n,) -> (n,) [-]"""
        cover = 1.0 - np.sqrt(self.openness)
        across = np.maximum(1.0 - cover / np.maximum(cosine, 1e-9), 0.0)
        return (1.0 - cover) * across

    def _scattered(self, wi, wo) -> np.ndarray:
        """Even scattering of what meets yarns, from both directions. (n, 1) [1/sr]"""
        mean = 2.0 * (WEIGHTS * NODES * (1.0 - self.open_share(NODES))).sum()
        met = (1.0 - self.open_share(wi[:, 2])) * (1.0 - self.open_share(wo[:, 2]))
        return (met / (np.pi * mean))[:, None]

    def reflect(self, wi, wo) -> np.ndarray:
        """BRDF. (n, w) [1/sr]"""
        return self._scattered(wi, wo) * self.reflectance

    def transmit(self, wi, wo) -> np.ndarray:
        """BTDF without what passes straight. (n, w) [1/sr]"""
        return self._scattered(wi, wo) * self.transmittance

    def direct(self, incidences) -> np.ndarray:
        """Share of light that passes straight. (s,) [rad] -> (s, w) [-]"""
        share = self.open_share(np.cos(incidences))
        return np.repeat(share[:, None], len(self.reflectance), axis=1)


@dataclass(frozen=True, eq=False)
class Perforated:
    """A sheet with round holes; light that meets a hole's wall is lost.

    Parameters
    ----------
    solid : callable    BRDF of the sheet, (n, 3), (n, 3) -> (n, w). [1/sr]
    openness : float    Share of the area that is holes. [-]
    depth : float    Thickness of the sheet over the diameter of a hole. [-]
    """

    solid: Callable
    openness: float
    depth: float

    def reflect(self, wi, wo) -> np.ndarray:
        """BRDF. (n, w) [1/sr]"""
        return (1.0 - self.openness) * self.solid(wi, wo)

    def open_share(self, incidences) -> np.ndarray:
        """Share of light that passes straight: both ends of a hole overlap as two circles. (s,) [rad] -> (s,) [-]"""
        apart = np.minimum(self.depth * np.tan(incidences), 1.0)
        overlap = (np.arccos(apart) - apart * np.sqrt(1.0 - apart**2)) * 2.0 / np.pi
        return self.openness * overlap
