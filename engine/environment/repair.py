"""Suns that a picture shows too dark, mended: by the sky about them, or by a model of the sky at the place and the date.

Cameras clip the sun, so that pictures with a clear sky give far less sunlight than there was; the sky itself is right. So
either the sun is brought to a multiple of the sky's horizontal illuminance, four in clear weather; or, where trees and
buildings hide much of the sky, sun and sky of the CIE's clear sky are scaled together until the sky is as bright as the
picture at one place.

References
----------
A. G. Voloboy: Software technologies that automate the making of realistic images, doctoral dissertation, Keldysh Institute
of Applied Mathematics, Moscow 2012 (in Russian), section 1.3.5
"""

from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from ..errors import SceneError
from ..scene.light import CieSky
from ..scene.texture import ImageTexture
from ..sky.air import standard_air
from ..sky.availability import condition_of_type, usual_illuminance
from ..sky.cie import CLEAR
from ..sky.picture import ROWS_AT_ONCE, clean, find_luminances, grid_of
from ..sky.place import Place, from_local, to_local
from ..sky.skies import find_luminances as find_sky_luminances
from ..sky.solar_position import find_sun
from ..sky.sunlight import direct_illuminance
from .cells import cell_sizes, directions
from .scale import UPWARDS
from .sources import Search, Source

RATIO = 4.0
"""Horizontal illuminance of the sun over that of the sky in clear weather. [-]"""

ALONE = 2.0
"""Part of the second brightest source's light that a sun gives at least; of two alike neither is taken for the sun. [-]"""

LARGEST_SUN = np.radians(4.0)
"""Diameter up to which a bright area may be a sun and what the lens made of it. [rad]"""

PATCH = np.radians(0.5)
"""Radius about a place of the sky in which its luminance is averaged. [rad]"""

NEAREST = np.radians(5.0)
"""Least angle between that place and the sun, whose glare the lens spreads. [rad]"""

TURBIDITY = 3.0
"""Luminous turbidity of a clear day. [-]"""

STEP = 300.0
"""Between times of a day at which the sun's height is looked up before it is refined. [s]"""


def find_sun_of(search: Search, up=UPWARDS) -> Source | None:
    """Return the source that is likely the sun, None if there is none: small, above the horizon, and far the brightest.

    A single bright lamp looks the same, which only people can tell.

    Parameters
    ----------
    search : Search
    up : (3,) array    Upwards in the picture's directions.
    """
    if not search.sources:
        return None
    first, others = search.sources[0], search.sources[1:]
    if first.on(up) <= 0.0 or first.angle > LARGEST_SUN:
        return None
    if others and first.illuminance < ALONE * others[0].illuminance:
        return None
    return first


def sun_factor(sun: Source, sky: float, ratio: float = RATIO, up=UPWARDS) -> float:
    """Return by what a sun has to be multiplied to give a multiple of the sky's light.

    Parameters
    ----------
    sun : Source
    sky : float    Horizontal illuminance by all else, in units of the picture's values.
    ratio : float    Horizontal illuminance of the sun over the sky's. [-]
    up : (3,) array    Upwards in the picture's directions.

    Raises
    ------
    SceneError    The sun gives no light on a horizontal plane.
    """
    if not sun.on(up) > 0.0:
        raise SceneError(
            "the sun is not above the horizon, so that it cannot be measured by the sky"
        )
    return ratio * sky / sun.on(up)


def clear_ratio(elevation: float, turbidity: float = TURBIDITY) -> float:
    """Return what horizontal illuminance of the sun over that of the sky is usual in clear weather. [degree -> -]"""
    sun = direct_illuminance(elevation, turbidity) * np.sin(np.radians(elevation))
    return float(sun / usual_illuminance("clear", elevation))


# ---- by a model ----


@dataclass(frozen=True, eq=False)
class ModelSun:
    """The sun of a model of the sky that is scaled to a picture.

    Parameters
    ----------
    illuminance : float    Of a plane that faces it, in units of the picture's values.
    model : float    The same in the model. [lx]
    scale : float    Luminance of the model over that of a value of 1. [cd/m2]
    """

    illuminance: float
    model: float
    scale: float


