"""Weather of a year or a part of it at one place, whatever file it comes from, and where its sun stands.

Every record stands for an interval of the place's standard time, which no daylight saving changes.
"""

from dataclasses import dataclass
from datetime import datetime

import numpy as np

from ..errors import SceneError
from ..reading.remarks import Remark
from .limits import FIRST_YEAR, LAST_YEAR
from .place import Place, find_zone
from .solar_position import SunPositions, find_sun

TWILIGHT = 20.0
"""Diffuse horizontal irradiance that a sky may give while the sun is down. [W/m2]"""

FARTHEST_NOON = 0.4
"""By which a year's diffuse irradiance may be centred before or after noon. A clock that is wrong is so by half an hour or
more (the end or the beginning of an hour taken for its middle, daylight saving); fog and clouds in the mornings move it by
0.13 in the real years that tests read. [h]"""

WHOLE_YEAR = 3500.0
"""Daylight of a year, nearly. [h]"""

SUBDIVISION = 24
"""Parts of an interval in which the sun is looked for at its rise and set."""

LOWEST_SUN = 0.5
"""Lower, an irradiance of a horizontal plane by the sun says nothing of the sun. [degree]"""

UNITS = {
    "direct_normal": "W/m2",
    "direct_horizontal": "W/m2",
    "diffuse_horizontal": "W/m2",
    "global_horizontal": "W/m2",
    "direct_normal_illuminance": "lx",
    "diffuse_horizontal_illuminance": "lx",
    "global_illuminance": "lx",
    "zenith_luminance": "cd/m2",
    "temperature": "degree Celsius",
    "dew_point": "degree Celsius",
    "pressure": "Pa",
    "precipitable_water": "kg/m2",
    "albedo": "-",
}
"""What a file may state, with its unit."""


@dataclass(frozen=True, eq=False)
class Weather:
    """Records of a weather file.

    Parameters
    ----------
    place : Place    Its zone is a fixed offset.
    year, month, day : (n,) int arrays    Of the interval; the year is 0 where the file has none. Those of a typical year
        differ from month to month.
    hour : (n,) array    Of the interval's middle, 0 to 24. [h, standard time]
    interval : float    [h]
    values : dict of (n,) arrays    By the names of `UNITS`, NaN where a value is missing; a name is missing where no record
        has it.
    line : (n,) int array    Of the file.
    remarks : tuple of Remark    What is odd.
    """

    place: Place
    year: np.ndarray
    month: np.ndarray
    day: np.ndarray
    hour: np.ndarray
    interval: float
    values: dict[str, np.ndarray]
    line: np.ndarray
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        return len(self.hour)

    @property
    def has_irradiance(self) -> bool:
        """Whether sun and sky are told in watts."""
        has_direct = "direct_normal" in self.values or "direct_horizontal" in self.values
        return has_direct and "diffuse_horizontal" in self.values


@dataclass(frozen=True, eq=False)
class WeatherHours:
    """Records with their sun.

    Parameters
    ----------
    times : (n,) array    Middle of the interval, or of its part in which the sun is up where it is down in the middle.
        Universal time since 1970. [s]
    sun : SunPositions    Then, without refraction. (n,)
    direct_normal : (n,) array    Irradiance by the sun of a plane that faces it, 0 while it is down; NaN: missing. [W/m2]
    diffuse_horizontal : (n,) array    Irradiance of a horizontal plane by the sky; NaN: missing. [W/m2]
    remarks : tuple of Remark    What does not fit the sun.
    """

    times: np.ndarray
    sun: SunPositions
    direct_normal: np.ndarray
    diffuse_horizontal: np.ndarray
    remarks: tuple[Remark, ...]


