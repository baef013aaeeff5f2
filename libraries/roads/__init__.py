"""Reduced luminance coefficients of standard road surfaces (CIE 144:2001), by the places of luminaire and driver."""

from pathlib import Path

FOLDER = Path(__file__).parent


def files() -> dict[str, Path]:
    """Return the tables that ship, by the surface's name such as ``C2``."""
    return {path.stem.upper(): path for path in sorted(FOLDER.glob("*.csv"))}


REMARKS = {
    "C2": "three numbers of this table are not as in its one source but as their neighbours ask for: "
    "tan γ 0.5 and 3.5 at β 2°, tan γ 11.5 at 0°",
}
"""What is told beside every result, by the surface's name; `README.md` has the numbers."""
