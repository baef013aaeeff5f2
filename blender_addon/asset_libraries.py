"""Our luminaires and materials, and a folder of the user's own, as asset libraries in Blender's preferences.

They are there while the extension is on. Whether the preferences count as changed by the user is left as it was, so that
switching the extension on and off does not make Blender save them.
"""

import os
from contextlib import contextmanager
from pathlib import Path

import bpy

from ..libraries import luminaires, materials
from .foundation import preferences

NAME = "Lumenray"
"""Of the luminaires that ship, in the Asset Browser."""

MATERIALS_NAME = "Lumenray: materials"
"""Of the materials that ship, in the Asset Browser."""

SHIPPED = {NAME: luminaires.FOLDER, MATERIALS_NAME: materials.LIBRARY}
"""Folders of the libraries that ship, by their names."""

OWN_NAME = "Lumenray: own assets"
"""Of the user's folder, in the Asset Browser."""


def attach() -> None:
    """Let the libraries be where they are now."""
    with _unchanged_preferences():
        for name, folder in SHIPPED.items():
            _place(_shipped(folder), name, folder)
    follow_own_folder()


def detach() -> None:
    """Take our libraries away again; all others stay."""
    with _unchanged_preferences():
        for folder in SHIPPED.values():
            for library in _shipped(folder):
                _libraries().remove(library)
        for library in _own():
            _libraries().remove(library)


def follow_own_folder() -> None:
    """Let the user's library be the folder that the preferences name, or none."""
    folder = preferences.luminaire_folder()
    with _unchanged_preferences():
        if folder is not None:
            _place(_own(), OWN_NAME, folder)
            return
        for library in _own():
            _libraries().remove(library)


def _libraries():
    return bpy.context.preferences.filepaths.asset_libraries


def _shipped(folder: Path) -> list:
    """Entries of a library that ships, also of a version that lay elsewhere; never a library of the user's own."""
    ending = folder.parts[-2:]
    named = [library for library in _libraries() if library.name.startswith(NAME)]
    return [library for library in named if Path(library.path).parts[-2:] == ending]


def _own() -> list:
    return [library for library in _libraries() if library.name == OWN_NAME]


def _place(found: list, name: str, folder: Path) -> None:
    """Let a library be a folder; what is taken from it is appended, so that it can be edited."""
    library = found[0] if found else _libraries().new(name=name, directory=str(folder))
    if os.path.normpath(library.path) != os.path.normpath(folder):
        library.path = str(folder)
    library.import_method = "APPEND"
    for other in found[1:]:
        _libraries().remove(other)


@contextmanager
def _unchanged_preferences():
    was_dirty = bpy.context.preferences.is_dirty
    try:
        yield
    finally:
        bpy.context.preferences.is_dirty = was_dirty
