"""Compositions of dense pigment layers, and their schema; users' files stand beside."""

from pathlib import Path

FOLDER = Path(__file__).parent

SCHEMA = FOLDER / "schema.json"
"""JSON schema of a composition."""


def presets() -> dict[str, Path]:
    """Return the files of the compositions that ship, by the names of these files, ascending."""
    return {path.stem: path for path in sorted((FOLDER / "presets").glob("*.json"))}
