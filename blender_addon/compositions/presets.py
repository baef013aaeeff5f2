"""Compositions that users keep as presets: JSON files in folders beside those of Blender's presets."""

from pathlib import Path

import bpy

PAINTS, INKS, CLOTHS = "lumenray_paints", "lumenray_inks", "lumenray_cloths"
"""Folders of what is kept: paints, pigment layers and cloths."""


def folder_of(kind: str) -> Path:
    """Return where presets of a kind lie, which may not be there yet."""
    return Path(bpy.utils.user_resource("SCRIPTS", path=f"presets/{kind}"))


def files_of(kind: str) -> dict[str, Path]:
    """Return the files of presets of a kind, by their names."""
    folder = folder_of(kind)
    return {path.stem: path for path in sorted(folder.glob("*.json"))} if folder.is_dir() else {}


def title_of(name: str) -> str:
    """Return the name of a preset for people."""
    return name.replace("_", " ").capitalize()
