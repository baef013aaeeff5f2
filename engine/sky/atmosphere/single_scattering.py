"""Sky of light that is scattered once, by air and dust above a round Earth, in 21 wavelengths.

References
----------
T. Nishita, T. Sirai, K. Tadamura, E. Nakamae: Display of the Earth Taking into Account Atmospheric Scattering,
SIGGRAPH 1993, 175-182, doi:10.1145/166117.166140
"""

from functools import lru_cache

import numpy as np

from ....libraries import skies, spectra
from .table import WIDTH, mirror

EARTH, TOP = 6_360_000.0, 6_420_000.0
"""Radii of the ground and of the end of the air. [m]"""

HIGHEST = 59_999.0
"""Greatest height to look from. [m]"""

AIR_SCALE, DUST_SCALE = 8000.0, 1200.0
"""Heights in which there is less air and less dust by a factor of e. [m]"""

OZONE_MIDDLE, OZONE_REACH = 25_000.0, 15_000.0
"""Height of the ozone layer's middle and from there to its ends. [m]"""

DUST = 2e-5
"""Scattering by dust at sea level. [1/m]"""

DUST_EXTINCTION = 1.11
"""Extinction over scattering of dust. [-]"""

FORWARD = 0.76
"""Mean cosine of what dust scatters. [-]"""

STEPS = 32
"""Places along a ray of view at which light is scattered."""

ROWS = 128
"""Rows of the table above the horizon."""

GROUND_DEPTH = 0.4
"""Sine of the depth below the horizon at which its light has faded out."""

_LAST = 25.0
"""Where a ray to the sun ends on the own scale of a Gauss-Laguerre rule."""

_PLACES, _WEIGHTS = np.polynomial.laguerre.laggauss(8)
"""Of that rule, which leaves out the factor exp(-x)."""