def rebuild_sun(
    image: ImageTexture,
    towards_sun,
    towards_sky,
    turbidity: float = TURBIDITY,
    distance: float = 1.0,
    height: float = 0.0,
    kind: int = CLEAR,
    rotation: np.ndarray | None = None,
) -> ModelSun:
    """Return the sun of a sky of the CIE that is as bright as a picture at one place.

    Its colour is the picture's: whoever took that chose what is white in it.

    Parameters
    ----------
    image : ImageTexture    Equirectangular.
    towards_sun, towards_sky : (3,) array    Unit vectors of the world: to the sun, and to the place of the sky.
    turbidity : float    Luminous turbidity. [-]
    distance : float    Of the sun. [astronomical unit]
    height : float    Of the place above the sea. [m]
    kind : int    Type of the sky, 1 to 15 of the CIE's.
    rotation : (3, 3) array or None    As of `ImageWorld`; None: the picture is upright, and its +y is the world's.

    Raises
    ------
    SceneError    The sun or the place of the sky is not where one can be, or the sky is dark there.
    """
    towards_sun, towards_sky = (
        np.asarray(each, dtype=np.float64) for each in (towards_sun, towards_sky)
    )
    elevation = float(np.degrees(np.arcsin(np.clip(towards_sun[2], -1.0, 1.0))))
    if elevation <= 0.0:
        raise SceneError(
            "the sun is not above the horizon, so that no sky can tell how bright it is"
        )
    if towards_sky[2] <= 0.0:
        raise SceneError("the place of the sky lies below the horizon; pick one of the clear sky")
    if np.arccos(np.clip(towards_sun @ towards_sky, -1.0, 1.0)) < NEAREST:
        raise SceneError(
            f"the place of the sky lies within {np.degrees(NEAREST):g} degrees of the sun, where the lens adds light; pick "
            "one farther away"
        )
    rotation = np.eye(3) if rotation is None else np.asarray(rotation, dtype=np.float64)
    seen = find_patch_luminance(image, rotation @ towards_sky)
    if not seen > 0.0:
        raise SceneError("the picture is black at the place of the sky")
    sky = CieSky(kind, towards_sun, usual_illuminance(condition_of_type(kind), elevation))
    scale = _sky_luminance(image, sky, towards_sky, rotation) / seen
    sun = direct_illuminance(elevation, turbidity, distance, standard_air(height).pressure)
    return ModelSun(sun / scale, sun, scale)


def find_patch_luminance(image: ImageTexture, towards) -> float:
    """Return the mean luminance about a direction, in the picture's values."""
    rows, columns, sizes = _patch(image, towards)
    luminances = find_luminances(clean(image.pixels[rows, columns][None]))[0]
    return float(sizes @ luminances) / float(sizes.sum())


def _sky_luminance(image, sky: CieSky, towards, rotation) -> float:
    """Mean luminance of a sky about a direction, by the same pixels. [cd/m2]"""
    rows, columns, sizes = _patch(image, rotation @ towards)
    vectors = directions(rows, columns, grid_of(image)).astype(np.float64) @ rotation
    vectors[:, 2] = np.maximum(vectors[:, 2], 0.0)
    return float(sizes @ find_sky_luminances(sky, vectors)) / float(sizes.sum())


