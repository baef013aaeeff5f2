"""Pictures of scattering files for panels."""

from ...engine.analysis.scattering_picture import albedo_chart, polar_cuts
from ..file_assets.pictures import Pictures

DRAWN = {"cuts": polar_cuts, "totals": albedo_chart}
"""What draws each kind of picture."""


def draw_scattering(reading, side: int, is_dark: bool, kind: str):
    """Draw a picture of a file, of the back where nothing is known of the front. Returns (h, w, 4), row 0 at the bottom."""
    names = reading.file.sides
    shown = "front" if any(name.startswith("front") for name in names) else "back"
    return DRAWN[kind](reading.file, side=shown, size=(side, side), dark=is_dark)


pictures = Pictures("picture", draw_scattering)
