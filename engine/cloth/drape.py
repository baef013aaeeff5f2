"""A cloth that hangs in folds before a window, for a look: light from a lamp in the room and from the sky behind it.

What lies behind is seen through openings. Folds cast no shadows on each other.
"""

from dataclasses import replace

import numpy as np

from ..paint.sphere import encode
from ..photometry.colour import XYZ_TO_REC709
from ..scattering.data.evaluation import evaluate, totals
from ..scattering.data.table import direct_share
from ..scattering.data.tristimulus import weights_of
from ..scene.material import Measured
from ..scene.scattering import ScatterTable

LAMP, SKY = np.array([-0.55, 0.45, 0.70]), np.array([0.30, 0.45, -0.84])
"""Towards the lamp and the middle of the sky; the eye is along z."""

OF_LAMP, OF_SKY, ROOM = 2.6, 1.6, 0.12
"""Irradiance of the lamp and of the sky across their rays [pi], and radiance of the room; a screen shows 1 as white. [-]"""

FOLDS, DEPTH = 2.5, 0.055
"""Folds of the width, and how deep they are below over half the side."""

PANES = 2
"""Panes of the window along both sides."""

BAR = 0.07
"""Width of its bars. [pane]"""

OF_BAR, OF_PANE = 0.02, 1.1
"""Radiance of them. [-]"""


def draw_drape(surface: Measured, side: int = 256, turn: float = 0.0) -> np.ndarray:
    """Draw a cloth whose sides are tables.

    Parameters
    ----------
    side : int    [pixel]
    turn : float    Of the cloth from the picture's right to its top; 0: the warp runs upwards. [rad]

    Returns
    -------
    (side, side, 4) float32 array    Display-encoded RGBA 0..1, the bottom row first.
    """
    line = (2.0 * np.arange(side) + 1.0) / side - 1.0
    x, y = (each.ravel() for each in np.meshgrid(line, line))
    frame = _frames(x, y, turn)
    eye, lamp, sky = (frame @ (each / np.linalg.norm(each)) for each in (np.eye(3)[2], LAMP, SKY))
    reflection = _coloured(surface.front_reflection)
    colour = OF_LAMP * evaluate(reflection, lamp, eye) * np.maximum(lamp[:, 2:], 0.0) * np.pi / 2.0
    colour += ROOM * totals(reflection, [0.0], [0.0])[0, 0]
    # Light that comes to the back is told of with z turned round.
    sky[:, 2] *= -1.0
    passed = evaluate(_coloured(surface.back_transmission), sky, eye)
    colour += OF_SKY * passed * np.maximum(sky[:, 2:], 0.0) * np.pi / 2.0
    seen = direct_share(surface.front_transmission, eye).mean(axis=1)
    colour += (seen * _behind(x, y))[:, None]
    picture = np.ones((side * side, 4), np.float32)
    picture[:, :3] = encode(colour)
    return picture.reshape(side, side, 4)


def _frames(x, y, turn: float) -> np.ndarray:
    """Rows to a fold's own axes, its weft, warp and normal. (n, 3, 3)"""
    wave = np.pi * FOLDS
    deep = DEPTH * (1.0 - 0.5 * y)
    # Folds lean a little from top to bottom.
    phase = wave * (x + 0.06 * np.sin(1.7 * y))
    along_x = deep * wave * np.cos(phase)
    along_y = deep * wave * np.cos(phase) * 0.06 * 1.7 * np.cos(1.7 * y) - 0.5 * DEPTH * np.sin(
        phase
    )
    normal = np.stack([-along_x, -along_y, np.ones_like(x)], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    first = np.stack([np.ones_like(x), np.zeros_like(x), along_x], axis=1)
    first -= (first * normal).sum(axis=1, keepdims=True) * normal
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normal, first)
    c, s = np.cos(turn), np.sin(turn)
    return np.stack([c * first + s * second, c * second - s * first, normal], axis=1)


def _coloured(table: ScatterTable) -> ScatterTable:
    """A table with linear Rec. 709 in place of its bands."""
    weights = weights_of(table.wavelengths) @ XYZ_TO_REC709.T
    return replace(
        table, wavelengths=np.arange(3.0) + 1.0, values=table.values @ weights, direct=None
    )


def _behind(x, y) -> np.ndarray:
    """Radiance of the window behind the cloth. [-]"""
    inside = [np.abs((0.5 * PANES * (each + 1.0)) % 1.0 - 0.5) < 0.5 - BAR for each in (x, y)]
    return np.where(inside[0] & inside[1], OF_PANE * (0.75 + 0.25 * y), OF_BAR)
