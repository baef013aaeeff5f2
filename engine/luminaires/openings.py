"""How large a luminous opening looks from a direction."""

import numpy as np

from ..scene.distribution import Opening

AXES = "xyz"


def projected_area(opening: Opening, direction) -> np.ndarray:
    """Area that an opening shows towards directions, which its average luminance is the intensity over.

    The opening is convex, so this is half the sum of its faces, each times the cosine to the direction. Flat openings show
    both sides.

    Parameters
    ----------
    opening : Opening
    direction : (..., 3) array    In the luminaire's axes, of any length but zero.

    Returns
    -------
    (...) float64 array    [m2] 0 for a point.
    """
    d = np.asarray(direction, dtype=np.float64)
    d = np.abs(d) / np.linalg.norm(d, axis=-1, keepdims=True)
    size = np.asarray(opening.size, dtype=np.float64)
    axis = AXES.index(opening.axis)
    across, over = (i for i in range(3) if i != axis)
    faces = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])
    match opening.shape:
        case "point":
            return np.zeros(d.shape[:-1])
        case "rectangle":
            return faces[axis] * d[..., axis]
        case "ellipse":
            return 0.25 * np.pi * faces[axis] * d[..., axis]
        case "box":
            return d @ faces
        case "ellipsoid":
            return 0.25 * np.pi * np.linalg.norm(d * faces, axis=-1)
        case "cylinder":
            # The mantle shows its length times the width of the elliptic section at right angles to the direction.
            width = np.hypot(size[over] * d[..., across], size[across] * d[..., over])
            return 0.25 * np.pi * faces[axis] * d[..., axis] + size[axis] * width
    raise ValueError(f"unknown shape of an opening: {opening.shape}")