def find_hours(weather: Weather, year: int | None = None) -> WeatherHours:
    """Return the records with their sun.

    Parameters
    ----------
    weather : Weather
    year : int or None    In which all records are taken to be; None: each in its own, which files without years lack. A
        record of 29 February needs a leap year.

    Raises
    ------
    SceneError    No year is known, a record's day is not in the year, or there is no irradiance.
    """
    if not weather.has_irradiance:
        raise SceneError("the weather has no direct and diffuse irradiance")
    middle = find_middles(weather, year)
    half = 0.5 * weather.interval * 3600.0
    ends = find_sun(middle[:, None] + [-half, 0.0, half], weather.place).elevation
    times = middle.copy()
    turning = np.flatnonzero((ends[:, 1] <= 0.0) & (ends > 0.0).any(axis=1))
    steps = half * ((2.0 * np.arange(SUBDIVISION) + 1.0) / SUBDIVISION - 1.0)
    parts = middle[turning, None] + steps
    is_up = find_sun(parts, weather.place).elevation > 0.0
    many = is_up.sum(axis=1)
    mean = np.where(is_up, steps, 0.0).sum(axis=1) / np.maximum(many, 1)
    times[turning] += np.where(many > 0, mean, 0.0)
    sun = find_sun(times, weather.place)
    diffuse = weather.values["diffuse_horizontal"]
    remarks = []
    if "direct_normal" in weather.values:
        direct = weather.values["direct_normal"]
    else:
        horizontal = weather.values["direct_horizontal"]
        is_low = sun.elevation < LOWEST_SUN
        sine = np.sin(np.radians(np.maximum(sun.elevation, LOWEST_SUN)))
        direct = np.where(is_low, np.where(horizontal > 0.0, np.nan, horizontal), horizontal / sine)
        note(
            remarks,
            weather,
            is_low & (horizontal > 0.0),
            f"direct horizontal irradiance while the sun is lower than {LOWEST_SUN} degrees, which says nothing of the "
            "sun; its direct normal irradiance is taken as missing",
        )
    is_down = (ends <= 0.0).all(axis=1)
    doubt = "longitude and time zone, or the file's clock, may not fit"
    note(
        remarks,
        weather,
        is_down & (direct > 0.0),
        f"direct irradiance while the sun is down, which is taken as 0; {doubt}",
    )
    note(
        remarks,
        weather,
        is_down & (diffuse > TWILIGHT),
        f"more than {TWILIGHT:g} W/m2 of diffuse irradiance while the sun is down; {doubt}",
    )
    direct = np.where(is_down & (direct > 0.0), 0.0, direct)
    known = np.where(np.isnan(diffuse), 0.0, diffuse)
    if np.count_nonzero(known) * weather.interval > WHOLE_YEAR:
        noon = np.average(sun.solar_time, weights=known)
        if abs(noon - 12.0) > FARTHEST_NOON:
            remarks.append(
                Remark(
                    f"diffuse irradiance is centred at {noon:.1f} h, true solar time, instead of 12; {doubt}"
                )
            )
    return WeatherHours(times, sun, direct, diffuse, tuple(remarks))


def find_middles(weather: Weather, year: int | None = None) -> np.ndarray:
    """Return the middles of the records' intervals, universal time since 1970; ``year`` as of `find_hours`. (n,) [s]

    Raises
    ------
    SceneError    No year is known, or a record's day is not in the year.
    """
    years = weather.year if year is None else np.full(len(weather), year)
    if (years == 0).any():
        raise SceneError("the weather file has no years, expected a year to take it in")
    if (years < FIRST_YEAR).any() or (years > LAST_YEAR).any():
        raise SceneError(f"a year of the weather is beyond {FIRST_YEAR} to {LAST_YEAR}")
    is_leap = (years % 4 == 0) & ((years % 100 != 0) | (years % 400 == 0))
    wrong = (weather.month == 2) & (weather.day == 29) & ~is_leap
    if wrong.any():
        raise SceneError(
            f"the weather has a record of 29 February, which {years[wrong][0]} has not; expected a leap year"
        )
    months = (years - 1970) * 12 + weather.month - 1
    days = months.astype("datetime64[M]").astype("datetime64[D]").astype(np.int64)
    days = days + weather.day - 1
    offset = zone_offset(weather.place)
    return (days * 24.0 + weather.hour - offset) * 3600.0


def zone_offset(place: Place) -> float:
    """Return by how much the place's clocks, whose zone is a fixed offset, are ahead of universal time. [h]"""
    return find_zone(place.zone).utcoffset(datetime(2001, 1, 1)).total_seconds() / 3600.0


def note(remarks: list[Remark], weather: Weather, where: np.ndarray, what: str) -> None:
    """Remark on the records of a mask, if there are any, with their number and the first one's line."""
    count = int(np.count_nonzero(where))
    if count:
        records = "1 record has" if count == 1 else f"{count} records have"
        remarks.append(Remark(f"{records} {what}", int(weather.line[np.argmax(where)])))
