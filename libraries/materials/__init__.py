"""Materials that ship: scattering computed from physics, metals and glasses by published constants; and such folders."""

from functools import lru_cache
from pathlib import Path

from ..entries import Problem
from .catalogue import PREFIX, Entry, Library, by_category, read_library

__all__ = [
    "FOLDER",
    "LIBRARY",
    "PREFIX",
    "Entry",
    "Library",
    "Problem",
    "by_category",
    "entries",
    "find_entry",
    "read_library",
]

LIBRARY = Path(__file__).parent
"""Folder of the library; it is a Blender asset library as well."""

FOLDER = LIBRARY / "files"
"""Where its scattering files lie."""


@lru_cache
def entries() -> tuple[Entry, ...]:
    """Return all materials that ship, by category and title."""
    return read_library(LIBRARY).entries


def find_entry(name: str) -> Entry:
    """Return a material that ships.

    Raises
    ------
    KeyError    There is none of that name.
    """
    for entry in entries():
        if entry.name == name:
            return entry
    raise KeyError(name)
