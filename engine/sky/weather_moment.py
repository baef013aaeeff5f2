"""What a weather file says of one moment: the record that holds it, or the mean of its hour over the days of its month.

Records are found by month, day and hour of the file's standard time, whatever their year. The sun may stand elsewhere in an
hour than in its middle: a record tells how clear and bright the sky is and how much light there is, the moment where the sun
stands.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..errors import SceneError
from ..scene.light import PerezSky
from .hour import find_daylight_hours
from .measured import SkyGrid
from .place import to_local
from .skies import find_luminances
from .weather import Weather, find_hours

ELEVATIONS, AZIMUTHS = np.arange(0.0, 91.0, 2.0), np.arange(0.0, 360.0, 3.0)
"""Places of a mean sky. [degree]"""


@dataclass(frozen=True, eq=False)
class WeatherMoment:
    """Daylight that a weather file states for a moment.

    Parameters
    ----------
    clearness, brightness : float    Of the model of Perez; the mean's are NaN. [-]
    direct_normal : float    Illuminance by the sun of a plane that faces it. [lx]
    diffuse_horizontal : float    Illuminance of a horizontal plane by the sky. [lx]
    mean : SkyGrid or None    Luminances of a mean over several days, by compass directions.
    days : int    Over which it is the mean; 1: a single record.
    label : str    Which record it is.
    note : str    One sentence for people on what was assumed, empty if nothing was.
    """

    clearness: float
    brightness: float
    direct_normal: float
    diffuse_horizontal: float
    mean: SkyGrid | None
    days: int
    label: str
    note: str = ""


def find_weather_moment(weather: Weather, seconds: float, *, is_mean: bool) -> WeatherMoment:
    """Return the daylight of a moment.

    Parameters
    ----------
    weather : Weather
    seconds : float    Universal time since 1970, of any year. [s]
    is_mean : bool    Take the mean of this hour over all days of the month in place of the record.

    Raises
    ------
    SceneError    The file has no record of the moment, or the record lacks an irradiance.
    """
    clock = to_local(seconds, weather.place.zone)
    hour = clock.hour + clock.minute / 60.0 + (clock.second + 1e-6 * clock.microsecond) / 3600.0
    since = hour - (weather.hour - 0.5 * weather.interval)
    fits = (weather.month == clock.month) & (since > -1e-6) & (since < weather.interval - 1e-6)
    day, note = clock.day, ""
    is_leap_day = (clock.month, clock.day) == (2, 29)
    if is_leap_day and not (fits & (weather.day == 29)).any():
        day, note = 28, "the weather file has no 29 February, and the 28th was taken"
    if not is_mean:
        fits &= weather.day == day
    # A year without it cannot hold the record of a leap day.
    fits &= is_leap_day | (weather.month != 2) | (weather.day != 29)
    label = f"{clock:%m}-{day:02d} {clock:%H:%M}, {weather.place.zone}"
    chosen = np.flatnonzero(fits)
    if not len(chosen):
        raise SceneError(f"the weather file has no record of {label}")
    part = select(weather, chosen if is_mean else chosen[:1])
    # The year of the moment, but for a leap day that the file lacks.
    hours = find_hours(part, clock.year)
    daylight = find_daylight_hours(part, hours)
    is_known = np.isfinite(daylight.direct_normal) & np.isfinite(daylight.diffuse_horizontal)
    if not is_known.any():
        raise SceneError(f"the weather file's record of {label} lacks an irradiance")
    direct = float(daylight.direct_normal[is_known].mean())
    diffuse = float(daylight.diffuse_horizontal[is_known].mean())
    if not is_mean:
        numbers = float(daylight.clearness[0]), float(daylight.brightness[0])
        return WeatherMoment(*numbers, direct, diffuse, None, 1, label, note)
    left_out = np.count_nonzero(~is_known)
    if left_out:
        lack = "1 day lacks" if left_out == 1 else f"{left_out} days lack"
        note = f"{lack} an irradiance, and the mean is that of the others"
    directions = find_directions()
    total = np.zeros(directions.shape[:2])
    for i in np.flatnonzero(is_known & (daylight.diffuse_horizontal > 0.0)):
        sun = np.array(hours.sun.directions()[i])
        sun[2] = max(sun[2], 0.0)
        sky = PerezSky(
            float(daylight.clearness[i]),
            float(daylight.brightness[i]),
            sun / np.linalg.norm(sun),
            float(daylight.diffuse_horizontal[i]),
        )
        total += find_luminances(sky, directions)
    days = int(np.count_nonzero(is_known))
    grid = SkyGrid(ELEVATIONS, AZIMUTHS, total / days)
    label = f"mean of {days} days of month {clock.month} at {clock:%H:%M}, {weather.place.zone}"
    return WeatherMoment(np.nan, np.nan, direct, diffuse, grid, days, label, note)


def select(weather: Weather, indices: np.ndarray) -> Weather:
    """Return some records of a weather file."""
    names = ("year", "month", "day", "hour", "line")
    columns = {name: getattr(weather, name)[indices] for name in names}
    values = {name: column[indices] for name, column in weather.values.items()}
    return replace(weather, **columns, values=values, remarks=())


def find_directions() -> np.ndarray:
    """Return unit vectors to the places of a mean sky, +y north, +x east. (n, m, 3)"""
    height, turn = np.meshgrid(np.radians(ELEVATIONS), np.radians(AZIMUTHS), indexing="ij")
    plan = np.cos(height)
    # The horizon itself belongs to the sky.
    return np.stack([plan * np.sin(turn), plan * np.cos(turn), np.sin(height)], axis=-1)
