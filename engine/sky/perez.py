"""The all-weather sky of Perez: luminances and illuminances of an hour from the irradiances by its sun and its sky.

References
----------
R. Perez, R. Seals, J. Michalsky: All-weather model for sky luminance distribution, Solar Energy 50(3), 1993, 235-245,
doi:10.1016/0038-092X(93)90017-I, with its erratum, Solar Energy 51(5), 1993, 423
R. Perez, P. Ineichen, R. Seals, J. Michalsky, R. Stewart: Modeling daylight availability and irradiance components from
direct and global irradiance, Solar Energy 44(5), 1990, 271-289, doi:10.1016/0038-092X(90)90055-H
F. Kasten: A new table and approximation formula for the relative optical air mass, Archiv für Meteorologie, Geophysik und
Bioklimatologie B 14, 1965, 206-223, doi:10.1007/BF02248840
"""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..scene.light import PerezSky
from .pattern import Pattern, unit

SOLAR_CONSTANT = 1367.0
"""Irradiance by the sun at one astronomical unit, as the model was fitted with. [W/m2]"""

CLEARNESS_BOUNDS = (1.065, 1.230, 1.500, 1.950, 2.800, 4.500, 6.200)
"""Clearness at which each class after the first begins. [-]"""

LUMINANCE = np.array(
    [
        *[1.3525, -0.2576, -0.2690, -1.4366, -0.7670, 0.0007, 1.2734, -0.1233, 2.8000, 0.6004],
        *[1.2375, 1.0000, 1.8734, 0.6297, 0.9738, 0.2809, 0.0356, -0.1246, -0.5718, 0.9938],
        *[-1.2219, -0.7730, 1.4148, 1.1016, -0.2054, 0.0367, -3.9128, 0.9156, 6.9750, 0.1774],
        *[6.4477, -0.1239, -1.5798, -0.5081, -1.7812, 0.1080, 0.2624, 0.0672, -0.2190, -0.4285],
        *[-1.1000, -0.2515, 0.8952, 0.0156, 0.2782, -0.1812, -4.5000, 1.1766, 24.7219, -13.0812],
        *[-37.7000, 34.8438, -5.0000, 1.5218, 3.9229, -2.6204, -0.0156, 0.1597, 0.4199, -0.5562],
        *[-0.5484, -0.6654, -0.2672, 0.7117, 0.7234, -0.6219, -5.6812, 2.6297, 33.3389, -18.3000],
        *[-62.2500, 52.0781, -3.5000, 0.0016, 1.1477, 0.1062, 0.4659, -0.3296, -0.0876, -0.0329],
        *[-0.6000, -0.3566, -2.5000, 2.3250, 0.2937, 0.0496, -5.6812, 1.8415, 21.0000, -4.7656],
        *[-21.5906, 7.2492, -3.5000, -0.1554, 1.4062, 0.3988, 0.0032, 0.0766, -0.0656, -0.1294],
        *[-1.0156, -0.3670, 1.0078, 1.4051, 0.2875, -0.5328, -3.8500, 3.3750, 14.0000, -0.9999],
        *[-7.1406, 7.5469, -3.4000, -0.1078, -1.0750, 1.5702, -0.0672, 0.4016, 0.3017, -0.4844],
        *[-1.0000, 0.0211, 0.5025, -0.5119, -0.3000, 0.1922, 0.7023, -1.6317, 19.0000, -5.0000],
        *[1.2438, -1.9094, -4.0000, 0.0250, 0.3844, 0.2656, 1.0468, -0.3788, -2.4517, 1.4656],
        *[-1.0500, 0.0289, 0.4260, 0.3590, -0.3250, 0.1156, 0.7781, 0.0025, 31.0625, -14.5000],
        *[-46.1148, 55.3750, -7.2312, 0.4050, 13.3500, 0.6234, 1.5000, -0.6426, 1.8564, 0.5636],
    ]
).reshape(8, 5, 4)
"""Four numbers for each of the coefficients a to e, by class (Perez and others 1993, table 1)."""

DIFFUSE_EFFICACY = np.array(
    [
        (97.24, -0.46, 12.00, -8.91),
        (107.22, 1.15, 0.59, -3.95),
        (104.97, 2.96, -5.53, -8.77),
        (102.39, 5.59, -13.95, -13.90),
        (100.71, 5.94, -22.75, -23.74),
        (106.42, 3.83, -36.15, -28.83),
        (141.88, 1.90, -53.24, -14.03),
        (152.23, 0.35, -45.27, -7.98),
    ]
)
"""Luminous efficacy of the sky by class (Perez and others 1990, table 4). [lm/W]"""

