"""Cities and time zones to choose from: those that ship, and those of the user's list."""

import math
from collections import Counter
from functools import lru_cache
from pathlib import Path

from ...imports import loaded_when_used
from ...libraries.entries import Problem
from ..foundation import preferences

with loaded_when_used():
    import zoneinfo

    from ...libraries.cities import catalogue

MOST = 100
"""Cities that are offered at once."""


def search_cities(self, context, text: str) -> list[str]:
    """Return the titles of cities that a text may mean, for a search field."""
    return [city.title for city in catalogue.find_cities(text, known_cities()[0], MOST)]


def search_zones(self, context, text: str) -> list[str]:
    """Return names of time zones that contain a text, for a search field."""
    wanted = catalogue.fold(text)
    return [name for name in _zones() if wanted in catalogue.fold(name)]


@lru_cache
def _zones() -> list[str]:
    return sorted(zoneinfo.available_timezones())


def known_cities() -> "tuple[list[catalogue.City], list[Problem]]":
    """Return all cities, and what is wrong with the user's list."""
    return _read(*_list())


def _list() -> tuple[str, int, int]:
    """Path of the user's list of cities, empty without one, and what tells whether it has changed."""
    path = preferences.city_list()
    if path is None:
        return "", 0, 0
    try:
        stat = path.stat()
    except OSError:
        # Reading it says what is wrong.
        return str(path), 0, 0
    return str(path), stat.st_mtime_ns, stat.st_size


@lru_cache(maxsize=4)
def _read(path: str, changed: int, size: int) -> "tuple[list[catalogue.City], list[Problem]]":
    return catalogue.all_cities([Path(path)] if path else [])


def find_city(title: str) -> "catalogue.City | None":
    """Return the city of a title, or of a name that only one has; None if there is none."""
    return _by_name(*_list()).get(catalogue.fold(title))


@lru_cache(maxsize=4)
def _by_name(path: str, changed: int, size: int) -> "dict[str, catalogue.City]":
    """Cities by folded titles, and by folded names that only one has."""
    cities = _read(path, changed, size)[0]
    names = Counter(catalogue.fold(city.name) for city in cities)
    single = {
        catalogue.fold(city.name): city for city in cities if names[catalogue.fold(city.name)] == 1
    }
    return single | {catalogue.fold(city.title): city for city in cities}


def fill_in_city(place) -> None:
    """Set coordinates, height and zone of a place's settings to those of the city that it names, if that is known."""
    city = find_city(place.city)
    if city is None:
        return
    place.latitude, place.longitude = math.radians(city.latitude), math.radians(city.longitude)
    place.elevation, place.zone = city.elevation, city.zone


def is_at_city(place) -> bool:
    """Tell whether a place's settings are those of the city that they name."""
    city = find_city(place.city)
    if city is None:
        return False
    own = math.degrees(place.latitude), math.degrees(place.longitude)
    far = max(abs(own[0] - city.latitude), abs(own[1] - city.longitude))
    return far < 1e-3 and place.zone == city.zone
