"""Sky and sun of an hour as items of a scene."""

import numpy as np

from ..scene.light import Output, PerezSky, Quantity, SunLight
from ..scene.spectrum import Constant, Spectrum
from .perez import DaylightHours, find_daylight, precipitable_water
from .solar_position import RADIUS
from .weather import Weather, WeatherHours

EVEN = Constant(1.0)
"""Spectrum of equal energy."""

SUN_ID = "sun of the hour"
"""Of the sun as an item of a scene."""


def find_daylight_hours(weather: Weather, hours: WeatherHours) -> DaylightHours:
    """Return sun and sky of a weather file's records in photometric terms.

    The water in the air is estimated from the dew point, as the model of Perez was fitted with; where that is missing, and
    in files that have none, 20 kg/m2 stand for it, as Radiance takes always.

    Parameters
    ----------
    weather : Weather
    hours : WeatherHours    Of the same records.

    Returns
    -------
    DaylightHours    (n,)
    """
    dew_point = weather.values.get("dew_point", np.full(len(weather), np.nan))
    water = np.where(np.isnan(dew_point), 20.0, precipitable_water(dew_point))
    return find_daylight(
        hours.direct_normal,
        hours.diffuse_horizontal,
        hours.sun.elevation,
        water,
        hours.sun.distance,
    )


def make_hour(
    hours: WeatherHours,
    daylight: DaylightHours,
    index: int,
    north: float = 0.0,
    ground_reflectance: float = 0.0,
    sky_spectrum: Spectrum = EVEN,
    sun_spectrum: Spectrum = EVEN,
) -> tuple[PerezSky | None, SunLight | None]:
    """Return sky and sun of one record.

    Parameters
    ----------
    hours, daylight : WeatherHours and DaylightHours    Of the same records.
    index : int    Of the record, from 0.
    north : float    As of `Place`. [degree]
    ground_reflectance : float    As of `CieSky`. [-]
    sky_spectrum, sun_spectrum : Spectrum    Relative spectral powers.

    Returns
    -------
    (PerezSky or None, SunLight or None)    None where it gives no light, or where the record lacks it. The sun of a sky in
        twilight stands on the horizon.
    """
    illuminance = float(daylight.diffuse_horizontal[index])
    towards = hours.sun.directions(north)[index]
    sky = sun = None
    if illuminance > 0.0:
        level = np.array([towards[0], towards[1], max(towards[2], 0.0)])
        sky = PerezSky(
            float(daylight.clearness[index]),
            float(daylight.brightness[index]),
            level / np.linalg.norm(level),
            illuminance,
            ground_reflectance,
            sky_spectrum,
        )
    direct = float(daylight.direct_normal[index])
    if direct > 0.0:
        output = Output(Quantity.ILLUMINANCE, direct, sun_spectrum)
        sun = SunLight(SUN_ID, "sun", output, -towards, 2.0 * np.radians(RADIUS))
    return sky, sun
