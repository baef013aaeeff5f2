"""Compositions of paints, the constituents that they are made of, and the schema of both; users' files stand beside."""

from pathlib import Path

FOLDER = Path(__file__).parent

SCHEMA = FOLDER / "schema.json"
"""JSON schema of a composition."""

CONSTITUENTS = FOLDER / "constituents.json"
"""Indices, binders, flakes and pigments that compositions name."""


def presets() -> dict[str, Path]:
    """Return the files of the compositions that ship, by the names of these files, ascending."""
    return {path.stem: path for path in sorted((FOLDER / "presets").glob("*.json"))}
