"""Where the checkout lies, and the files from the wild that somebody may have put beside it."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WILD = ROOT.parent / "shared" / "data"
