"""Presets of paints: those that ship, and those of the user, as files of compositions."""

from pathlib import Path

from ...engine.paint.reader import read_paint, settle_names
from ...libraries import paints
from ..compositions.presets import PAINTS, files_of
from .description import adopt
from .tables import is_paint

FIRST = ("silver_metallic", "violet_pearl")
"""Presets that a new paint may begin with, the first that there is."""


def shipped() -> dict[str, Path]:
    """Return the files of presets that ship, by their names."""
    return paints.presets()


def own() -> dict[str, Path]:
    """Return the files of the user's presets, by their names."""
    return files_of(PAINTS)


def load(settings, path, constituents: dict | None = None) -> None:
    """Let settings state the paint of a file.

    Parameters
    ----------
    constituents : dict or None    That it may name; None: those that ship.

    Raises
    ------
    FileFormatError    It cannot be read.
    """
    content = read_paint(path, constituents).content
    content = dict(content) if constituents is None else settle_names(content, constituents)
    substrate = content["substrate"]
    if "table" in substrate:
        # Settings have no place of their own that the file could lie beside.
        content["substrate"] = {"table": str((Path(path).parent / substrate["table"]).resolve())}
    adopt(settings, content)


def begin(material) -> None:
    """Give a material that has become a paint a preset to begin with."""
    settings = material.lumenray.paint
    if not is_paint(material) or settings.layers or settings.content:
        return
    known = shipped()
    first = next((name for name in FIRST if name in known), next(iter(known)))
    load(settings, known[first])
