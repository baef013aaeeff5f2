"""Image textures as pure data."""

from dataclasses import dataclass, field

import numpy as np


def _identity() -> np.ndarray:
    return np.eye(3)


@dataclass(frozen=True, eq=False)
class ImageTexture:
    """A picture laid over a surface by one of its UV maps.

    Parameters
    ----------
    pixels : (height, width, 3) or (height, width, 1) float32 array
        Linear Rec. 709 values (three channels) or plain numbers (one channel). Row 0 is the *bottom* row (v = 0).
    uv_map : str    Name of the mesh's UV map; empty for the mesh's default map.
    transform : (3, 3) float64 array    Homogeneous matrix applied to (u, v, 1) before the look-up.
    interpolation : str    ``linear`` or ``closest``.
    extension : str    Outside 0..1: ``repeat``, ``extend`` (edge pixels go on) or ``mirror``.
    name : str    For reports.
    """

    pixels: np.ndarray
    uv_map: str = ""
    transform: np.ndarray = field(default_factory=_identity)
    interpolation: str = "linear"
    extension: str = "repeat"
    name: str = ""
