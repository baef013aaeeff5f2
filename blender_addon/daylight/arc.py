"""The sun's way over a day as lines about the origin, and the time at which it is next to a point of the screen."""

from dataclasses import dataclass
from datetime import datetime
from functools import lru_cache

import numpy as np

from ...engine.errors import SceneError
from ...engine.sky.air import standard_air
from ...engine.sky.limits import LAST_YEAR
from ...engine.sky.place import Place, from_local, to_local
from ...engine.sky.solar_position import DAY, find_sun
from .moment import Moment

STEPS = 288
"""Parts of a day."""

SOLSTICES = ((6, 21), (12, 21))
"""Month and day of the highest and the lowest way of the sun."""

CIRCLE = 96
"""Parts of the horizon."""


@dataclass(frozen=True, eq=False)
class SunArc:
    """Way of the sun over a day, all as unit vectors in the scene's axes.

    Parameters
    ----------
    seconds : (n,) array    Universal time since 1970. [s]
    directions : (n, 3) array    To the sun then, below the horizon too.
    hours : tuple of (str, (3,) array)    Full hours of the place's clocks at which the sun is up.
    solstices : tuple of (m, 3) arrays    Of the same year.
    """

    seconds: np.ndarray
    directions: np.ndarray
    hours: tuple[tuple[str, np.ndarray], ...]
    solstices: tuple[np.ndarray, ...]


def make_arc(moment: Moment, *, is_lifted: bool) -> SunArc:
    """Return the way of the sun over a moment's day.

    Parameters
    ----------
    moment : Moment
    is_lifted : bool    By refraction.

    Raises
    ------
    SceneError    The day is beyond the years in which the sun is known.
    """
    clock = moment.clock
    return _make(moment.place, clock.year, clock.month, clock.day, is_lifted)


@lru_cache(maxsize=8)
def _make(place: Place, year: int, month: int, day: int, is_lifted: bool) -> SunArc:
    seconds = _times(place, year, month, day)
    full = [
        s for s in np.arange(seconds[0], seconds[-1], 900.0) if to_local(s, place.zone).minute == 0
    ]
    marks = _directions(np.array(full), place, is_lifted)
    hours = tuple(
        (str(to_local(second, place.zone).hour), direction)
        for second, direction in zip(full, marks, strict=True)
        if direction[2] > 0.0
    )
    solstices = tuple(_solstice(place, year, *date, is_lifted) for date in SOLSTICES)
    return SunArc(seconds, _directions(seconds, place, is_lifted), hours, solstices)


@lru_cache(maxsize=16)
def _solstice(place: Place, year: int, month: int, day: int, is_lifted: bool) -> np.ndarray:
    return _directions(_times(place, year, month, day), place, is_lifted)


def _times(place: Place, year: int, month: int, day: int) -> np.ndarray:
    """Times of a day of a place's clocks, from its beginning to its end. (n,) [s]"""
    date = datetime(year, month, day)
    start = from_local(date, place.zone).seconds
    if (year, month, day) == (LAST_YEAR, 12, 31):
        end = start + DAY
    else:
        end = from_local(datetime.fromordinal(date.toordinal() + 1), place.zone).seconds
    return np.linspace(start, end, STEPS + 1)


def _directions(seconds: np.ndarray, place: Place, is_lifted: bool) -> np.ndarray:
    air = standard_air(place.elevation) if is_lifted else None
    return find_sun(seconds, place, air).directions(place.north)


def lines_above(directions: np.ndarray) -> np.ndarray:
    """Return what of a way lies above the horizon, as pairs of points; its ends lie on the horizon. (m, 3)"""
    starts, ends = directions[:-1], directions[1:]
    low, high = starts[:, 2], ends[:, 2]
    is_seen = (low > 0.0) | (high > 0.0)
    starts, ends, low, high = (each[is_seen] for each in (starts, ends, low, high))
    share = (low / np.where(low == high, 1.0, low - high))[:, None]
    crossing = starts + share * (ends - starts)
    starts = np.where((low < 0.0)[:, None], crossing, starts)
    ends = np.where((high < 0.0)[:, None], crossing, ends)
    return np.stack([starts, ends], axis=1).reshape(-1, 3)


def horizon() -> np.ndarray:
    """Return the horizon as pairs of points. (n, 3)"""
    turn = 2.0 * np.pi * np.arange(CIRCLE + 1) / CIRCLE
    ring = np.column_stack([np.sin(turn), np.cos(turn), 0.0 * turn])
    return np.stack([ring[:-1], ring[1:]], axis=1).reshape(-1, 3)


def compass(north: float) -> dict[str, np.ndarray]:
    """Return where the cardinal points lie in the scene, by their letters. ``north``: as of `Place`. [degree]"""
    turns = {letter: np.radians(90.0 * k - north) for k, letter in enumerate("NESW")}
    return {letter: np.array([np.sin(a), np.cos(a), 0.0]) for letter, a in turns.items()}


def find_nearest_time(seconds, points, mouse) -> float:
    """Return the time at which a way on the screen is next to a point, linear between its points.

    Parameters
    ----------
    seconds : (n,) array    [s]
    points : (n, 2) array    Where the way is then; NaN where it is not seen. [pixel]
    mouse : (2,) array    [pixel]

    Raises
    ------
    SceneError    Nothing of the way is seen.
    """
    starts, ends = points[:-1], points[1:]
    along = ends - starts
    length = np.maximum((along**2).sum(axis=1), 1e-12)
    share = np.clip(((mouse - starts) * along).sum(axis=1) / length, 0.0, 1.0)
    distance = np.linalg.norm(starts + share[:, None] * along - mouse, axis=1)
    if np.isnan(distance).all():
        raise SceneError("nothing of the sun's way is seen here")
    i = int(np.nanargmin(distance))
    return float(seconds[i] + share[i] * (seconds[i + 1] - seconds[i]))
