"""Reduced luminance coefficients of standard road surfaces (CIE 144:2001), by the places of luminaire and driver."""

from pathlib import Path

FOLDER = Path(__file__).parent


def files() -> dict[str, Path]:
    """Return the tables that ship, by the surface's name such as ``C2``."""
    return {path.stem.upper(): path for path in sorted(FOLDER.glob("*.csv"))}
