"""Builds the bundled scenes from nothing and saves them."""

from pathlib import Path

import bpy

from . import FOLDER, NAMES
from .office import build_office
from .tiny import build_closed_box, build_inverse_square, build_materials

BUILDERS = {
    "office": build_office,
    "inverse_square": build_inverse_square,
    "closed_box": build_closed_box,
    "materials": build_materials,
}
"""What builds each bundled scene."""


def build_scene(name: str) -> None:
    """Replace the current file by an empty one and build a bundled scene in it.

    Our property groups must be registered.

    Raises
    ------
    KeyError    There is no bundled scene of that name.
    """
    builder = BUILDERS[name]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    builder()


def save_scenes(names: tuple[str, ...] = NAMES, folder: Path = FOLDER) -> list[Path]:
    """Build scenes and save each as a compressed ``.blend`` file; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    # No .blend1 beside the files that ship.
    bpy.context.preferences.filepaths.save_version = 0
    for name in names:
        build_scene(name)
        bpy.context.preferences.filepaths.save_version = 0
        path = folder / f"{name}.blend"
        bpy.ops.wm.save_as_mainfile(
            filepath=str(path.resolve()), compress=True, relative_remap=True
        )
        paths.append(path)
    return paths
