"""Sky of light that is scattered many times, in four wavelengths, with a fit of what comes after the first time.

References
----------
F. García Liñán: article on skies by four wavelengths, 2024, https://fgarlin.com/posts/2024-12-06-spectral_sky/
S. Hillaire: Physically Based Sky, Atmosphere and Cloud Rendering in Frostbite, SIGGRAPH 2016 course
"""

from functools import lru_cache

import numpy as np

from .table import WIDTH, mirror

EARTH, THICKNESS = 6371.0, 100.0
"""Radius of the ground, and of the air above it. [km]"""

HIGHEST = 99_999.0
"""Greatest height to look from. [m]"""

STEPS = 64
"""Places along a ray."""

ROWS = 256

COSINES, HEIGHTS = 256, 64
"""Of the table of transmittances to the sun."""

ALBEDO = 0.3
"""Of the ground. [-]"""

FORWARD = 0.8
"""Mean cosine of what aerosols scatter. [-]"""

IRRADIANCE = np.array([1.679, 1.828, 1.986, 1.307])
"""By the sun outside the atmosphere, at 630, 560, 490 and 430 nm. [W/(m2 nm)]"""

AIR = np.array([6.605e-3, 1.067e-2, 1.842e-2, 3.156e-2])
"""Scattering by air at sea level. [1/km]"""

OZONE = np.array([3.472e-25, 3.914e-25, 1.349e-25, 11.03e-27]) * 334.5
"""Cross-section of ozone times its mean amount. [m2 DU]"""

AEROSOL_ABSORPTION = np.array([2.8722e-24, 4.6168e-24, 7.9706e-24, 1.3578e-23])
AEROSOL_SCATTERING = np.array([1.5908e-22, 1.7711e-22, 2.0942e-22, 2.4033e-22])
"""Cross-sections of urban aerosols. [m2]"""

AEROSOL, AEROSOL_BACKGROUND, AEROSOL_SCALE = 1.3681e20, 2e6, 0.73
"""Density of aerosols at sea level and everywhere, and the height in which there are less by a factor of e. [km]"""

MANY_TIMES = 0.02 * np.array([0.217, 0.347, 0.594, 1.0])
"""Fit of the light that comes from other places of the air. [1/sr]"""

TO_XYZ = np.array(
    [
        (53.386917738564668023, 22.981337506691024754, 0.0),
        (43.904844466369358263, 71.347795700053393866, 0.102506867965741307),
        (1.6137278251608962005, 18.422960591455485011, 31.742921188390805758),
        (20.762668673810577145, 2.3614213523314368527, 110.48009643252140334),
    ]
)
"""X, Y, Z of radiances at the four wavelengths. [nm]"""


