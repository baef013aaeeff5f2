"""Pictures of scattering files for panels."""

from ...imports import loaded_when_used
from ..file_assets.pictures import Pictures

with loaded_when_used():
    from ...engine.analysis import scattering_picture

DRAWN = {"cuts": "polar_cuts", "totals": "albedo_chart"}
"""Functions that draw, by kind of picture."""


def draw_scattering(reading, side: int, is_dark: bool, kind: str):
    """Draw a picture of a file, of the back where nothing is known of the front. Returns (h, w, 4), row 0 at the bottom."""
    names = reading.file.sides
    shown = "front" if any(name.startswith("front") for name in names) else "back"
    draw = getattr(scattering_picture, DRAWN[kind])
    return draw(reading.file, side=shown, size=(side, side), dark=is_dark)


pictures = Pictures("picture", draw_scattering)
