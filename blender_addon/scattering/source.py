"""Whether a material scatters as a file says, where that file is, and what people call it."""

from pathlib import Path

import bpy

from ...libraries.materials import FOLDER, PREFIX

MEASURED = "MEASURED"
"""Name of the model of a surface in the settings of a material."""


def is_measured(material) -> bool:
    """Whether a material scatters as a file says."""
    settings = material.lumenray
    return settings.use_override and settings.model == MEASURED


def absolute_path(settings) -> str:
    """Return where a scattering file is, empty if none is chosen."""
    if settings.filepath.startswith(PREFIX):
        # A name, not a path that leads out of the library.
        name = Path(settings.filepath.removeprefix(PREFIX)).name
        return str(FOLDER / f"{name}.lumbsdf")
    if not settings.filepath:
        return ""
    return bpy.path.abspath(settings.filepath, library=settings.id_data.library)


def name_of(settings) -> str:
    """Name of the file for people."""
    if settings.text is not None:
        return settings.text.name
    return bpy.path.basename(settings.filepath.removeprefix(PREFIX))