@lru_cache(maxsize=8)
def make_table(elevation: float, altitude: float, air: float, dust: float, ozone: float):
    """Compute the table of a sky and of the ground under it.

    Parameters
    ----------
    elevation, altitude, air, dust, ozone : float    As of `single_scattering.make_table`; dust stands for all aerosols.

    Returns
    -------
    (256, 512, 3) float32 array    X, Y, Z without the factor of 683 lm/W. [W/(m2 sr)]
    """
    amounts = air, dust, ozone
    start = EARTH + float(np.clip(altitude, 1.0, HIGHEST)) / 1000.0
    azimuth = 2.0 * np.pi * (np.arange(WIDTH // 2) + 0.5) / WIDTH
    place = 2.0 * (np.arange(ROWS) + 0.5) / ROWS - 1.0
    heights = 0.5 * np.pi * np.copysign(place**2, place)
    passed = transmittances(amounts)
    half = np.empty((ROWS, WIDTH // 2, 3))
    for row, height in enumerate(heights):
        half[row] = _row(height, azimuth, start, elevation, amounts, passed) @ TO_XYZ
    table = mirror(half).astype(np.float32)
    table.flags.writeable = False
    return table


def sun_transmittance(elevation: float, altitude: float, air: float, dust: float, ozone: float):
    """Return which part of the light arrives from a sun. (4,) [-]"""
    height = np.array([float(np.clip(altitude, 1.0, HIGHEST)) / 1000.0])
    return _to_sun(np.array([np.sin(elevation)]), height, (air, dust, ozone))[0, 0]


@lru_cache(maxsize=4)
def transmittances(amounts) -> np.ndarray:
    """Return which part of the sun's light arrives, by height and by the cosine of its zenith angle. (64, 256, 4) [-]"""
    cosines = np.linspace(-1.0, 1.0, COSINES)
    return _to_sun(cosines, np.linspace(0.0, THICKNESS, HEIGHTS), amounts).astype(np.float32)


def _to_sun(cosines, heights, amounts) -> np.ndarray:
    """(c,), (h,) [km] -> (h, c, 4)"""
    made = np.empty((len(heights), len(cosines), 4))
    for i, start in enumerate(EARTH + heights):
        climb = start * cosines
        length = -climb + np.sqrt(np.maximum(climb**2 - start**2 + (EARTH + THICKNESS) ** 2, 0.0))
        part = length / STEPS
        along = part[:, None] * (np.arange(STEPS) + 0.5)
        radius = np.sqrt(start**2 + 2.0 * along * climb[:, None] + along**2)
        amount = _coefficients(radius - EARTH, amounts)
        depth = sum(each.sum(axis=1) * part[:, None] for each in amount)
        made[i] = np.exp(-depth)
    return made


def _coefficients(height, amounts) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Scattering by air and by aerosols, and absorption, at heights above sea level. (...) [km] -> 3 of (..., 4) [1/km]"""
    height = np.maximum(height, 0.0)[..., None]
    air, dust, ozone = amounts
    log_height = np.log(np.maximum(height, 1e-4))
    layer = 3.78547397e20 * np.exp(-5.55555555 * (log_height - 3.22261) ** 2 - log_height)
    aerosols = dust * AEROSOL * (np.exp(-height / AEROSOL_SCALE) + AEROSOL_BACKGROUND / AEROSOL)
    scattered_by_air = air * AIR * np.exp(-0.07771971 * height**1.16364243)
    absorbed = aerosols * AEROSOL_ABSORPTION + ozone * OZONE * layer
    return scattered_by_air, aerosols * AEROSOL_SCATTERING, absorbed


def _row(height, azimuth, start, elevation, amounts, passed) -> np.ndarray:
    """Light along rays of one elevation, the sun at an azimuth of half a turn. (n,) -> (n, 4) [W/(m2 sr nm)]"""
    rise, plan = np.sin(height), np.cos(height)
    part = _length(start, rise) / STEPS
    along = part * (np.arange(STEPS) + 0.5)
    radius = np.sqrt(start**2 + 2.0 * along * start * rise + along**2)
    by_air, by_aerosols, absorbed = _coefficients(radius - EARTH, amounts)
    extinction = by_air + by_aerosols + absorbed
    kept = np.exp(-part * extinction)
    before = np.cumprod(np.concatenate([np.ones((1, 4)), kept[:-1]]), axis=0)
    weights = before * (1.0 - kept) / np.maximum(extinction, 1e-7)
    # At each place of each ray. (STEPS, n)
    cosine = -plan * np.cos(azimuth) * np.cos(elevation) + rise * np.sin(elevation)
    to_sun = (start * np.sin(elevation) + along[:, None] * cosine) / radius[:, None]
    arriving, often = _find_arriving(passed, radius, to_sun.astype(np.float32))
    by_both = by_air + by_aerosols
    light = [
        np.einsum("wsn,sw->nw", each, (weights * amount).astype(np.float32))
        for each, amount in ((arriving, by_air), (arriving, by_aerosols), (often, by_both))
    ]
    air_phase = 3.0 / (16.0 * np.pi) * (1.0 + cosine**2)
    spread = 1.0 + FORWARD**2 - 2.0 * FORWARD * cosine
    aerosol_phase = (1.0 - FORWARD**2) / (4.0 * np.pi * spread**1.5)
    once = light[0] * air_phase[:, None] + light[1] * aerosol_phase[:, None]
    return (once + light[2]) * IRRADIANCE


def _length(start: float, rise: float) -> float:
    """Length of a ray to the ground or to the end of the air. [km]"""
    climb = start * rise
    # Near the ground the digits of Blender's single precision count.
    above = np.float32(start) ** 2 - np.float32(EARTH) ** 2
    ground = climb**2 - float(above)
    if climb <= 0.0 and ground >= 0.0:
        return float(-climb - np.sqrt(ground))
    return float(-climb + np.sqrt(climb**2 - start**2 + (EARTH + THICKNESS) ** 2))


def _find_arriving(passed, radius, cosine) -> tuple[np.ndarray, np.ndarray]:
    """Light at places from the sun, and from the ground and other places of the air, for an irradiance of 1.

    Parameters
    ----------
    passed : (h, c, 4) array    As of `transmittances`.
    radius : (s,) array    Distance of the places from the Earth's middle. [km]
    cosine : (s, n) float32 array    Of the sun's zenith angle there.

    Returns
    -------
    (4, s, n) float32 array    [-]
    (4, s, n) float32 array    [1/sr]
    """
    level = np.clip((radius - EARTH) / THICKNESS, 0.0, 1.0) * (HEIGHTS - 1)
    low = np.minimum(level.astype(int), HEIGHTS - 2)
    rest = (level - low).astype(np.float32)[:, None, None]
    lines = passed[low] + rest * (passed[low + 1] - passed[low])
    x = np.clip(0.5 * cosine + 0.5, 0.0, 1.0) * np.float32(COSINES - 1)
    left = np.minimum(x.astype(int), COSINES - 2)
    rest = x - left.astype(np.float32)
    own = left + COSINES * np.arange(len(radius))[:, None]
    from_sun = _between(np.moveaxis(lines, -1, 0), own, rest)
    at_ground = _between(passed[0].T, left, rest)
    seen = 2.0 * np.pi * (1.0 - np.sqrt(np.maximum(1.0 - (EARTH / radius) ** 2, 0.0)))
    upright = lines[:, -1]
    from_ground = np.zeros_like(upright)
    # Of what lets nothing pass there is no part.
    np.divide(seen[:, None] * passed[0, -1], upright, out=from_ground, where=upright > 0.0)
    share = (ALBEDO / (4.0 * np.pi**2) * from_ground).astype(np.float32)
    fit = np.float32(1.0) / (1.0 + 5.0 * np.exp(np.float32(-17.92) * cosine))
    often = share.T[:, :, None] * (at_ground * cosine)
    often += MANY_TIMES.astype(np.float32)[:, None, None] * fit
    return from_sun, often


def _between(lines, left, rest) -> np.ndarray:
    """Interpolate in lines that follow each other. (4, ...), (s, n) number of a value, (s, n) -> (4, s, n)"""
    made = []
    for line in map(np.ascontiguousarray, lines):
        first = line.take(left)
        rise = line.take(left + 1)
        rise -= first
        rise *= rest
        made.append(np.add(first, rise, out=first))
    return np.stack(made)
