"""Requirements that the sensors of a scene can be judged by: those that ship, and those of the scene's own file."""

import functools
from pathlib import Path

import bpy

from ...engine.errors import LumenrayError
from ...engine.judgement.reader import known_requirements
from ...engine.judgement.requirement import Requirement


def requirements_of(settings) -> dict[str, Requirement]:
    """Return all requirements by key; those that ship alone where the scene's file cannot be used.

    ``settings``: a `LumenraySensorsSettings`.
    """
    try:
        return read_own(settings)
    except LumenrayError:
        # A list to choose from goes on; `read_own` says what is wrong where it matters.
        return _read("", 0)


def read_own(settings) -> dict[str, Requirement]:
    """Return all requirements by key.

    Raises
    ------
    FileFormatError    The scene's file cannot be read.
    """
    if not settings.requirement_file:
        return _read("", 0)
    path = Path(bpy.path.abspath(settings.requirement_file))
    try:
        stamp = path.stat().st_mtime_ns
    except OSError:
        stamp = -1
    return _read(str(path), stamp)


def find_requirements(self, context, text):
    """Keys and titles that hold what was typed, for a property that is searched."""
    wanted = text.casefold()
    known = requirements_of(context.scene.lumenray.sensors)
    return [
        (key, each.title)
        for key, each in known.items()
        if wanted in f"{key} {each.title}".casefold()
    ]


@functools.lru_cache(maxsize=8)
def _read(path: str, stamp: int) -> dict[str, Requirement]:
    """Return requirements; ``stamp``: time of the last change of the file, so that it is read again then."""
    return known_requirements([path] if path else [])
