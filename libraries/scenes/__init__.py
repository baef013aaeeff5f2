"""The scenes that ship, and where they lie."""

from pathlib import Path

FOLDER = Path(__file__).parent

NAMES = ("office", "inverse_square", "closed_box", "materials")
"""Scenes that ship as ``.blend`` files."""


def scene_path(name: str) -> Path:
    """Return where the ``.blend`` file of a bundled scene lies.

    Raises
    ------
    KeyError    There is no bundled scene of that name.
    """
    if name not in NAMES:
        raise KeyError(name)
    return FOLDER / f"{name}.blend"
