"""The moment that a world's settings state at a frame, and where the sun stands then."""

import calendar
import math
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import lru_cache

import numpy as np

from ...engine.sky.air import standard_air
from ...engine.sky.place import Place, from_local, to_local
from ...engine.sky.solar_position import SunDay, find_day, find_sun


@dataclass(frozen=True, eq=False)
class Moment:
    """A moment at a place.

    Parameters
    ----------
    place : Place
    seconds : float    Universal time since 1970. [s]
    clock : datetime    What the place's clocks show, with their zone.
    note : str    What was assumed about the clock, for people; empty if nothing was.
    elevation, azimuth : float    Of the sun, the azimuth from north over east. [degree]
    distance : float    Of the sun. [astronomical unit]
    towards_sun : (3,) array    Unit vector in the scene's axes.
    """

    place: Place
    seconds: float
    clock: datetime
    note: str
    elevation: float
    azimuth: float
    distance: float
    towards_sun: np.ndarray

    @property
    def title(self) -> str:
        """Place, date, clock and the sun's elevation in one line."""
        offset = self.clock.strftime("%z")
        where = f"{self.place.name}  " if self.place.name else ""
        date = f"{self.clock.year:04d}-{self.clock:%m-%d %H:%M}"
        return f"{where}{date} UTC{offset[:3]}:{offset[3:5]}  sun {self.elevation:.1f}°"


def frame_of(scene) -> float:
    """Return a scene's frame, with its part of a frame."""
    return scene.frame_current + scene.frame_subframe


def read_place(world) -> Place:
    """Return the place of a world's settings."""
    settings = world.lumenray.place
    return Place(
        round(math.degrees(settings.latitude), 5),
        round(math.degrees(settings.longitude), 5),
        settings.zone,
        settings.elevation,
        round(math.degrees(settings.north), 5),
        settings.city.partition(",")[0],
    )


def find_moment(world, frame: float) -> Moment:
    """Return the moment of a world at a frame.

    Raises
    ------
    SceneError    The zone is not known, or the moment is beyond the years in which the sun is known.
    """
    place, time = read_place(world), world.lumenray.time
    start, note = _start(time, place.zone)
    seconds = start + _elapsed(time, frame)
    if seconds != start:
        # Going on leads past whatever the clock does; only the start can be doubtful.
        note = f"at the start {note}" if note else ""
    return _moment(place, seconds, note, time.use_refraction)


def _start(time, zone: str) -> tuple[float, str]:
    last = calendar.monthrange(time.year, time.month)[1]
    day = min(time.day, last)
    clock = datetime(time.year, time.month, day) + timedelta(
        hours=round(time.hour * 3600.0) / 3600.0
    )
    start = from_local(clock, zone, is_second=time.is_second)
    notes = [start.note] if start.note else []
    if day < time.day:
        name = calendar.month_name[time.month]
        notes.append(f"{name} {time.year} has {last} days, and the last was taken")
    return start.seconds, "; ".join(notes)


def _elapsed(time, frame: float) -> float:
    """Time since the start. [s]"""
    if not time.follows_frames:
        return 0.0
    return (frame - time.first_frame) * time.minutes_per_frame * 60.0


@lru_cache(maxsize=256)
def _moment(place: Place, seconds: float, note: str, is_lifted: bool) -> Moment:
    air = standard_air(place.elevation) if is_lifted else None
    sun = find_sun(seconds, place, air)
    return Moment(
        place,
        seconds,
        to_local(seconds, place.zone),
        note,
        float(sun.elevation),
        float(sun.azimuth),
        float(sun.distance),
        sun.directions(place.north),
    )


def find_day_of(moment: Moment) -> SunDay:
    """Return rise, noon and set of a moment's day."""
    clock = moment.clock
    return _day(clock.year, clock.month, clock.day, moment.place)


@lru_cache(maxsize=16)
def _day(year: int, month: int, day: int, place: Place) -> SunDay:
    return find_day(year, month, day, place)


def state_moment(world, frame: float, seconds: float) -> None:
    """Set a world's time so that it is a moment at a frame. ``seconds``: universal time since 1970. [s]"""
    time, zone = world.lumenray.time, read_place(world).zone
    clock = to_local(seconds - _elapsed(time, frame), zone)
    time.year, time.month, time.day = clock.year, clock.month, clock.day
    time.hour = clock.hour + clock.minute / 60.0 + clock.second / 3600.0
    time.is_second = bool(clock.fold)


def follows_frames(world) -> bool:
    """Tell whether a world, or None, has a time that goes on with the frames."""
    return world is not None and world.lumenray.time.follows_frames
