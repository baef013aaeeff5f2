"""Where files lie: paths as Blender keeps them, files of ours by name, what tells contents apart, and places for copies."""

import hashlib
from pathlib import Path
from typing import NamedTuple

import bpy

from ...engine.reading.content import holds
from ...engine.reading.whole_file import write_whole


class Library(NamedTuple):
    """Files of ours, which settings name instead of their path: the folder differs from machine to machine.

    Parameters
    ----------
    prefix : str    What such names begin with.
    folder : Path
    ending : str    Of the files.
    """

    prefix: str
    folder: Path
    ending: str

    def path_of(self, name: str) -> str:
        """Return where a file is."""
        # A name, not a path that leads out of the library.
        return str(self.folder / f"{Path(name.removeprefix(self.prefix)).name}{self.ending}")


def stored_path(path: str) -> str:
    """Path as Blender keeps it: relative to the .blend file where the user prefers that."""
    if not bpy.data.filepath or not bpy.context.preferences.filepaths.use_relative_paths:
        return path
    try:
        return bpy.path.relpath(path)
    except ValueError:
        # Another drive of Windows.
        return path


def stamp(path: str) -> tuple:
    """Date and size of a file, () if there is none."""
    try:
        found = Path(path).stat()
    except (OSError, ValueError):
        return ()
    return (found.st_mtime_ns, found.st_size)


def digest_of(data: bytes) -> str:
    """SHA-256 of a content in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def write_copy(data: bytes, folder: str, name: str) -> Path:
    """Write a content into a folder, where nothing else is overwritten, and return its path.

    Parameters
    ----------
    data : bytes
    folder : str    May start with ``//``; made if there is none.
    name : str    Of the file; a number is added where another one has it.

    Raises
    ------
    FileFormatError    It cannot be written.
    """
    stem, ending = bpy.path.clean_name(Path(name).stem), Path(name).suffix
    place = Path(bpy.path.abspath(folder))
    path, number = place / f"{stem}{ending}", 1
    while path.exists() and not holds(path, data):
        number += 1
        path = place / f"{stem}_{number}{ending}"
    with write_whole(path) as file:
        file.write(data)
    return path
