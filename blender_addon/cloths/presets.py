"""Presets of cloths: those that ship, and those of the user, as files of compositions."""

from pathlib import Path

from ...engine.cloth.reader import read_cloth, whole_content
from ...libraries import cloths
from ..compositions.presets import CLOTHS, files_of
from .description import adopt
from .tables import is_cloth

FIRST = "cotton"
"""Preset that a new cloth begins with."""


def shipped() -> dict[str, Path]:
    """Return the files of presets that ship, by their names."""
    return cloths.presets()


def own() -> dict[str, Path]:
    """Return the files of the user's presets, by their names."""
    return files_of(CLOTHS)


def load(settings, path) -> None:
    """Let settings state the cloth of a file.

    Raises
    ------
    FileFormatError    It cannot be read.
    """
    # Settings have no place of their own that a bitmap could lie beside.
    adopt(settings, whole_content(read_cloth(path)))


def begin(material) -> None:
    """Give a material that has become a cloth a preset to begin with."""
    settings = material.lumenray.cloth
    if is_cloth(material) and not settings.content:
        load(settings, shipped()[FIRST])
