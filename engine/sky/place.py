"""Places on the Earth and what their clocks show: from local time to seconds of universal time and back.

Times inside are seconds of universal time since 1970-01-01 0:00, without leap seconds, as POSIX counts them. Universal time
by clocks (UTC) differs from that by the Earth's rotation (UT1) by less than 0.9 s, in which the sun moves 0.004 degrees.

Zones have names of the IANA's time zone data (``Europe/Berlin``), whose rules hold for every year, those of before standard
time (local mean time) too; or they keep a fixed offset (``UTC``, ``UTC+5:30``, ``UTC-8``), as weather files do.
"""

import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta, timezone, tzinfo
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np

from ..errors import SceneError
from .limits import FIRST_YEAR, HIGHEST, LAST_YEAR, LOWEST

LARGEST_OFFSET = 15.0
"""Zones are never farther from universal time. [h]"""

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)

_FIXED = re.compile(r"UTC(?:([+-])(\d{1,2})(?::(\d{2}))?)?")


@dataclass(frozen=True)
class Place:
    """Where on the Earth a scene lies, and how it is turned.

    Parameters
    ----------
    latitude : float    Positive north. [degree]
    longitude : float    Positive east. [degree]
    zone : str    Name of the zone, or a fixed offset such as ``UTC+5:30``.
    elevation : float    Above the sea. [m]
    north : float    Compass direction in which the scene's +y axis points: 0 north, 90 east. [degree]
    name : str    For people.
    """

    latitude: float
    longitude: float
    zone: str = "UTC"
    elevation: float = 0.0
    north: float = 0.0
    name: str = ""


@dataclass(frozen=True)
class LocalTime:
    """Universal time of what a clock shows, and what was assumed if it shows that twice or never.

    Parameters
    ----------
    seconds : float    Of universal time since 1970. [s]
    offset : float    Of the clock from universal time. [h]
    note : str    One sentence for people; empty: the clock shows this once.
    """

    seconds: float
    offset: float
    note: str = ""


def check_place(place: Place) -> None:
    """Refuse a place that is none.

    Raises
    ------
    SceneError    Names what is wrong.
    """
    _within("latitude", place.latitude, -90.0, 90.0, "degrees")
    _within("longitude", place.longitude, -180.0, 180.0, "degrees")
    _within("elevation", place.elevation, LOWEST, HIGHEST, "m")
    _within("north", place.north, -360.0, 360.0, "degrees")
    find_zone(place.zone)


def _within(what: str, value: float, low: float, high: float, unit: str) -> None:
    if not (np.isfinite(value) and low <= value <= high):
        raise SceneError(
            f"the place's {what} is {value} {unit}, expected {low:g} to {high:g} {unit}"
        )


def find_zone(name: str) -> tzinfo:
    """Return a zone by its name.

    Raises
    ------
    SceneError    There is none of this name, or the system has no time zone data.
    """
    fixed = _FIXED.fullmatch(name)
    if fixed is not None:
        sign, hours, minutes = fixed.groups(default="0")
        offset = timedelta(hours=int(hours), minutes=int(minutes))
        if int(minutes) > 59 or offset > timedelta(hours=LARGEST_OFFSET):
            raise SceneError(f"the time zone '{name}' is farther from UTC than any")
        return timezone(-offset if sign == "-" else offset, name)
    try:
        return ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError):
        raise SceneError(
            f"the time zone '{name[:60]}' is not known here, expected a name such as Europe/Berlin, or an offset such "
            "as UTC+1"
        ) from None


def name_offset(hours: float) -> str:
    """Return the name of the zone with a fixed offset. [h, to the minute]"""
    minutes = round(abs(hours) * 60.0)
    if minutes == 0:
        return "UTC"
    sign = "+" if hours > 0.0 else "-"
    whole, rest = divmod(minutes, 60)
    return f"UTC{sign}{whole}" + (f":{rest:02d}" if rest else "")


def from_local(clock: datetime, zone: str, *, is_second: bool = False) -> LocalTime:
    """Return the universal time of what a clock shows.

    Where clocks are put back, they show an hour twice: the first is taken, or the second if asked for. Where they are put
    forward, they leave an hour out: a time in it is taken as that of a clock which has not been put forward yet. Both are
    said in the note.

    Parameters
    ----------
    clock : datetime    Without a zone.
    zone : str    As in `Place`.
    is_second : bool    Which of two is meant.

    Raises
    ------
    SceneError    The zone is not known, or the year is beyond 1900 to 2100.
    """
    rules = find_zone(zone)
    if not FIRST_YEAR <= clock.year <= LAST_YEAR:
        raise SceneError(f"the year is {clock.year}, expected {FIRST_YEAR} to {LAST_YEAR}")
    first, second = (clock.replace(tzinfo=rules, fold=fold).astimezone(UTC) for fold in (0, 1))
    if second > first:
        chosen = second if is_second else first
        which = "second" if is_second else "first"
        note = f"clocks of {zone} show {_show(clock)} twice, and the {which} was taken"
    else:
        # In a gap the first has the offset from before it: the same moment as if nobody had put the clock forward.
        chosen, note = first, ""
        if second < first:
            shown = _show(first.astimezone(rules))
            note = f"clocks of {zone} leave out {_show(clock)}, and {shown} was taken"
    offset = chosen.astimezone(rules).utcoffset()
    return LocalTime((chosen - _EPOCH).total_seconds(), offset.total_seconds() / 3600.0, note)


def to_local(seconds: float, zone: str) -> datetime:
    """Return what a clock shows, with its zone, to the microsecond. [s since 1970, universal time]"""
    return (_EPOCH + timedelta(seconds=float(seconds))).astimezone(find_zone(zone))


def _show(clock: datetime) -> str:
    return f"{clock:%H:%M} on {clock.year:04d}-{clock:%m-%d}"
