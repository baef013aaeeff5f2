"""How large a luminous opening looks from a direction, and whether it can be one."""

import numpy as np

from ..errors import SceneError
from ..scene.distribution import SHAPES, Opening

AXES = "xyz"

FLAT = frozenset({"rectangle", "ellipse"})
"""Shapes without an extent along their axis."""

SMALLEST, LARGEST = 1e-5, 1e4
"""Sizes that are luminous openings. [m]"""


def check_opening(opening: Opening, owner: str) -> None:
    """See that an opening has the extents that its shape asks for. ``owner``: whose, for the message.

    Raises
    ------
    SceneError    It says what was found and expected.
    """
    if opening.shape not in SHAPES or opening.axis not in AXES:
        raise SceneError(
            f"{owner} has an opening of shape '{opening.shape}' about '{opening.axis}', expected one of"
            f" {', '.join(SHAPES)} about x, y or z"
        )
    if opening.shape == "point":
        return
    axis = AXES.index(opening.axis)
    for i, size in enumerate(opening.size):
        is_none = opening.shape in FLAT and i == axis
        if not (size == 0.0 if is_none else SMALLEST <= size <= LARGEST):
            expected = "0 m" if is_none else f"{SMALLEST:g} to {LARGEST:g} m"
            raise SceneError(
                f"{owner} has an opening ({opening.shape}) with a size of {size:g} m along {AXES[i]}, expected"
                f" {expected}"
            )


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
