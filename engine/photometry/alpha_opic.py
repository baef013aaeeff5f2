"""How light acts on the five receptors of the eye: alpha-opic irradiances and equivalent daylight. (CIE S 026:2018)"""

from functools import lru_cache

import numpy as np

from ...libraries import spectra as tables
from .spectra import GRID, illuminant, luminous_efficiency
from .units import LUMINOUS_EFFICACY

RECEPTORS = ("s_cone", "m_cone", "l_cone", "rhodopic", "melanopic")
"""In the order of all arrays here."""

MELANOPIC = RECEPTORS.index("melanopic")


@lru_cache
def action_spectra() -> np.ndarray:
    """Return the action spectra on `GRID`, shape (471, 5); 0 outside 380 to 780 nm, where CIE S 026 has none. [-]"""
    names, wavelengths, values = tables.action_spectra()
    columns = [values[:, names.index(name)] for name in RECEPTORS]
    found = [np.interp(GRID, wavelengths, each, left=0.0, right=0.0) for each in columns]
    return np.stack(found, axis=1)


@lru_cache
def daylight_ratios() -> np.ndarray:
    """Return the alpha-opic efficacies of luminous radiation of D65, (5,). [W/lm]"""
    power = illuminant(GRID, "D65")
    return power @ action_spectra() / (LUMINOUS_EFFICACY * power @ luminous_efficiency())


def alpha_opic(irradiance) -> np.ndarray:
    """Alpha-opic irradiances of spectra.

    Parameters
    ----------
    irradiance : (..., 471) array    On `GRID`. [W/(m2 nm)]

    Returns
    -------
    (..., 5) float64 array    [W/m2]
    """
    return np.asarray(irradiance, dtype=np.float64) @ action_spectra()


def equivalent_daylight(alpha_opic_irradiance) -> np.ndarray:
    """Alpha-opic equivalent daylight (D65) illuminances: of D65 that acts as much. (..., 5) [W/m2 -> lx]"""
    return np.asarray(alpha_opic_irradiance, dtype=np.float64) / daylight_ratios()
