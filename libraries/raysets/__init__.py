"""Ray sets made by us, by tracing small models of lamps: `models` says which, `make` writes the files."""

from pathlib import Path

FOLDER = Path(__file__).parent / "files"
"""Where they lie."""