def _patch(image, towards) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows, columns and solid angles of the pixels about a direction, the nearest one at least."""
    grid = grid_of(image)
    chords, places = [], []
    polar = np.arccos(np.clip(-float(towards[2]), -1.0, 1.0))
    low = max(int((polar - PATCH) / np.pi * grid.height) - 1, 0)
    high = min(int((polar + PATCH) / np.pi * grid.height) + 2, grid.height)
    for start in range(low, high, ROWS_AT_ONCE):
        rows = np.repeat(np.arange(start, min(start + ROWS_AT_ONCE, high)), grid.width)
        columns = np.tile(np.arange(grid.width), len(rows) // grid.width)
        chord = np.linalg.norm(directions(rows, columns, grid) - np.float32(towards), axis=1)
        kept = chord <= max(2.0 * np.sin(0.5 * PATCH), chord.min())
        chords.append(chord[kept])
        places.append(np.stack([rows[kept], columns[kept]]))
    chord, place = np.concatenate(chords), np.concatenate(places, axis=1)
    rows, columns = place[:, chord <= max(2.0 * np.sin(0.5 * PATCH), chord.min())]
    return rows, columns, cell_sizes(grid)[rows]


# ---- place, date and time ----


@dataclass(frozen=True)
class SunTime:
    """When the sun stands as high as a picture shows it.

    Parameters
    ----------
    seconds : float    Universal time since 1970. [s]
    clock : datetime    What the place's clocks show, with their zone.
    azimuth : float    Of the sun then, from north over east. [degree]
    is_morning : bool    Whether it rises.
    speed : float    How fast it rises or sinks: the time is as sure as the height. [degree/min]
    """

    seconds: float
    clock: datetime
    azimuth: float
    is_morning: bool
    speed: float


def find_times(
    elevation: float, place: Place, year: int, month: int, day: int, is_lifted: bool = True
):
    """Return when the sun stands at a height on a day.

    Parameters
    ----------
    elevation : float    [degree]
    place : Place
    year, month, day : int    Of the place's clocks.
    is_lifted : bool    Whether it is the height at which the sun is seen, with the refraction of the place's air.

    Returns
    -------
    tuple of SunTime    Mostly one in the morning and one in the afternoon.

    Raises
    ------
    SceneError    There is no such day, or the sun never stands so high or so low on it.
    """
    try:
        start = datetime(year, month, day)
    except ValueError:
        raise SceneError(f"there is no day {year}-{month:02d}-{day:02d}") from None
    begin, end = (
        from_local(each, place.zone).seconds for each in (start, start + timedelta(days=1))
    )
    air = standard_air(place.elevation) if is_lifted else None
    times = np.append(np.arange(begin, end, STEP), end)
    heights = find_sun(times, place, air).elevation
    found = [
        _refine(times[i], times[i + 1], elevation, place, air)
        for i in np.flatnonzero((heights[:-1] < elevation) != (heights[1:] < elevation))
    ]
    if not found:
        low, high = float(heights.min()), float(heights.max())
        raise SceneError(
            f"the sun stands {elevation:.1f} degrees high in the picture, but {low:.1f} to {high:.1f} degrees on "
            f"{year}-{month:02d}-{day:02d} at the place"
        )
    return tuple(found)


def _refine(low: float, high: float, elevation: float, place: Place, air) -> SunTime:
    """Return the time between two at which the sun passes a height."""
    first, last = find_sun(np.array([low, high]), place, air).elevation
    is_morning = bool(last > first)
    for _ in range(20):
        middle = 0.5 * (low + high)
        is_below = float(find_sun(middle, place, air).elevation) < elevation
        low, high = (middle, high) if is_below == is_morning else (low, middle)
    speed = abs(float(last - first)) / (STEP / 60.0)
    azimuth = float(find_sun(middle, place, air).azimuth)
    return SunTime(middle, to_local(middle, place.zone), azimuth, is_morning, speed)


def choose_time(times, is_morning: bool) -> SunTime:
    """Return the time of the half of the day that is asked for, or the only one."""
    return next((each for each in times if each.is_morning == is_morning), times[0])


def find_north(towards_sun, azimuth: float) -> float:
    """Return the compass direction of the +y axis for which a sun stands at an azimuth.

    Parameters
    ----------
    towards_sun : (3,) array    In the axes that are to be turned.
    azimuth : float    From north over east. [degree]

    Returns
    -------
    float    As of `Place.north`, -180 to 180. [degree]
    """
    own = np.degrees(np.arctan2(float(towards_sun[0]), float(towards_sun[1])))
    return float((azimuth - own + 180.0) % 360.0 - 180.0)
