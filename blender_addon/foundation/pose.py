"""World matrices of Blender as rigid frames of luminaires."""

from dataclasses import dataclass

import numpy as np

from ...engine.errors import SceneError


@dataclass(frozen=True, eq=False)
class Pose:
    """Where an object stands, without its scale.

    Parameters
    ----------
    frame : (4, 4) float64 array    Right-handed and orthogonal, with the object's x and z. [m]
    lengths : (float, float, float)    Of a Blender unit along the object's axes. [m]
    is_mirrored : bool    Whether the object is left-handed: its y is the frame's -y.
    is_scaled, is_sheared : bool    Whether more than placing is in the matrix.
    """

    frame: np.ndarray
    lengths: tuple[float, float, float]
    is_mirrored: bool
    is_scaled: bool
    is_sheared: bool


def pose_of(matrix, scale: float) -> Pose:
    """Take a world matrix apart.

    Parameters
    ----------
    matrix : (4, 4) array    In Blender units.
    scale : float    Metres per Blender unit.

    Raises
    ------
    SceneError    It has no size or is not finite, so it has no directions.
    """
    matrix = np.array(matrix, dtype=np.float64)
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if not np.isfinite(matrix).all() or lengths.min() < 1e-9:
        raise SceneError("the object's scale is zero or not finite")
    axes = matrix[:3, :3] / lengths
    frame = np.eye(4)
    frame[:3, 2] = axes[:, 2]
    x = axes[:, 0] - axes[:, 2] * (axes[:, 0] @ axes[:, 2])
    if np.linalg.norm(x) < 1e-6:
        raise SceneError("the object is sheared flat")
    frame[:3, 0] = x / np.linalg.norm(x)
    frame[:3, 1] = np.cross(frame[:3, 2], frame[:3, 0])
    frame[:3, 3] = matrix[:3, 3] * scale
    oblique = np.abs(axes.T @ axes - np.eye(3)).max()
    return Pose(
        frame=frame,
        lengths=tuple(float(length) for length in lengths * scale),
        is_mirrored=bool(frame[:3, 1] @ axes[:, 1] < 0.0),
        is_scaled=bool(np.abs(lengths - 1.0).max() > 1e-4),
        is_sheared=bool(oblique > 1e-4),
    )
