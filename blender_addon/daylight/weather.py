"""Weather files that worlds name, read once as long as they stay the same, and what they state for a moment."""

from functools import lru_cache
from pathlib import Path

import bpy

from ...engine.errors import FileFormatError
from ...engine.sky.clock_range import ClockRange
from ...engine.sky.weather import Weather
from ...engine.sky.weather_file import read_weather
from ...engine.sky.weather_mean import WeatherMean, find_weather_mean
from ...engine.sky.weather_moment import WeatherMoment, find_weather_moment
from ..file_assets.kind import NoFileError
from .moment import Moment

KEPT = 4
"""Files that are kept; a year by the hour has some megabytes."""


def path_of(settings, name: str, kind: str) -> Path:
    """Return the path that a property of settings holds.

    Raises
    ------
    NoFileError    It is empty.
    """
    text = getattr(settings, name)
    if not text:
        raise NoFileError(f"no {kind} is chosen")
    return Path(bpy.path.abspath(text, library=settings.id_data.library))


def weather_of(world) -> Weather:
    """Return the weather file of a world's sky.

    Raises
    ------
    LumenrayError    None is chosen, or it cannot be read.
    """
    path = path_of(world.lumenray.sky, "weather_file", "weather file")
    try:
        stat = path.stat()
    except OSError as error:
        raise FileFormatError(path, f"cannot be read: {error.strerror}") from None
    return _read(str(path), stat.st_mtime_ns, stat.st_size)


@lru_cache(maxsize=KEPT)
def _read(path: str, changed: int, size: int) -> Weather:
    return read_weather(path)


def weather_moment(world, moment: Moment) -> WeatherMoment:
    """Return what the weather file of a world's sky states for a moment.

    Raises
    ------
    LumenrayError    There is no such file, or no record of the moment.
    """
    return _find(weather_of(world), moment.seconds, world.lumenray.sky.weather_mean == "MONTH")


@lru_cache(maxsize=64)
def _find(weather: Weather, seconds: float, is_mean: bool) -> WeatherMoment:
    return find_weather_moment(weather, seconds, is_mean=is_mean)


def has_band(settings) -> bool:
    """Tell whether a sky's settings ask for the mean of chosen hours, in which the sun is a band of light and no disk."""
    return settings.kind == "WEATHER" and settings.weather_mean == "RANGE"


def weather_mean(world, moment: Moment) -> WeatherMean:
    """Return the mean of the hours that a world's sky asks for, in the year of a moment.

    Raises
    ------
    LumenrayError    There is no such file, the hours are none, or no record of theirs has light.
    """
    settings = world.lumenray.sky
    months = settings.mean_first_month, settings.mean_last_month
    chosen = ClockRange(months, (settings.mean_start, settings.mean_end))
    return _find_mean(weather_of(world), moment.clock.year, chosen)


@lru_cache(maxsize=8)
def _find_mean(weather: Weather, year: int, chosen: ClockRange) -> WeatherMean:
    return find_weather_mean(weather, year, chosen)
