"""The mean daylight of chosen hours of a weather file: the sky, and the sun as a band of light along its ways.

Light adds up, so that what the mean sky and the mean sun give anywhere is the mean of what the hours give one by one. The
sun of an hour is spread along the way that it takes in it while it is up, as bright all the time.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..scene.light import ImageWorld, PerezSky
from .clock_range import ClockRange
from .hour import find_daylight_hours
from .measured import GRID_COLUMNS, GRID_ROWS, SkyGrid, make_grid_world, make_world
from .pattern import evaluate_all
from .perez import pattern_of
from .solar_position import find_sun
from .weather import Weather, find_hours, find_middles
from .weather_moment import AZIMUTHS, ELEVATIONS, find_directions, select

STEPS = 30
"""Places of the sun in an hour: half a degree from each other at most, about the width of its disk."""

AT_ONCE = 256
"""Records whose skies are evaluated together."""


@dataclass(frozen=True, eq=False)
class WeatherMean:
    """Mean daylight of some hours.

    Parameters
    ----------
    sky : SkyGrid    Luminances, by compass directions.
    diffuse_horizontal : float    Illuminance of a horizontal plane by the sky. [lx]
    suns : (k, 3) array    Unit vectors to places of the sun; +y north, +x east.
    beams : (k,) array    Mean illuminance of a plane that faces the sun, by that at each place. [lx]
    hours : float    Time over which it is the mean. [h]
    label : str    Which hours they are.
    note : str    One sentence for people on what was assumed, empty if nothing was.
    """

    sky: SkyGrid
    diffuse_horizontal: float
    suns: np.ndarray
    beams: np.ndarray
    hours: float
    label: str
    note: str = ""

    @property
    def direct_horizontal(self) -> float:
        """Mean illuminance of a horizontal plane by the sun. [lx]"""
        return float(self.beams @ self.suns[:, 2]) if len(self.beams) else 0.0


def find_weather_mean(weather: Weather, year: int, chosen: ClockRange) -> WeatherMean:
    """Return the mean daylight of some hours, dark ones with them.

    Parameters
    ----------
    weather : Weather
    year : int    In which the records are taken to be; a record of 29 February counts in leap years alone.
    chosen : ClockRange    In the file's standard time; records whose middle lies within count.

    Raises
    ------
    SceneError    No record lies within, all of them lack an irradiance, or none has any light.
    """
    counted = chosen.holds(weather.month, weather.hour)
    is_leap = year % 4 == 0 and (year % 100 != 0 or year % 400 == 0)
    counted &= is_leap | (weather.month != 2) | (weather.day != 29)
    label = f"{chosen.words}, {weather.place.zone}"
    if not counted.any():
        raise SceneError(f"the weather file has no record of {label}")
    part = select(weather, np.flatnonzero(counted))
    hours = find_hours(part, year)
    daylight = find_daylight_hours(part, hours)
    is_known = np.isfinite(daylight.direct_normal) & np.isfinite(daylight.diffuse_horizontal)
    count = int(np.count_nonzero(is_known))
    if not count:
        raise SceneError(f"all records of {label} lack an irradiance")
    left_out, note = len(part) - count, ""
    if left_out:
        lack = "1 record lacks" if left_out == 1 else f"{left_out} records lack"
        note = f"{lack} an irradiance, and the mean is that of the others"
    has_sky = np.flatnonzero(is_known & (daylight.diffuse_horizontal > 0.0))
    if not len(has_sky):
        raise SceneError(f"the weather file's skies of {label} give no light")
    diffuse = daylight.diffuse_horizontal[has_sky]
    patterns = [
        pattern_of(
            PerezSky(
                max(float(daylight.clearness[i]), 1.0),
                float(daylight.brightness[i]),
                _above(hours.sun.directions()[i]),
                1.0,
            )
        )
        for i in has_sky
    ]
    direct = np.where(is_known, daylight.direct_normal, 0.0)
    suns, beams = _spread_suns(part, find_middles(part, year), hours, direct)
    return WeatherMean(
        SkyGrid(ELEVATIONS, AZIMUTHS, _add_skies(patterns, diffuse) / count),
        float(diffuse.sum()) / count,
        suns,
        beams / count,
        count * weather.interval,
        label,
        note,
    )


def make_mean_world(
    mean: WeatherMean, ground_reflectance: float = 0.0, *, has_sun: bool = True
) -> ImageWorld:
    """Return a mean sky over an evenly bright ground.

    Parameters
    ----------
    mean : WeatherMean
    ground_reflectance : float    As of `CieSky`; the ground is lit by what the sky holds. [-]
    has_sun : bool    Whether the sky holds the sun.

    Raises
    ------
    SceneError    The reflectance is none.
    """
    pixels = make_grid_world(mean.sky).image.pixels[..., 0].astype(np.float64)
    solid, sine = _pixel_areas()
    pixels *= mean.diffuse_horizontal / float(
        (pixels[GRID_ROWS // 2 :].sum(axis=1)) @ (solid * sine)
    )
    illuminance = mean.diffuse_horizontal
    if has_sun and len(mean.beams):
        pixels[GRID_ROWS // 2 :] += _draw_suns(mean.suns, mean.beams) / solid[:, None]
        illuminance += mean.direct_horizontal
    return make_world(pixels, illuminance, ground_reflectance)


def _above(direction: np.ndarray) -> np.ndarray:
    level = np.array([direction[0], direction[1], max(direction[2], 0.0)])
    return level / np.linalg.norm(level)


def _add_skies(patterns, illuminances) -> np.ndarray:
    """Sum of the luminances of skies of horizontal illuminances, at the places of a mean sky. (n, m) [cd/m2]"""
    directions = find_directions()
    step = np.radians(ELEVATIONS[1] - ELEVATIONS[0])
    # What a place counts for in the illuminance, sky linear between rows; the level is set by what the places resolve.
    rows = np.sin(2.0 * np.radians(ELEVATIONS)) * 0.5 * step
    rows[0], rows[-1] = (0.5 * step) ** 2 / 2.0, (0.5 * step) ** 2 / 2.0
    weights = np.repeat(rows, len(AZIMUTHS)) * (2.0 * np.pi / len(AZIMUTHS))
    total = np.zeros(directions.shape[:2])
    for first in range(0, len(patterns), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        value = evaluate_all(patterns[part], directions.reshape(-1, 3))
        total += ((illuminances[part] / (value @ weights)) @ value).reshape(total.shape)
    return total


def _spread_suns(
    weather: Weather, middles, hours, direct: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Places of the sun in the records in which it shines, and what it gives from each. (k, 3), (k,) [lx]"""
    lit = np.flatnonzero(direct > 0.0)
    if not len(lit):
        return np.zeros((0, 3)), np.zeros(0)
    steps = max(round(STEPS * weather.interval), 1)
    middle = middles[lit]
    share = (np.arange(steps) + 0.5) / steps - 0.5
    times = middle[:, None] + share * weather.interval * 3600.0
    towards = find_sun(times, weather.place).directions()
    is_up = towards[..., 2] > 0.0
    # The part of the hour in which it is up may be shorter than a step.
    none = ~is_up.any(axis=1)
    towards[none] = np.array([_above(each) for each in hours.sun.directions()[lit][none]]).reshape(
        -1, 1, 3
    )
    is_up[none, 0] = True
    beams = direct[lit][:, None] * is_up / is_up.sum(axis=1, keepdims=True)
    return towards[is_up], beams[is_up]


