"""Requirements by which a scene's sensors are judged: those that ship, and those of a file of the user's own."""

import functools
from pathlib import Path

import bpy

from ...engine.errors import LumenrayError
from ...engine.judgement.reader import known_requirements
from ...engine.judgement.requirement import Requirement


def requirements_of(scene, more=()) -> dict[str, Requirement]:
    """Return the requirements that a scene knows, by key; its own file counts before what ships.

    Parameters
    ----------
    scene : bpy.types.Scene
    more : iterable of Path    Further files, which count before both.

    Raises
    ------
    FileFormatError    A file cannot be read; the sentence names it.
    """
    return _read(tuple((path, _state(path)) for path in (*files_of(scene), *more)))


def files_of(scene) -> tuple[Path, ...]:
    """Return the scene's own files of requirements."""
    own = scene.lumenray.sensors.requirements_file
    return (Path(bpy.path.abspath(own)),) if own else ()


def known_keys(scene) -> dict[str, Requirement]:
    """As `requirements_of`, for lists to choose from: what ships alone while the scene's own file cannot be read."""
    try:
        return requirements_of(scene)
    except LumenrayError:
        # The panel says what is wrong with it.
        return _read(())


def _state(path: Path) -> tuple[int, int] | None:
    """What tells when a file has changed; None: it is not there."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


@functools.lru_cache(maxsize=8)
def _read(files: tuple) -> dict[str, Requirement]:
    return known_requirements(path for path, _ in files)