DIRECT_EFFICACY = np.array(
    [
        (57.20, -4.55, -2.98, 117.12),
        (98.99, -3.46, -1.21, 12.38),
        (109.83, -4.90, -1.71, -8.81),
        (110.34, -5.84, -1.99, -4.56),
        (106.36, -3.97, -1.75, -6.16),
        (107.19, -1.25, -1.51, -26.73),
        (105.75, 0.77, -1.26, -34.44),
        (101.18, 1.58, -1.10, -8.29),
    ]
)
"""Luminous efficacy of the sun by class (Perez and others 1990, table 4). [lm/W]"""

CLEAREST = 12.0
"""Greatest clearness that is told apart. [-]"""

BRIGHTNESS = (0.01, 0.6)
"""Range of the brightness that the model was fitted to. [-]"""

LEAST_BRIGHTNESS = 0.2
"""Of the luminances of skies between overcast and clear (below), as the model was corrected by one of its authors: darker
ones would be brightest at the horizon without bound. [-]"""

CORRECTED = (1.065, 2.8)
"""Clearness of those skies. [-]"""

LOWEST = 0.01
"""Sine of the elevation below which the gradation is taken as even, as other programs have it. [-]"""


@dataclass(frozen=True, eq=False)
class DaylightHours:
    """Sun and sky in photometric terms. Arrays of one shape.

    Parameters
    ----------
    clearness, brightness : array    The model's epsilon and Delta, within its range. [-]
    direct_normal : array    Illuminance by the sun of a plane that faces it. [lx]
    diffuse_horizontal : array    Illuminance of a horizontal plane by the sky. [lx]
    """

    clearness: np.ndarray
    brightness: np.ndarray
    direct_normal: np.ndarray
    diffuse_horizontal: np.ndarray


def air_mass(elevation) -> np.ndarray:
    """Return the relative optical air mass at the pressure of the sea. [degree -> -], elevation of at least 0"""
    elevation = np.maximum(np.asarray(elevation, dtype=np.float64), 0.0)
    return 1.0 / (np.sin(np.radians(elevation)) + 0.15 * (elevation + 3.885) ** -1.253)


def precipitable_water(dew_point) -> np.ndarray:
    """Return the water above a place from the dew point at the surface. [degree Celsius -> kg/m2]"""
    return 10.0 * np.exp(0.07 * np.asarray(dew_point, dtype=np.float64) - 0.075)


def find_daylight(
    direct_normal, diffuse_horizontal, elevation, water=20.0, distance=1.0
) -> DaylightHours:
    """Return clearness, brightness and illuminances from irradiances.

    Parameters
    ----------
    direct_normal, diffuse_horizontal : array    Irradiance by the sun of a plane that faces it, and of a horizontal plane by
        the sky. [W/m2]
    elevation : array    Of the sun, without refraction. [degree]
    water : array    Precipitable water, as `precipitable_water` estimates it; without it that of Radiance is taken. [kg/m2]
    distance : array    Of the sun. [astronomical unit]

    Returns
    -------
    DaylightHours    Where the sun is not above the horizon its own illuminance is 0, and the sky is that of a sun at the
        horizon. A missing (NaN) irradiance makes the hour NaN.

    Raises
    ------
    SceneError    An irradiance is negative, or there is no water or distance.
    """
    direct, diffuse, elevation, water, distance = np.broadcast_arrays(
        *(np.asarray(x, dtype=np.float64) for x in (direct_normal, diffuse_horizontal)),
        *(np.asarray(x, dtype=np.float64) for x in (elevation, water, distance)),
    )
    if (direct < 0.0).any() or (diffuse < 0.0).any():
        raise SceneError("an irradiance of the weather is negative")
    if not ((water >= 0.0).all() and (distance > 0.0).all() and (np.abs(elevation) <= 90.0).all()):
        raise SceneError(
            "the sun's elevation or distance or the water in the air is out of its range or missing"
        )
    direct = np.where(elevation > 0.0, direct, np.where(np.isnan(direct), np.nan, 0.0))
    is_known = np.isfinite(direct) & np.isfinite(diffuse)
    sun, sky = np.where(is_known, direct, 0.0), np.where(is_known, diffuse, 0.0)
    height = np.maximum(elevation, 0.0)
    zenith = np.radians(90.0 - height)
    cubed = 1.041 * zenith**3
    # A sky that gives nothing beside a sun that shines is as clear as can be.
    ratio = np.where(sky > 0.0, sun / np.maximum(sky, 1e-9), np.where(sun > 0.0, np.inf, 0.0))
    clearness = np.minimum(1.0 + ratio / (1.0 + cubed), CLEAREST)
    brightness = np.clip(
        air_mass(height) * sky * distance**2 / SOLAR_CONSTANT, BRIGHTNESS[0], BRIGHTNESS[1]
    )
    kind = find_class(clearness)
    cosine, centimetres = np.cos(zenith), water / 10.0
    a, b, c, d = np.moveaxis(DIFFUSE_EFFICACY[kind], -1, 0)
    of_sky = a + b * centimetres + c * cosine + d * np.log(brightness)
    a, b, c, d = np.moveaxis(DIRECT_EFFICACY[kind], -1, 0)
    of_sun = a + b * centimetres + c * np.exp(5.73 * zenith - 5.0) + d * brightness
    found = (
        clearness,
        brightness,
        sun * np.maximum(of_sun, 0.0),
        sky * np.maximum(of_sky, 0.0),
    )
    return DaylightHours(*(np.where(is_known, each, np.nan) for each in found))


