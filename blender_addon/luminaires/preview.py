"""Polar diagrams of photometric files for panels."""

from ...engine.analysis.polar_diagram import diagram_pixels
from ..file_assets.pictures import Pictures


def draw_diagram(reading, side: int, is_dark: bool):
    """Draw the polar diagram of a file. Returns (h, w, 4), row 0 at the bottom."""
    return diagram_pixels(reading.file, size=(side, side), dark=is_dark)


pictures = Pictures("diagram", draw_diagram)
