"""Ray sets made by us, by tracing small models of lamps: `catalogue` says which."""

from pathlib import Path

FOLDER = Path(__file__).parent / "files"
"""Where they lie."""

PREFIX = "library:"
"""How a light names a file of ours, with the file's stem after it: its folder differs from machine to machine."""
