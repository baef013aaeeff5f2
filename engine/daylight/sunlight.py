"""Hours of sunlight that points get: of one day under a cloudless sky, and of a year.

References
----------
World Meteorological Organization: Guide to instruments and methods of observation, WMO-No. 8, volume I, chapter 8: the sun
shines where its direct irradiance is above 120 W/m2
"""

from dataclasses import dataclass
from datetime import date, datetime, time, timedelta

import numpy as np

from ..errors import SceneError
from ..sky.place import Place, from_local
from ..sky.solar_position import SunPositions, find_sun

SUNSHINE = 120.0
"""Direct normal irradiance above which the sun shines. [W/m2]"""

STEP = 60.0
"""Between places of the sun that are looked at on one day. [s]"""


@dataclass(frozen=True, eq=False)
class SunlitDay:
    """Moments of one day at which sunlight counts, each the middle of a step.

    Parameters
    ----------
    times : (n,) array    Universal time since 1970. [s]
    sun : SunPositions    Then, without refraction.
    step : float    [s]
    """

    times: np.ndarray
    sun: SunPositions
    step: float


def make_day(day: date, place: Place, least_elevation: float = 0.0, step: float = STEP):
    """Return the moments of a day by the place's clocks at which the sun is high enough.

    Parameters
    ----------
    day : date
    place : Place
    least_elevation : float    Of the sun. [degree]
    step : float    Between moments. [s]

    Returns
    -------
    SunlitDay    Without a moment where the sun stays lower, as in the polar night.

    Raises
    ------
    SceneError    The place, the day or the step is none.
    """
    if not (0.0 < step <= 3600.0 and 0.0 <= least_elevation < 90.0):
        raise SceneError(
            f"sunlight is looked for in steps of {step:g} s from {least_elevation:g} degrees on, expected up to 3600 s "
            "and 0 to 90 degrees"
        )
    start, end = (
        from_local(datetime.combine(each, time()), place.zone).seconds
        for each in (day, day + timedelta(days=1))
    )
    count = round((end - start) / step)
    times = start + (np.arange(count) + 0.5) * (end - start) / count
    is_high = find_sun(times, place).elevation >= least_elevation
    times = times[is_high]
    return SunlitDay(times, find_sun(times, place), (end - start) / count)


def day_hours(is_sunlit, day: SunlitDay) -> np.ndarray:
    """Return for how long the sun of a cloudless day reaches points.

    Parameters
    ----------
    is_sunlit : (points, n) array    Whether the sun is seen at the day's moments, or which part of its disk.
    day : SunlitDay

    Returns
    -------
    (points,) array    Known to about a step at each beginning and end. [h]
    """
    is_sunlit = np.asarray(is_sunlit, dtype=np.float64)
    if is_sunlit.ndim != 2 or is_sunlit.shape[1] != len(day.times):
        raise SceneError(
            f"sunlight of the shape {is_sunlit.shape} does not fit the {len(day.times)} moments of the day"
        )
    return is_sunlit.sum(axis=1) * day.step / 3600.0


def year_hours(is_sunlit, direct_normal=None, interval: float = 1.0) -> np.ndarray:
    """Return for how long the sun reaches points in a year.

    Parameters
    ----------
    is_sunlit : (points, hours) array    Whether the sun of each interval is seen, or which part of its disk; none while it
        is down.
    direct_normal : (hours,) array or None    Irradiance by the sun, so that only sunshine counts; None: a cloudless
        year. [W/m2]
    interval : float    [h]

    Returns
    -------
    (points,) array    [h]

    Raises
    ------
    SceneError    An irradiance is missing, or the shapes do not fit.
    """
    is_sunlit = np.asarray(is_sunlit, dtype=np.float64)
    if direct_normal is None:
        return is_sunlit.sum(axis=1) * interval
    direct_normal = np.asarray(direct_normal, dtype=np.float64)
    if is_sunlit.ndim != 2 or direct_normal.shape != is_sunlit.shape[1:]:
        raise SceneError(
            f"sunlight of the shape {is_sunlit.shape} does not fit the {direct_normal.size} hours of the weather"
        )
    if np.isnan(direct_normal).any():
        raise SceneError("the weather has hours without direct irradiance, so sunshine is unknown")
    return is_sunlit @ (direct_normal > SUNSHINE) * interval
