"""Luminaires and lamps that ship: photometric files with what belongs to them, and the reader of such folders."""

from functools import lru_cache
from pathlib import Path

from ..entries import Problem
from .catalogue import read_library
from .model import Library, Light, Model, Part

__all__ = [
    "FOLDER",
    "Library",
    "Light",
    "Model",
    "Part",
    "Problem",
    "find_model",
    "models",
    "read_library",
]

FOLDER = Path(__file__).parent
"""Folder of the library; it is a Blender asset library as well."""


@lru_cache
def models() -> tuple[Model, ...]:
    """Return all models that ship, by category and title."""
    return read_library(FOLDER).models


def find_model(name: str) -> Model:
    """Return a model that ships.

    Raises
    ------
    KeyError    There is none of that name.
    """
    for item in models():
        if item.name == name:
            return item
    raise KeyError(name)
