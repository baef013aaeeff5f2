"""Presets of pigment layers: those that ship, and those of the user, as files of compositions."""

from pathlib import Path

from ...engine.ink.reader import read_ink
from ...libraries import inks
from ..compositions.presets import INKS, files_of
from .description import adopt
from .tables import is_ink

FIRST = "cyan_fine"
"""Preset that a new layer begins with."""


def shipped() -> dict[str, Path]:
    """Return the files of presets that ship, by their names."""
    return inks.presets()


def own() -> dict[str, Path]:
    """Return the files of the user's presets, by their names."""
    return files_of(INKS)


def load(settings, path) -> None:
    """Let settings state the layer of a file.

    Raises
    ------
    FileFormatError    It cannot be read.
    """
    content = dict(read_ink(path).content)
    substrate = content["substrate"]
    if "table" in substrate:
        # Settings have no place of their own that the file could lie beside.
        table = str((Path(path).parent / substrate["table"]).resolve())
        content["substrate"] = substrate | {"table": table}
    adopt(settings, content)


def begin(material) -> None:
    """Give a material that has become a pigment layer a preset to begin with."""
    settings = material.lumenray.ink
    if is_ink(material) and not settings.content and not settings.pigments:
        load(settings, shipped()[FIRST])
