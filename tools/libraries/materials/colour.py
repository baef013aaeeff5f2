"""Spectra of reflectance, and how light or dark the eye finds them under daylight."""

from functools import lru_cache

import numpy as np

from ....libraries import spectra

WAVELENGTHS = np.arange(400.0, 701.0, 10.0)
"""On which materials are computed; beyond them the ends hold. [nm]"""

D65_DAYLIGHT = (-0.296171, -0.688286)
"""Factors of the second and third component of CIE daylight in D65. (CIE 15:2018, 3.1.2 with x = 0.31272, y = 0.32903)"""


@lru_cache
def luminous_weights() -> np.ndarray:
    """Weights that sum a reflectance on `WAVELENGTHS` up to the luminous one under D65; they sum up to 1. (w,)"""
    nm, components = spectra.daylight_components()
    daylight = np.interp(WAVELENGTHS, nm, components @ np.array([1.0, *D65_DAYLIGHT]))
    nm, observer = spectra.observer()
    weights = daylight * np.interp(WAVELENGTHS, nm, observer[:, 1])
    return weights / weights.sum()


def luminous(values) -> np.ndarray:
    """Luminous reflectance or transmittance under D65 of spectra on `WAVELENGTHS`. (..., w) -> (...) [-]"""
    return np.asarray(values) @ luminous_weights()


def solve(function, target: float, low: float, high: float) -> float:
    """Where a function that rises or falls throughout has a value, by halving the interval.

    Raises
    ------
    ValueError    It does not have it between ``low`` and ``high``.
    """
    at_low, at_high = function(low) - target, function(high) - target
    if at_low * at_high > 0.0:
        raise ValueError(
            f"{target:g} lies not between {at_low + target:g} and {at_high + target:g}"
        )
    for _ in range(60):
        middle = 0.5 * (low + high)
        is_below = (function(middle) - target) * at_low > 0.0
        low, high = (middle, high) if is_below else (low, middle)
    return 0.5 * (low + high)
