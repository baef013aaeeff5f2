"""Rough matt matter: plaster, brick, concrete, asphalt, textiles. Facets of Lambert's kind (Oren and Nayar), improved.

References
----------
M. Oren, S. K. Nayar: Generalization of Lambert's Reflectance Model, SIGGRAPH 1994.
Y. Fujii: Improvement of Oren-Nayar reflectance model; J. Portsmouth, P. Kutz, S. Hill: EON: A Practical Energy-Preserving
Rough Diffuse BRDF, JCGT 14(1), 2025.
"""

from dataclasses import dataclass

import numpy as np

from .coats import EIGHT, NODES, WEIGHTS

_SHADE = 0.5 - 2.0 / (3.0 * np.pi)


def _single_total(cosine, roughness: float) -> np.ndarray:
    """Share that white grains reflect by single reflection. (n,) [-]"""
    c = np.clip(np.asarray(cosine, dtype=np.float64), 1e-6, 1.0)
    s = np.sqrt(1.0 - c * c)
    shape = s * (np.arccos(c) - s * c) + (2.0 / 3.0) * ((s / c) * (1.0 - s**3) - s)
    return (1.0 + roughness * shape / np.pi) / (1.0 + _SHADE * roughness)


def mean_total(roughness: float) -> float:
    """`_single_total` for even light. [-]"""
    return float(2.0 * (WEIGHTS * NODES * _single_total(NODES, roughness)).sum())


@dataclass(frozen=True, eq=False)
class Grains:
    """Rough matt matter.

    Parameters
    ----------
    colour : (w,) array    Reflectance of a grain. [-]
    roughness : float    0 (Lambert) to 1. [-]
    """

    colour: np.ndarray
    roughness: float

    def _again(self) -> np.ndarray:
        """Factor on white light that was reflected more than once. (w,)"""
        mean = mean_total(self.roughness)
        return self.colour**2 * mean / (1.0 - self.colour * (1.0 - mean))

    def evaluate(self, wi, wo) -> np.ndarray:
        """BRDF. (n, w) [1/sr]"""
        ci, co = wi[:, 2], wo[:, 2]
        # cos(phi) sin(i) sin(o)
        swing = (wi[:, :2] * wo[:, :2]).sum(axis=1)
        larger = np.maximum(ci, co)
        shape = 1.0 + self.roughness * np.where(swing > 0.0, swing / larger, swing)
        single = shape[:, None] * self.colour / (np.pi * (1.0 + _SHADE * self.roughness))
        lost = [1.0 - _single_total(c, self.roughness) for c in (ci, co)]
        mean = 1.0 - mean_total(self.roughness)
        share = lost[0] * lost[1] / max(mean, 1e-12) / np.pi
        return single + share[:, None] * self._again()

    def total(self, cosine: float = EIGHT) -> np.ndarray:
        """Hemispherical reflectance. (w,) [-]"""
        single = float(_single_total(cosine, self.roughness))
        return self.colour * single + self._again() * (1.0 - single)