def _pixel_areas() -> tuple[np.ndarray, np.ndarray]:
    """Solid angle of a pixel in each row of the upper half of a picture [sr], and the sine of its elevation."""
    edges = np.radians(np.arange(GRID_ROWS // 2 + 1) * 180.0 / GRID_ROWS)
    solid = np.diff(np.sin(edges)) * 2.0 * np.pi / GRID_COLUMNS
    # So that the horizontal illuminance of a row is exact.
    return solid, 0.5 * np.diff(np.sin(edges) ** 2) / np.diff(np.sin(edges))


def _draw_suns(suns: np.ndarray, beams: np.ndarray) -> np.ndarray:
    """Share beams out to the four pixels around each sun. (rows / 2, columns) [lx]"""
    x, y, z = suns.T
    half = GRID_ROWS // 2
    row = np.degrees(np.arctan2(z, np.hypot(x, y))) * GRID_ROWS / 180.0 - 0.5
    turn = np.arctan2(x, y) / (2.0 * np.pi) + 0.25
    column = (turn % 1.0) * GRID_COLUMNS - 0.5
    made = np.zeros((half, GRID_COLUMNS))
    low, left = np.floor(row).astype(int), np.floor(column).astype(int)
    for above, part in ((0, 1.0 - (row - low)), (1, row - low)):
        for aside, share in ((0, 1.0 - (column - left)), (1, column - left)):
            at = np.clip(low + above, 0, half - 1), (left + aside) % GRID_COLUMNS
            np.add.at(made, at, beams * part * share)
    return made
