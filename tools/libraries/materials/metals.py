"""Rough metals by their complex refractive index: brushed along x, satin, under a thin oxide."""

from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from . import fresnel
from .colour import WAVELENGTHS
from .microfacets import Facets


@lru_cache
def index_of(metal: str) -> np.ndarray:
    """Complex refractive index n + ik by a name of `libraries.spectra.METALS`, of the tables that come with Mitsuba. (w,)"""
    # The package is looked for, not loaded.
    folder = Path(find_spec("mitsuba").origin).parent / "data" / "ior"
    parts = []
    for name in ("eta", "k"):
        nm, values = np.loadtxt(folder / f"{metal}.{name}.spd").T
        # Some tables tell a wavelength twice, where two sources meet.
        nm, first = np.unique(nm, return_index=True)
        parts.append(np.interp(WAVELENGTHS, nm, values[first]))
    return parts[0] + 1j * parts[1]


@dataclass(frozen=True, eq=False)
class Metal:
    """A rough metal.

    Parameters
    ----------
    index : (w,) complex array    Refractive index n + ik. [-]
    facets : Facets
    clearness : float    Share of light that a thin oxide leaves, there and back. [-]
    haze : float    Share of light that scatters evenly. [-]
    """

    index: np.ndarray
    facets: Facets
    clearness: float = 1.0
    haze: float = 0.0

    def fresnel(self, cosine) -> np.ndarray:
        """Reflectance of a facet. (n,) -> (n, w) [-]"""
        return fresnel.reflectance(np.asarray(cosine)[:, None], self.index)

    def evaluate(self, wi, wo) -> np.ndarray:
        """BRDF. (n, w) [1/sr]"""
        lobe = self.facets.reflection(wi, wo, self.fresnel)
        mean = self.fresnel(np.array([0.7]))[0]
        return self.clearness * ((1.0 - self.haze) * lobe + self.haze * mean / np.pi)
