"""Colour fidelity and gamut indices Rf and Rg. (ANSI/IES TM-30-20, CIE 224:2017)"""

from functools import lru_cache

import numpy as np

from ...libraries import spectra as tables
from .colour_temperature import colour_temperature
from .spectra import GRID, daylight, luminous_efficiency, observer, planck

MIXED = (4000.0, 5000.0)
"""Between these the reference goes over from a blackbody to daylight. [K] (TM-30, 3.3)"""

HUES = 16
"""Bins of hue, between whose means the gamut lies."""

_RANGE = (GRID >= 380.0) & (GRID <= 780.0)

_TO_SHARPENED = np.array(
    [[0.7328, 0.4296, -0.1624], [-0.7036, 1.6975, 0.0061], [0.0030, 0.0136, 0.9834]]
)
_TO_CONES = np.array([[0.38971, 0.68898, -0.07868], [-0.22981, 1.18340, 0.04641], [0.0, 0.0, 1.0]])
"""From X, Y, Z to the channels of CAT02 and of Hunt, Pointer and Estevez. (CIE 159:2004)"""

_ADAPTING, _BACKGROUND = 100.0, 20.0
"""Viewing conditions of TM-30: adapting luminance [cd/m2] and Y of the background; average surround, full adaptation."""

_SCALE = 6.73
"""Fidelity per unit of colour difference."""


def fidelity_and_gamut(power) -> tuple[float, float] | None:
    """Fidelity index Rf and gamut index Rg.

    Parameters
    ----------
    power : (471,) array    Spectral power on `GRID`, on any scale; what is outside 380 to 780 nm does not count.

    Returns
    -------
    (float, float) or None    None where the light has no colour temperature. [-]
    """
    power = np.where(_RANGE, np.asarray(power, dtype=np.float64), 0.0)
    found = colour_temperature(power @ observer())
    if found is None:
        return None
    seen, expected = (_appearance(each) for each in (power, _reference(found[0])))
    difference = float(np.linalg.norm(seen - expected, axis=1).mean())
    fidelity = 10.0 * np.log1p(np.exp((100.0 - _SCALE * difference) / 10.0))
    hue = np.mod(np.arctan2(expected[:, 2], expected[:, 1]), 2.0 * np.pi)
    bins = np.minimum((hue * HUES / (2.0 * np.pi)).astype(int), HUES - 1)
    filled = np.unique(bins)
    areas = [
        _polygon(np.stack([colours[bins == each, 1:].mean(axis=0) for each in filled]))
        for colours in (seen, expected)
    ]
    return float(fidelity), 100.0 * areas[0] / areas[1]


def _reference(temperature: float) -> np.ndarray:
    """Power of the reference of a colour temperature on `GRID`."""
    share = np.clip((temperature - MIXED[0]) / (MIXED[1] - MIXED[0]), 0.0, 1.0)
    total = np.zeros_like(GRID)
    for weight, phase in ((1.0 - share, planck), (share, daylight)):
        if weight > 0.0:
            each = np.where(_RANGE, phase(GRID, temperature), 0.0)
            total += weight * each / (each @ luminous_efficiency())
    return total


@lru_cache
def _weighted_samples() -> tuple[np.ndarray, np.ndarray]:
    """Radiance factors of the samples times the 10-degree observer, (471, 99, 3), and that observer."""
    nm, functions = tables.observer_1964()
    seen = np.stack([np.interp(GRID, nm, each) for each in functions.T], axis=1)
    wavelengths, factors = tables.colour_samples(2017)
    columns = np.stack([np.interp(GRID, wavelengths, each) for each in factors.T], axis=1)
    return columns[:, :, None] * seen[:, None, :], seen


def _appearance(power: np.ndarray) -> np.ndarray:
    """J', a', b' of the samples in the uniform space of CIECAM02. (99, 3)"""
    samples, seen = _weighted_samples()
    white = power @ seen
    scale = 100.0 / white[1]
    return _uniform(scale * np.einsum("g,gsc->sc", power, samples), scale * white)


def _uniform(tristimulus: np.ndarray, white: np.ndarray) -> np.ndarray:
    """CAM02-UCS of colours (n, 3) seen in a white (3,)."""
    k = 1.0 / (5.0 * _ADAPTING + 1.0)
    level = 0.2 * k**4 * 5.0 * _ADAPTING + 0.1 * (1.0 - k**4) ** 2 * np.cbrt(5.0 * _ADAPTING)
    n = _BACKGROUND / white[1]
    induction, exponent = 0.725 * n**-0.2, 0.69 * (1.48 + np.sqrt(n))
    gain = 100.0 / (_TO_SHARPENED @ white)

    def responses(colours):
        cones = (colours @ _TO_SHARPENED.T * gain) @ (_TO_CONES @ np.linalg.inv(_TO_SHARPENED)).T
        bent = (level * np.abs(cones) / 100.0) ** 0.42
        return np.sign(cones) * 400.0 * bent / (bent + 27.13) + 0.1

    def achromatic(cones):
        return (cones @ np.array([2.0, 1.0, 0.05]) - 0.305) * induction

    cones = responses(tristimulus)
    a = cones @ np.array([11.0, -12.0, 1.0]) / 11.0
    b = cones @ np.array([1.0, 1.0, -2.0]) / 9.0
    hue = np.arctan2(b, a)
    lightness = 100.0 * (achromatic(cones) / achromatic(responses(white))) ** exponent
    strength = 50000.0 / 13.0 * induction * 0.25 * (np.cos(hue + 2.0) + 3.8) * np.hypot(a, b)
    chroma = (strength / (cones @ np.array([1.0, 1.0, 1.05]))) ** 0.9
    chroma *= np.sqrt(lightness / 100.0) * (1.64 - 0.29**n) ** 0.73
    colourfulness = np.log1p(0.0228 * chroma * level**0.25) / 0.0228
    return np.stack(
        [
            1.7 * lightness / (1.0 + 0.007 * lightness),
            colourfulness * np.cos(hue),
            colourfulness * np.sin(hue),
        ],
        axis=-1,
    )


def _polygon(corners: np.ndarray) -> float:
    """Area of a polygon, (n, 2)."""
    nexts = np.roll(corners, -1, axis=0)
    return 0.5 * float(np.sum(corners[:, 0] * nexts[:, 1] - corners[:, 1] * nexts[:, 0]))
