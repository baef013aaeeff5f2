"""Gradients along an axis, around it and from a centre.

References
----------
Blender source, ``intern/cycles/kernel/svm/gradient.h``.
"""

import numpy as np


def draw_gradient(point, form: str) -> np.ndarray:
    """Return Blender's Gradient Texture.

    Parameters
    ----------
    point : sequence of three float32 arrays of one shape    Coordinates.
    form : str    LINEAR, QUADRATIC, EASING, DIAGONAL, RADIAL, SPHERICAL or QUADRATIC_SPHERE.

    Returns
    -------
    array    The points' shape and one channel, 0..1.
    """
    point = [np.asarray(each, np.float32) for each in point]
    return np.clip(_FORMS[form](*point), 0, 1)[..., None]


def _ease(x, y, z):
    share = np.clip(x, 0, 1)
    return share**2 * (3 - 2 * share)


def _ball(x, y, z):
    # A little less than 1, so that a point at distance 1 has exactly 0.
    return np.maximum(np.float32(0.999999) - np.sqrt(x * x + y * y + z * z), 0)


_FORMS = {
    "LINEAR": lambda x, y, z: x,
    "QUADRATIC": lambda x, y, z: np.maximum(x, 0) ** 2,
    "EASING": _ease,
    "DIAGONAL": lambda x, y, z: (x + y) * 0.5,
    "RADIAL": lambda x, y, z: np.arctan2(y, x) / np.float32(2 * np.pi) + 0.5,
    "SPHERICAL": _ball,
    "QUADRATIC_SPHERE": lambda x, y, z: _ball(x, y, z) ** 2,
}
