"""Polar diagrams of photometric files for panels."""

from ...imports import loaded_when_used
from ..file_assets.pictures import Pictures

with loaded_when_used():
    from ...engine.analysis import polar_diagram


def draw_diagram(reading, side: int, is_dark: bool):
    """Draw the polar diagram of a file. Returns (h, w, 4), row 0 at the bottom."""
    return polar_diagram.diagram_pixels(reading.file, size=(side, side), dark=is_dark)


pictures = Pictures("diagram", draw_diagram)
