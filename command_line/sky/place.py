"""Where and when: options of the commands about skies, and what they come to."""

import argparse
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from ...engine.errors import SceneError
from ..options import real
from ..output import complain

MOST_NAMED = 5
"""Cities that a refusal names."""


@dataclass(frozen=True)
class Moment:
    """A time at a place.

    Parameters
    ----------
    clock : datetime    With its zone.
    seconds : float    Of universal time since 1970. [s]
    note : str    What was assumed where the clock shows this twice or never; or empty.
    """

    clock: datetime
    seconds: float
    note: str


def add_place(parser) -> None:
    """Let a command be told a place, a time and a weather file."""
    place = parser.add_argument_group("place and time")
    place.add_argument(
        "--place", metavar="CITY", help="city of the library, such as 'Berlin' or 'San Jose, Costa'"
    )
    place.add_argument(
        "--cities",
        action="append",
        default=[],
        type=Path,
        metavar="LIST.csv",
        help="more cities for --place: columns name, country, latitude, longitude, elevation_m, zone (may be repeated)",
    )
    place.add_argument("--latitude", type=real(-90.0, 90.0), metavar="DEG", help="positive north")
    place.add_argument("--longitude", type=real(-180.0, 180.0), metavar="DEG", help="positive east")
    place.add_argument(
        "--zone",
        metavar="ZONE",
        help="time zone, such as Europe/Berlin or UTC+5:30 (default: the city's or the file's; UTC for coordinates)",
    )
    place.add_argument(
        "--elevation", type=real(-500.0, 9000.0), metavar="M", help="above the sea in metres"
    )
    place.add_argument(
        "--time",
        type=read_clock,
        metavar="TIME",
        help="of the place's clocks, such as 2026-06-21T12:00",
    )
    place.add_argument(
        "--weather", type=Path, metavar="FILE", help="weather file, EPW or WEA; its place counts"
    )


def read_clock(text: str) -> datetime:
    """Read what a clock shows."""
    try:
        clock = datetime.fromisoformat(text)
    except ValueError:
        clock = None
    if clock is None or clock.tzinfo is not None or "T" not in text.upper().replace(" ", "T"):
        raise argparse.ArgumentTypeError(
            f"expected date and time of the place's clocks such as 2026-06-21T12:00, found '{text}'"
        )
    return clock


def find_place(options, weather=None):
    """Return the place that was asked for, or None.

    Raises
    ------
    SceneError    It is told twice or in part, or it is none.
    """
    from ...engine.sky.place import Place, check_place

    has_numbers = options.latitude is not None or options.longitude is not None
    if sum((options.place is not None, has_numbers, weather is not None)) > 1:
        raise SceneError(
            "the place is told twice: expected one of --place, --latitude with --longitude, and --weather"
        )
    if weather is not None:
        found = weather.place
    elif options.place is not None:
        found = _find_city(options.place, options.cities)
    elif has_numbers:
        if options.latitude is None or options.longitude is None:
            raise SceneError("a place needs both --latitude and --longitude")
        found = Place(options.latitude, options.longitude)
    else:
        return None
    if options.zone is not None:
        found = replace(found, zone=options.zone)
    if options.elevation is not None:
        found = replace(found, elevation=options.elevation)
    check_place(found)
    return found


def _find_city(query: str, lists):
    from ...engine.sky.place import Place
    from ...libraries.cities.catalogue import all_cities, find_cities, fold, read_cities

    for path in lists:
        own, problems = read_cities(path)
        if problems and not own:
            raise SceneError(str(problems[0]))
        for problem in problems:
            complain(problem)
    known, _ = all_cities(lists)
    cities = find_cities(query, known, 1000)
    wanted = fold(query.partition(",")[0])
    exact = [city for city in cities if wanted in map(fold, (city.name, *city.other_names))]
    cities = exact or cities
    if not cities:
        raise SceneError(
            f"no city of the library is called '{query}'; give --latitude, --longitude and --zone"
        )
    if len(cities) > 1:
        names = "; ".join(city.title for city in cities[:MOST_NAMED])
        more = " and others" if len(cities) > MOST_NAMED else ""
        raise SceneError(
            f"'{query}' may be {names}{more}; write the whole name, with its country after a comma"
        )
    city = cities[0]
    return Place(city.latitude, city.longitude, city.zone, city.elevation, name=city.title)


def find_moment(options, place) -> Moment | None:
    """Return the time that was asked for, or None.

    Raises
    ------
    SceneError    There is no such time at the place.
    """
    from ...engine.sky.place import from_local, to_local

    if options.time is None:
        return None
    found = from_local(options.time, place.zone)
    return Moment(to_local(found.seconds, place.zone), found.seconds, found.note)


def find_record(weather, times, seconds: float) -> int | None:
    """Return the record in whose interval a time lies, or which begins at it; ``times``: middles of the intervals. [s]"""
    import numpy as np

    half = 0.5 * weather.interval * 3600.0
    # Middles are known to some microseconds.
    inside = np.flatnonzero((times - half <= seconds + 1e-3) & (seconds + 1e-3 < times + half))
    return int(inside[-1]) if len(inside) else None
