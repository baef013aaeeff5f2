"""The sphere of a paint for panels, which follows its sliders: drawn on a thread of Blender's own process."""

from dataclasses import dataclass

from ...engine.errors import LumenrayError
from ...imports import loaded_when_used
from ..compositions.description import digest_of
from ..file_assets.pictures import Pictures

with loaded_when_used():
    import numpy as np

    from ...engine.paint import reader, sphere
    from . import description

LARGEST = 256
"""Side of the sphere. [pixel]"""


@dataclass(frozen=True, eq=False)
class Described:
    """A composition that is to be drawn. ``digest``: of the ``content``."""

    digest: str
    content: dict


def described(settings) -> Described:
    """Return what settings state."""
    content = description.describe(settings)
    return Described(digest_of(content), content)


def draw_sphere(reading: Described, side: int, is_dark: bool):
    """Draw a sphere of a paint, nothing where it cannot be computed, of which the panel tells why.

    Returns
    -------
    (side, side, 4) float32 array    Row 0 at the bottom.
    """
    try:
        return sphere.paint_sphere(reader.parse_paint(reading.content), side)
    except LumenrayError:
        return np.zeros((side, side, 4), np.float32)


pictures = Pictures("sphere", draw_sphere, is_latest_enough=True)
