"""Where the file of a ray set is, and what people call it."""

from pathlib import Path

import bpy

from ...libraries.raysets import FOLDER, PREFIX


def absolute_path(settings) -> str:
    """Return where a ray file is, empty if none is chosen."""
    if settings.filepath.startswith(PREFIX):
        # A name, not a path that leads out of the library.
        name = Path(settings.filepath.removeprefix(PREFIX)).name
        return str(FOLDER / f"{name}.tm25ray")
    if not settings.filepath:
        return ""
    return bpy.path.abspath(settings.filepath, library=settings.id_data.library)


def name_of(settings) -> str:
    """Name of the file for people."""
    if settings.filepath.startswith(PREFIX):
        return settings.filepath.removeprefix(PREFIX)
    return bpy.path.basename(settings.filepath)
