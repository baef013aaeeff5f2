"""Spectrum and illuminance of a cloudless sky, by the turbidity of the air, the ground's albedo and the height of the sun.

The model is that of Mitsuba's spectral sky, which is known for wavelengths of 320 to 720 nm, turbidities of 1 to 10 and a
sun above the horizon. Here the sky is one light: its spectrum is that of the irradiance of a horizontal plane.

References
----------
L. Hosek, A. Wilkie: An Analytic Model for Full Spectral Sky-Dome Radiance, ACM Transactions on Graphics 31(4), 2012, 95,
doi:10.1145/2185520.2185591
"""

from functools import lru_cache

import numpy as np

from ...libraries import skies
from ..errors import SceneError
from ..photometry.spectra import GRID, evaluate_emission, luminous_weight
from ..scene.spectrum import Spectrum, Tabulated
from .atmosphere.hosek_wilkie import find_radiance

TURBIDITIES = (1.0, 10.0)
"""Least and largest turbidity that the model knows: clean air, and haze."""

ROWS, COLUMNS = 24, 32
"""Directions by which a sky is integrated, by Gauss: of each part of the elevation, as the sun divides it, and azimuth."""


def find_irradiance(elevation: float, turbidity: float, albedo: float = 0.0) -> np.ndarray:
    """Irradiance of a horizontal plane by a cloudless sky, without the sun.

    Parameters
    ----------
    elevation : float    Of the sun, above 0 to 90. [degree]
    turbidity : float    1 to 10. [-]
    albedo : float    Of the ground, 0 to 1. [-]

    Returns
    -------
    (11,) array    At `skies.WAVELENGTHS`. [W/(m2 nm)]

    Raises
    ------
    SceneError    Sun, air or ground is beyond what the model knows.
    """
    if not 0.0 < elevation <= 90.0:
        raise SceneError(
            f"the spectrum of a clear sky is not known for a sun {elevation:.1f} degrees high, expected above 0 to 90"
        )
    if not TURBIDITIES[0] <= turbidity <= TURBIDITIES[1]:
        raise SceneError(
            f"the spectrum of a clear sky is not known for the turbidity {turbidity:g}, expected 1 to 10"
        )
    if not 0.0 <= albedo <= 1.0:
        raise SceneError(f"the albedo of the ground is {albedo:g}, expected 0 to 1")
    return _integrate(float(elevation), float(turbidity), float(albedo))


def find_illuminance(elevation: float, turbidity: float, albedo: float = 0.0) -> float:
    """Illuminance of a horizontal plane by a cloudless sky without the sun. [lx]

    Parameters and errors are those of `find_irradiance`. Beyond 720 nm, where the model ends, less than 0.1 % is missing.
    """
    return luminous_weight(find_spectrum(elevation, turbidity, albedo))


def find_spectrum(elevation: float, turbidity: float, albedo: float = 0.0) -> Tabulated:
    """Spectrum of the light of a cloudless sky; parameters and errors as of `find_irradiance`."""
    return Tabulated(
        np.array(skies.WAVELENGTHS, dtype=np.float64),
        find_irradiance(elevation, turbidity, albedo),
        f"clear sky of turbidity {turbidity:g}, sun {elevation:.1f} degrees high",
    )


def mix_spectra(clear: Spectrum, other: Spectrum, share: float, name: str = "") -> Tabulated:
    """Return the spectrum of two lights together.

    Parameters
    ----------
    clear, other : Spectrum
    share : float    Part of the illuminance that the other one gives, 0 to 1. [-]
    name : str    For reports.
    """
    total = sum(
        part * evaluate_emission(spectrum, GRID) / luminous_weight(spectrum)
        for spectrum, part in ((clear, 1.0 - share), (other, share))
    )
    return Tabulated(GRID.copy(), total, name)


@lru_cache(maxsize=64)
def _integrate(elevation: float, turbidity: float, albedo: float) -> np.ndarray:
    height = np.radians(elevation)
    directions, weights = _directions(height)
    sun = np.array([np.cos(height), 0.0, np.sin(height)])
    made = find_radiance(directions, sun, turbidity, albedo) @ weights
    made.flags.writeable = False
    return made


def _directions(height: float) -> tuple[np.ndarray, np.ndarray]:
    """Directions, and what they count for in a horizontal plane's irradiance. (n, 3), (n,) [sr]"""
    node, weight = np.polynomial.legendre.leggauss(ROWS)
    elevations, areas = [], []
    for low, high in ((0.0, height), (height, 0.5 * np.pi)):
        # Places crowd at both ends: at the sun, and where the air is thick.
        share = 0.5 * (high - low)
        elevations.append(0.5 * (low + high) + share * np.sin(0.5 * np.pi * node))
        areas.append(weight * share * 0.5 * np.pi * np.cos(0.5 * np.pi * node))
    elevation, area = np.concatenate(elevations), np.concatenate(areas)
    node, weight = np.polynomial.legendre.leggauss(COLUMNS)
    share = 0.5 * (1.0 + node)
    azimuth, width = np.pi * share**2, np.pi * share * weight
    plan, sine = np.cos(elevation)[:, None], np.sin(elevation)[:, None]
    made = np.stack(
        np.broadcast_arrays(plan * np.cos(azimuth), plan * np.sin(azimuth), sine), axis=-1
    )
    # Both halves of the sky are alike.
    weights = (area * np.sin(elevation) * np.cos(elevation))[:, None] * 2.0 * width
    return made.reshape(-1, 3), weights.reshape(-1)
