"""Another number at every point.

References
----------
Blender source, ``intern/cycles/kernel/svm/white_noise.h``.
"""

import numpy as np

from .hashing import hash_floats, hash_to_colour


def draw_white_noise(point, is_colour: bool) -> np.ndarray:
    """Return Blender's White Noise Texture.

    Parameters
    ----------
    point : sequence of one to four float32 arrays of one shape    Coordinates; all their bits count.
    is_colour : bool    Whether the Color output is asked for.

    Returns
    -------
    array    The points' shape and one or three channels, 0..1.
    """
    if is_colour:
        return hash_to_colour(*point)
    return hash_floats(*point)[..., None]
