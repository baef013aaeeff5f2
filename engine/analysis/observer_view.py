"""The camera that stands for an observer's eye: a fisheye of the hemisphere before it."""

import numpy as np

from ..errors import SceneError
from ..scene.camera import Camera, Projection

UPWARDS, AHEAD = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
"""Up in the world, and what is up in the picture of who looks straight up or down."""


def eye_camera(position, direction, size: int) -> Camera:
    """Camera at an eye.

    Parameters
    ----------
    position : (3,) array    [m]
    direction : (3,) array    Line of sight, any length above 0.
    size : int    Width and height of the picture. [pixel]

    Raises
    ------
    SceneError    There is no line of sight.
    """
    ahead = np.asarray(direction, dtype=np.float64)
    length = float(np.linalg.norm(ahead))
    if not (np.isfinite(length) and length > 0.0):
        raise SceneError("the observer needs a line of sight")
    backwards = -ahead / length
    is_level = np.linalg.norm(np.cross(UPWARDS, backwards)) > 1e-6
    right = np.cross(UPWARDS if is_level else AHEAD, backwards)
    right /= np.linalg.norm(right)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([right, np.cross(backwards, right), backwards], axis=1)
    frame[:3, 3] = position
    half_turn = float(np.pi)
    return Camera(frame, Projection.EQUIDISTANT, size, size, half_turn, half_turn, field=half_turn)