@lru_cache(maxsize=8)
def make_table(
    elevation: float, altitude: float, air: float, dust: float, ozone: float, is_early: bool = False
):
    """Compute the table of a sky whose light at the horizon fades out below it.

    Parameters
    ----------
    elevation : float    Of the sun. [rad]
    altitude : float    Of the eye above sea level. [m]
    air, dust, ozone : float    Densities relative to a usual atmosphere. [-]
    is_early : bool
        As Blender had it before version 5: rows lie higher by a part of 256, and below the horizon its row is kept, to be
        faded by the direction.

    Returns
    -------
    (256, 512, 3) float32 array    X, Y, Z without the factor of 683 lm/W. [W/(m2 sr)]
    """
    half = np.zeros((2 * ROWS, WIDTH // 2, 3))
    longitude = 2.0 * np.pi * np.arange(WIDTH // 2) / WIDTH - np.pi
    start = EARTH + float(np.clip(altitude, 1.0, HIGHEST))
    sun = np.array([np.cos(elevation), 0.0, np.sin(elevation)])
    stretch = 1.0 + 0.5 / ROWS if is_early else 1.0
    latitudes = 0.5 * np.pi * stretch * (np.arange(ROWS + 1) / ROWS) ** 2
    for row, latitude in enumerate(latitudes[:-1]):
        half[ROWS + row] = _row(latitude, longitude, start, sun, (air, dust, ozone))
    faded = np.ones(ROWS) if is_early else fade(-np.sin(latitudes[:0:-1]))
    half[:ROWS] = half[ROWS] * faded[:, None, None]
    table = mirror(half).astype(np.float32)
    table.flags.writeable = False
    return table


def _row(latitude, longitude, start, sun, amounts) -> np.ndarray:
    """Light along rays of one elevation. (n,) -> (n, 3)"""
    _, irradiance, rayleigh, _ = skies.atmosphere().T
    rise, plan = np.sin(latitude), np.cos(latitude)
    length = _way_out(start, start * rise)
    part = length / STEPS
    along = part * (np.arange(STEPS) + 0.5)
    radius = np.sqrt(start**2 + 2.0 * along * start * rise + along**2)
    density = np.stack(densities(radius - EARTH)) * np.array(amounts)[:, None]
    before = np.cumsum(density, axis=1) * part
    # Towards the sun, at each place of each ray. (n, STEPS)
    cosine = plan * np.cos(longitude) * sun[0] + rise * sun[2]
    climb = start * sun[2] + along * cosine[:, None]
    is_lit = (sun[2] >= 0.0) | (climb**2 < radius**2 - EARTH**2)
    onwards = np.array(amounts)[:, None, None] * depth_to_sun(radius, climb)
    depths = (before[:, None] + onwards).astype(np.float32)
    passed = np.exp(-np.tensordot(depths, np.stack(extinction()).astype(np.float32), axes=(0, 0)))
    passed *= is_lit[..., None]
    air = np.einsum("nsw,s->nw", passed, density[0]) * rayleigh
    dust = np.einsum("nsw,s->nw", passed, density[1]) * DUST
    light = air * _air_phase(cosine)[:, None] + dust * _dust_phase(cosine)[:, None]
    return to_xyz(light * irradiance * part)


def fade(height) -> np.ndarray:
    """Part of the horizon's light that is left at a sine of the elevation, at most 0. (...) -> (...)"""
    return np.maximum(1.0 + np.asarray(height) / GROUND_DEPTH, 0.0) ** 3


def sun_light(elevation: float, altitude: float, air: float, dust: float) -> np.ndarray:
    """Return X, Y, Z of a sun's light that passed the air; a sun below the level is taken at it, and ozone takes none.

    Parameters
    ----------
    elevation, altitude, air, dust : float    As of `make_table`.

    Returns
    -------
    (3,) float64 array    Irradiances without the factor of 683 lm/W. [W/m2]
    """
    radius = np.array(EARTH + float(np.clip(altitude, 1.0, HIGHEST)))
    depths = depth_to_sun(radius, radius * np.sin(max(elevation, 0.0)))
    by_air, by_dust, _ = extinction()
    passed = np.exp(-(air * depths[0] * by_air + dust * depths[1] * by_dust))
    return to_xyz(skies.atmosphere()[:, 1] * passed)


def densities(height) -> tuple:
    """Air, dust and ozone at heights above sea level relative to where there is most. (...) [m] -> 3 of (...) [-]"""
    ozone = np.maximum(0.0, 1.0 - np.abs(height - OZONE_MIDDLE) / OZONE_REACH)
    # Rays to a sun behind the Earth cross it, where nothing is to overflow.
    return *(np.exp(np.minimum(-height / scale, 50.0)) for scale in (AIR_SCALE, DUST_SCALE)), ozone


def extinction() -> tuple[np.ndarray, ...]:
    """Extinction by air, dust and ozone of density 1 by wavelength. 3 of (21,) [1/m]"""
    _, _, rayleigh, ozone = skies.atmosphere().T
    return rayleigh, np.full_like(rayleigh, DUST_EXTINCTION * DUST), ozone


def depth_to_sun(radius, climb) -> np.ndarray:
    """Integrals of the densities from places out of the atmosphere.

    Parameters
    ----------
    radius : (...) array    Distance of the places from the Earth's middle. [m]
    climb : (...) array    The same times the cosine of the ray to the vertical. [m]

    Returns
    -------
    (3, ...) array    Of air, dust and ozone. [m]
    """
    length = _way_out(radius, climb)
    total = np.zeros((3, *np.broadcast(radius, climb).shape))
    for place, weight in zip(_PLACES, _WEIGHTS * np.exp(_PLACES), strict=True):
        way = place / _LAST * length
        height = np.sqrt(radius**2 + 2.0 * way * climb + way**2) - EARTH
        total += weight / _LAST * np.stack(densities(height))
    return total * length


def _way_out(radius, climb) -> np.ndarray:
    """Distance to the end of the air. [m]"""
    return np.sqrt(climb**2 - radius**2 + TOP**2) - climb


def to_xyz(spectrum) -> np.ndarray:
    """X, Y, Z of spectra on the atmosphere's wavelengths. (..., 21) [W/(m2 sr nm)] -> (..., 3) [W/(m2 sr)]"""
    wavelengths, observer = spectra.observer()
    used = np.searchsorted(wavelengths, skies.atmosphere()[:, 0])
    return spectrum @ observer[used] * (wavelengths[used[1]] - wavelengths[used[0]])


def _air_phase(cosine):
    return 3.0 / (16.0 * np.pi) * (1.0 + cosine**2)


def _dust_phase(cosine):
    square = FORWARD**2
    shape = (1.0 + cosine**2) / (1.0 + square - 2.0 * FORWARD * cosine) ** 1.5
    return 3.0 * (1.0 - square) / (8.0 * np.pi * (2.0 + square)) * shape
