"""The hanging cloth of panels, drawn of its table on a thread of Blender's own process."""

from dataclasses import dataclass

from ...imports import loaded_when_used
from ..file_assets.pictures import Pictures

with loaded_when_used():
    from ...engine.cloth import drape, surface

LARGEST = 256
"""Side of the picture. [pixel]"""


@dataclass(frozen=True, eq=False)
class Turned:
    """A cloth on its way to be drawn. ``digest``: of all that the picture shows."""

    digest: str
    woven: "surface.WovenSurface"
    turn: float


def turned(woven: "surface.WovenSurface", settings) -> Turned:
    """Return what is drawn of a computed cloth."""
    return Turned(f"{woven.key} {settings.turn:.4f}", woven, settings.turn)


def draw_drape(reading: Turned, side: int, is_dark: bool):
    """Draw a cloth that hangs before a window. (side, side, 4) float32 array, row 0 at the bottom"""
    return drape.draw_drape(reading.woven.surface, side, reading.turn)


pictures = Pictures("hanging cloth", draw_drape)
