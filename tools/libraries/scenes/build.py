"""Builds the bundled scenes from nothing and saves them.

Those that ship are written by the oldest Blender at hand (``make scenes``): no Blender opens files of a newer one.
"""

from pathlib import Path

import bpy

from ....libraries.scenes import NAMES
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
    # The preferences stay: those of the factory would switch off an installed extension.
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    builder()


def save_scenes(folder: Path, names: tuple[str, ...] = NAMES) -> list[Path]:
    """Build scenes and save each as a compressed ``.blend`` file; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{name}.blend" for name in names]
    settings = bpy.context.preferences.filepaths
    # No .blend1 beside the files that ship.
    kept, settings.save_version = settings.save_version, 0
    try:
        for name, path in zip(names, paths, strict=True):
            build_scene(name)
            bpy.ops.wm.save_as_mainfile(
                filepath=str(path.resolve()), compress=True, relative_remap=True
            )
    finally:
        settings.save_version = kept
    return paths
