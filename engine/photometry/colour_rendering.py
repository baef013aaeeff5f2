"""The general colour rendering index Ra and its special ones. (CIE 13.3-1995)"""

from functools import lru_cache

import numpy as np

from ...libraries import spectra as tables
from .colour_temperature import colour_temperature
from .spectra import GRID, daylight, observer, planck

WARMEST_DAYLIGHT = 5000.0
"""Below it the reference is a blackbody, from it on daylight. [K] (CIE 13.3, 5.2)"""

GENERAL = 8
"""Samples whose mean is the general index."""


def colour_rendering(power) -> np.ndarray | None:
    """Special colour rendering indices R1 to R14; Ra is the mean of the first `GENERAL`.

    Parameters
    ----------
    power : (471,) array    Spectral power on `GRID`, on any scale.

    Returns
    -------
    (14,) float64 array or None
        None where the light has no colour temperature, so that there is nothing to compare it with. [-]
    """
    power = np.asarray(power, dtype=np.float64)
    white = power @ observer()
    found = colour_temperature(white)
    if found is None:
        return None
    temperature = found[0]
    is_daylight = temperature >= WARMEST_DAYLIGHT
    reference = (daylight if is_daylight else planck)(GRID, temperature)
    tested = _uniform(_samples(power), _cd(white), _cd(reference @ observer()))
    expected = _uniform(_samples(reference))
    # The reference's own white is the origin of both.
    origin = _uv(reference @ observer())
    shift = [
        np.column_stack([13.0 * w[:, None] * (uv - origin), w]) for uv, w in (tested, expected)
    ]
    return 100.0 - 4.6 * np.linalg.norm(shift[0] - shift[1], axis=1)


def general_index(power) -> float | None:
    """General colour rendering index Ra of spectral power on `GRID`; None as of `colour_rendering`. [-]"""
    found = colour_rendering(power)
    return None if found is None else float(found[:GENERAL].mean())


@lru_cache
def _weighted_samples() -> np.ndarray:
    """Radiance factors of the samples times the observer, (471, 14, 3)."""
    wavelengths, factors = tables.colour_samples(1995)
    columns = np.stack([np.interp(GRID, wavelengths, each) for each in factors.T], axis=1)
    return columns[:, :, None] * observer()[:, None, :]


def _samples(power: np.ndarray) -> np.ndarray:
    """X, Y, Z of the samples, that of the light itself being Y = 100. (14, 3)"""
    scale = 100.0 / (power @ observer()[:, 1])
    return scale * np.einsum("g,gsc->sc", power, _weighted_samples())


def _uv(tristimulus: np.ndarray) -> np.ndarray:
    total = tristimulus @ np.array([1.0, 15.0, 3.0])
    return tristimulus[..., :2] * np.array([4.0, 6.0]) / total[..., None]


def _cd(tristimulus: np.ndarray) -> np.ndarray:
    """Coordinates c, d of the adaptation by von Kries. (..., 3) -> (..., 2)"""
    u, v = np.moveaxis(_uv(tristimulus), -1, 0)
    return np.stack([4.0 - u - 10.0 * v, 1.708 * v + 0.404 - 1.481 * u], axis=-1) / v[..., None]


def _uniform(samples, light=None, reference=None) -> tuple[np.ndarray, np.ndarray]:
    """u, v of samples, adapted from the light to the reference, and W*."""
    uv = _uv(samples)
    if light is not None:
        c, d = np.moveaxis(_cd(samples) * (reference / light), -1, 0)
        total = 16.518 + 1.481 * c - d
        uv = (
            np.stack([10.872 + 0.404 * c - 4.0 * d, np.full_like(c, 5.520)], axis=-1)
            / total[:, None]
        )
    return uv, 25.0 * np.cbrt(samples[:, 1]) - 17.0
