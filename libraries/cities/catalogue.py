"""Reads lists of cities, the one that ships and those of users, and finds a city by the beginning of its name.

A list is a table in CSV with these columns in any order; a user's may have others, which are left alone::

    name,country,latitude,longitude,elevation_m,zone
    Munich/München,Germany,48.14,11.58,520,Europe/Berlin

Names that a city has besides follow the first after a slash. Latitude and longitude are in degrees, positive to the north
and to the east; the elevation above the sea may be left empty, which is 0. The zone is a name of the IANA's time zone data.
What cannot be used is told and left out; nothing of it ends the reading.

The list that ships was put together for Lumenray from common knowledge: coordinates of city centres to 0.01 degrees (about
1 km), elevations to some ten metres. Its author's rights are waived (CC0-1.0).
"""

import csv
import io
import unicodedata
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from ..entries import Problem
from ..plain_files import UnreadableError, read_plain

FILE = Path(__file__).parent / "cities.csv"
"""The list that ships."""

LARGEST_FILE = 4 << 20
"""Larger lists are not read. [byte]"""

MOST_CITIES = 50_000
"""More cities of a list are left out."""

MOST_PROBLEMS = 100
"""More problems of a list are not told one by one."""

LONGEST_NAME = 120
"""Longer names are left out. [character]"""

COLUMNS = ("name", "country", "latitude", "longitude", "zone")
"""Columns that have to be there."""

ELEVATION = "elevation_m"

BOUNDS = {"latitude": (-90.0, 90.0), "longitude": (-180.0, 180.0), ELEVATION: (-500.0, 9000.0)}
"""Least and greatest number."""

_PLAIN = str.maketrans(
    {"ø": "o", "ł": "l", "đ": "d", "ð": "d", "þ": "th", "æ": "ae", "œ": "oe", "\u0131": "i"}
    | dict.fromkeys("'`.\u2019\u02bb")
    | dict.fromkeys("-,/", " ")
)
"""Letters that are no accented ones, apostrophes, and what parts words; the dotless i, the curved quote, the okina."""


@dataclass(frozen=True)
class City:
    """A city.

    Parameters
    ----------
    name : str    As it is shown.
    other_names : tuple of str    By which it is found too.
    country : str
    latitude, longitude : float    Positive north and east. [degree]
    elevation : float    Above the sea. [m]
    zone : str    Name in the time zone data of the IANA.
    """

    name: str
    other_names: tuple[str, ...]
    country: str
    latitude: float
    longitude: float
    elevation: float
    zone: str

    @property
    def title(self) -> str:
        """Name and country."""
        return f"{self.name}, {self.country}" if self.country else self.name


@lru_cache
def shipped_cities() -> tuple[City, ...]:
    """Return the cities that ship."""
    return tuple(read_cities(FILE)[0])


def all_cities(paths=()) -> tuple[list[City], list[Problem]]:
    """Return the cities of users' lists and those that ship.

    Parameters
    ----------
    paths : sequence of str or Path    Of users' lists; a city takes the place of one of the same name and country in a list
        after it or in the one that ships.

    Returns
    -------
    (list of City, list of Problem)    In the order of their names.
    """
    cities, problems = {}, []
    for path in reversed(paths):
        own, faults = read_cities(path)
        cities |= {_key(city): city for city in own}
        problems = faults + problems
    cities = {_key(city): city for city in shipped_cities()} | cities
    return sorted(cities.values(), key=lambda city: (fold(city.name), city.title)), problems


def _key(city: City) -> tuple[str, str]:
    return fold(city.name), fold(city.country)


def read_cities(path) -> tuple[list[City], list[Problem]]:
    """Read a list of cities.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    (list of City, list of Problem)    Those that can be used, and what was left out and why.
    """
    path = Path(path)
    try:
        text = read_plain(path, LARGEST_FILE).decode("utf-8-sig")
    except UnreadableError as error:
        return [], [Problem(path, str(error))]
    except UnicodeDecodeError as error:
        return [], [Problem(path, f"is not UTF-8 at byte {error.start}")]
    rows = csv.reader(io.StringIO(text, newline=""), strict=True)
    cities, problems = [], []
    try:
        header = [field.strip().casefold() for field in next(rows, [])]
        missing = [name for name in COLUMNS if name not in header]
        if missing:
            return [], [Problem(path, f"line 1 has no column '{missing[0]}'")]
        for row in rows:
            if not any(field.strip() for field in row):
                continue
            city = _city(dict(zip(header, (field.strip() for field in row), strict=False)))
            if isinstance(city, City):
                cities.append(city)
            elif len(problems) < MOST_PROBLEMS:
                problems.append(Problem(path, f"line {rows.line_num} {city}"))
            if len(cities) > MOST_CITIES:
                cities.pop()
                problems.append(Problem(path, f"has more than {MOST_CITIES} cities"))
                break
    except csv.Error as error:
        problems.append(Problem(path, f"line {rows.line_num} is no CSV: {error}"))
    return cities, problems


def _city(fields: dict[str, str]) -> City | str:
    """City of a row, or what is wrong with it."""
    for name in COLUMNS:
        if not fields.get(name) and name != "country":
            return f"has no {name}"
    names = [name.strip() for name in fields["name"].split("/")]
    if not all(names) or max(map(len, [*names, fields.get("country", "")])) > LONGEST_NAME:
        return "has a name that is empty or too long"
    numbers = {}
    for name, (low, high) in BOUNDS.items():
        value = _number(fields.get(name, "") or "0")
        if value is None or not low <= value <= high:
            return f"has '{fields[name][:40]}' as {name}, expected {low:g} to {high:g}"
        numbers[name] = value
    if not _is_zone(fields["zone"]):
        return f"has the zone '{fields['zone'][:60]}', expected a name such as Europe/Berlin"
    return City(
        names[0],
        tuple(names[1:]),
        fields.get("country", ""),
        numbers["latitude"],
        numbers["longitude"],
        numbers[ELEVATION],
        fields["zone"],
    )


def _number(text: str) -> float | None:
    if not text.isascii() or "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return None


@lru_cache(maxsize=1024)
def _is_zone(name: str) -> bool:
    try:
        ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError):
        return False
    return True


def fold(text: str) -> str:
    """Return a name as it is compared: without accents, case, hyphens and apostrophes."""
    plain = unicodedata.normalize("NFD", text.casefold())
    plain = "".join(sign for sign in plain if not unicodedata.combining(sign))
    return " ".join(plain.translate(_PLAIN).split())


def find_cities(query: str, cities, most: int = 20) -> list[City]:
    """Return cities whose name, or a word of it, begins with a text; what follows a comma is the beginning of the country.

    Parameters
    ----------
    query : str
    cities : iterable of City
    most : int    Returned at most.

    Returns
    -------
    list of City    Those whose first name begins so come first, then those that another name tells, then words within; each
        in the order of ``cities``.
    """
    start, _, country = (fold(part) for part in query.partition(","))
    ranked = ([], [], [])
    for city in cities:
        if not fold(city.country).startswith(country):
            continue
        names = [fold(name) for name in (city.name, *city.other_names)]
        if names[0].startswith(start):
            ranked[0].append(city)
        elif any(name.startswith(start) for name in names):
            ranked[1].append(city)
        elif any(f" {name}".find(f" {start}") >= 0 for name in names):
            ranked[2].append(city)
    return [city for rank in ranked for city in rank][:most]