def find_class(clearness) -> np.ndarray:
    """Return which of the eight classes a clearness is of, 0 overcast to 7 clear. [-]"""
    return np.searchsorted(CLEARNESS_BOUNDS, np.asarray(clearness, dtype=np.float64), side="right")


def coefficients(clearness, brightness, zenith) -> tuple[np.ndarray, ...]:
    """Return a to e of the luminances.

    Parameters
    ----------
    clearness, brightness : array    [-]
    zenith : array    Zenith angle of the sun. [rad]

    Returns
    -------
    tuple of five arrays    [-]
    """
    kind, clearness = find_class(clearness), np.asarray(clearness, dtype=np.float64)
    brightness = np.clip(brightness, *BRIGHTNESS)
    is_corrected = (clearness > CORRECTED[0]) & (clearness < CORRECTED[1])
    brightness = np.where(is_corrected, np.maximum(brightness, LEAST_BRIGHTNESS), brightness)
    x = np.moveaxis(LUMINANCE[kind], (-2, -1), (0, 1))
    a, b, c, d, e = x[:, 0] + x[:, 1] * zenith + brightness * (x[:, 2] + x[:, 3] * zenith)
    (c1, c2, c3, c4), (d1, d2, d3, d4) = np.moveaxis(
        np.broadcast_to(LUMINANCE[0, 2:4], (*np.shape(kind), 2, 4)), (-2, -1), (0, 1)
    )
    overcast_c = np.exp(np.maximum(brightness * (c1 + c2 * zenith), 0.0) ** c3) - c4
    overcast_d = -np.exp(brightness * (d1 + d2 * zenith)) + d3 + brightness * d4
    c, d = np.where(kind == 0, overcast_c, c), np.where(kind == 0, overcast_d, d)
    # Above 0 the horizon would have no bound: 3 of 13 337 hours of three years of weather, a bright haze before a low sun.
    return a, np.minimum(b, 0.0), c, d, e


def pattern_of(sky: PerezSky) -> Pattern:
    """Return the luminances of a sky up to a factor."""
    sun = unit(sky.towards_sun)
    zenith = float(np.arccos(np.clip(sun[2], 0.0, 1.0)))
    a, b, c, d, e = map(float, coefficients(sky.clearness, sky.brightness, zenith))
    return Pattern(a, b, c, d, e, edge=0.0, level=1.0, base=0.0, rise=0.0, floor=LOWEST, sun=sun)


def check_numbers(sky: PerezSky) -> None:
    """Refuse numbers that are none of the model's.

    Raises
    ------
    SceneError    Names what is wrong.
    """
    if not (np.isfinite(sky.clearness) and sky.clearness >= 1.0):
        raise SceneError(f"the sky's clearness is {sky.clearness}, expected a number of at least 1")
    if not (np.isfinite(sky.brightness) and sky.brightness > 0.0):
        raise SceneError(f"the sky's brightness is {sky.brightness}, expected a number above 0")
    if not np.asarray(sky.towards_sun)[2] >= 0.0:
        raise SceneError("the sun of a sky by the model of Perez is below the horizon")
