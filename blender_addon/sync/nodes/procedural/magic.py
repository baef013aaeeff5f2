"""Colours of sines of sines.

References
----------
Blender source, ``intern/cycles/kernel/svm/magic.h``.
"""

import numpy as np

_TURN = np.float32(2 * np.pi)

_STEPS = (
    (1, "cos", -1, (1, -1, 1)),
    (0, "cos", 1, (1, -1, -1)),
    (2, "sin", 1, (-1, -1, -1)),
    (0, "cos", -1, (-1, 1, -1)),
    (1, "sin", -1, (-1, 1, 1)),
    (1, "cos", -1, (-1, 1, 1)),
    (0, "cos", 1, (1, 1, 1)),
    (2, "sin", 1, (1, 1, -1)),
    (0, "cos", -1, (-1, -1, 1)),
    (1, "sin", -1, (1, -1, 1)),
)
"""By depth: the number that is changed, the function, its sign, and the signs of the three numbers in it."""


def draw_magic(point, scale, depth: int, distortion) -> np.ndarray:
    """Return Blender's Magic Texture.

    Parameters
    ----------
    point : sequence of three float32 arrays of one shape    Coordinates without the node's scale.
    scale, distortion : numbers or arrays
    depth : int    Of the turbulence, 0 to 10.

    Returns
    -------
    array    The points' shape and three channels.
    """
    x, y, z = (np.fmod(np.asarray(each, np.float32), _TURN) for each in point)
    five = np.float32(5)
    numbers = [
        np.sin((x + y + z) * five * scale),
        np.cos((-x + y - z) * five * scale),
        -np.cos((-x - y + z) * five * scale),
    ]
    if depth > 0:
        numbers = [each * distortion for each in numbers]
    for changed, name, sign, signs in _STEPS[:depth]:
        inner = sum(each * part for each, part in zip(numbers, signs, strict=True))
        wave = np.cos(inner) if name == "cos" else np.sin(inner)
        numbers[changed] = sign * wave * distortion
    divisor = np.where(np.equal(distortion, 0), np.float32(1.0), 2 * np.asarray(distortion))
    return np.stack([np.float32(0.5) - each / divisor for each in numbers], axis=-1)
