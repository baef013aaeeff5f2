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

from dataclasses import dataclass, replace
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

LEAST_HEIGHT = 1e-3
"""At which a sun that stands on the horizon within its tolerance is taken. [degree]"""

NEAREST = np.radians(5.0)
"""Least angle between that place and the sun, whose glare the lens spreads. [rad]"""

TURBIDITY = 3.0
"""Luminous turbidity of a clear day. [-]"""

VAGUE = 10.0
"""Width from which on a time is called vague. [min]"""

STEP, FINE_STEP = 300.0, 20.0
"""Between times of a day at which the sun's height is looked up before it is refined, and before its bounds are. [s]"""


def find_sun_of(search: Search, up=UPWARDS) -> Source | None:
    """Return the source that is likely the sun, None if there is none: small, above the horizon, and far the brightest.

    A single bright lamp may look the same; `sun_doubt` tells what speaks for one.

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
    spread : float    Most by which the illuminance changes within the tolerance of the sun's height, relative. [-]
    """

    illuminance: float
    model: float
    scale: float
    spread: float = 0.0


def find_tolerance(rows: int) -> float:
    """Return how well the height of a clipped sun is known: to half a pixel. [degree]

    Parameters
    ----------
    rows : int    Of the picture, from pole to pole.
    """
    return 90.0 / rows


def rebuild_sun(
    image: ImageTexture,
    towards_sun,
    towards_sky,
    turbidity: float = TURBIDITY,
    distance: float = 1.0,
    height: float = 0.0,
    kind: int = CLEAR,
    rotation: np.ndarray | None = None,
    tolerance: float = 0.0,
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
    tolerance : float    By which the sun may stand higher or lower. [degree]

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
    pressure = standard_air(height).pressure

    def make(elevation: float) -> ModelSun:
        towards = _lifted_to(towards_sun, elevation)
        sky = CieSky(kind, towards, usual_illuminance(condition_of_type(kind), elevation))
        scale = _sky_luminance(image, sky, towards_sky, rotation) / seen
        sun = direct_illuminance(elevation, turbidity, distance, pressure)
        return ModelSun(sun / scale, sun, scale)

    made = make(elevation)
    bounds = [np.clip(elevation + side * tolerance, LEAST_HEIGHT, 90.0) for side in (-1.0, 1.0)]
    spread = max(abs(make(float(each)).illuminance / made.illuminance - 1.0) for each in bounds)
    return replace(made, spread=float(spread) if tolerance > 0.0 else 0.0)


def _lifted_to(towards, elevation: float) -> np.ndarray:
    """Return a direction turned to a height [degree] above where it points on the ground. (3,)"""
    plan = np.array([towards[0], towards[1], 0.0])
    length = np.linalg.norm(plan)
    plan = plan / length if length > 0.0 else np.array([0.0, 1.0, 0.0])
    up = np.radians(elevation)
    return np.cos(up) * plan + np.sin(up) * np.array([0.0, 0.0, 1.0])


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
    first, last : datetime    Between these times it stands as high within the tolerance, on clocks as ``clock``.
    turn : float    By which its azimuth changes between these. [degree]
    """

    seconds: float
    clock: datetime
    azimuth: float
    is_morning: bool
    first: datetime
    last: datetime
    turn: float


def find_times(
    elevation: float,
    place: Place,
    year: int,
    month: int,
    day: int,
    is_lifted: bool = True,
    tolerance: float = 0.0,
):
    """Return when the sun stands at a height on a day.

    Parameters
    ----------
    elevation : float    [degree]
    place : Place
    year, month, day : int    Of the place's clocks.
    is_lifted : bool    Whether it is the height at which the sun is seen, with the refraction of the place's air.
    tolerance : float    By which the sun may stand higher or lower. [degree]

    Returns
    -------
    tuple of SunTime    Mostly one in the morning and one in the afternoon; noon alone where the sun misses the height by no
        more than the tolerance then.

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
        (_refine(times[i], times[i + 1], elevation, place, air), bool(heights[i + 1] > heights[i]))
        for i in np.flatnonzero((heights[:-1] < elevation) != (heights[1:] < elevation))
    ]
    fine = np.append(np.arange(begin, end, FINE_STEP), end)
    off = find_sun(fine, place, air).elevation - elevation
    top = int(np.argmax(off))
    if not found and -tolerance <= off[top] < 0.0:
        found = [(float(fine[top]), True)]
    if not found:
        low, high = float(heights.min()), float(heights.max())
        raise SceneError(
            f"the sun stands {elevation:.1f} degrees high in the picture, but {low:.1f} to {high:.1f} degrees on "
            f"{year}-{month:02d}-{day:02d} at the place"
        )
    return tuple(
        _tell_time(seconds, is_morning, _bounds(seconds, fine, np.abs(off), tolerance), place)
        for seconds, is_morning in found
    )


def _refine(low: float, high: float, elevation: float, place: Place, air) -> float:
    """Return the time between two at which the sun passes a height. [s]"""
    first, last = find_sun(np.array([low, high]), place, air).elevation
    for _ in range(20):
        middle = 0.5 * (low + high)
        is_below = float(find_sun(middle, place, air).elevation) < elevation
        low, high = (middle, high) if is_below == (last > first) else (low, middle)
    return middle


def _bounds(seconds: float, times, off, tolerance: float) -> tuple[float, float]:
    """Return between which times about one the sun misses the height by no more than the tolerance. [s]

    By the times themselves and not by its speed, which is none at noon.

    Parameters
    ----------
    times, off : (n,) array    Of the day [s], and by what it misses the height then. [degree]
    """
    made = []
    for part in (np.flatnonzero(times < seconds)[::-1], np.flatnonzero(times > seconds)):
        inner, least = seconds, 0.0
        for k in part:
            if off[k] > tolerance:
                share = (tolerance - least) / (off[k] - least) if off[k] > least else 0.0
                inner += (times[k] - inner) * max(share, 0.0)
                break
            inner, least = times[k], off[k]
        made.append(float(inner))
    return made[0], made[1]


def _tell_time(seconds: float, is_morning: bool, bounds, place: Place) -> SunTime:
    azimuth, first, last = (float(each) for each in find_sun([seconds, *bounds], place).azimuth)
    return SunTime(
        seconds,
        to_local(seconds, place.zone),
        azimuth,
        is_morning,
        *(to_local(each, place.zone) for each in bounds),
        abs((last - first + 180.0) % 360.0 - 180.0),
    )


def choose_time(times, is_morning: bool) -> SunTime:
    """Return the time of the half of the day that is asked for, or the only one."""
    return next((each for each in times if each.is_morning == is_morning), times[0])


def tell_times(time: SunTime, tolerance: float) -> str:
    """Return in words how sure a time is. ``tolerance``: of the sun's height. [degree]"""
    first, last = (f"{each:%H:%M:%S}" for each in (time.first, time.last))
    minutes = (time.last - time.first).total_seconds() / 60.0
    words = f"its height is sure to {tolerance:.2f}°, half a pixel, the time to {minutes:.1f} minutes: {first} to {last}"
    if minutes > VAGUE:
        words += f"; it moves too slowly then, so its height says little of the time, and north is sure to {time.turn:.1f}°"
    return words


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
