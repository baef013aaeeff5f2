"""Bands and rings, distorted by noise.

References
----------
Blender source, ``intern/cycles/kernel/svm/wave.h``.
"""

import numpy as np

from .noise import Octaves, fractal_noise

_AXES = {"X": 0, "Y": 1, "Z": 2}


def draw_wave(
    point, form: str, direction: str, profile: str, phase, distortion, noise_scale, octaves: Octaves
):
    """Return Blender's Wave Texture.

    Parameters
    ----------
    point : sequence of three float32 arrays of one shape    Coordinates times the node's scale.
    form : str    BANDS or RINGS.
    direction : str    X, Y or Z; DIAGONAL of bands, SPHERICAL of rings.
    profile : str    SIN, SAW or TRI.
    phase : number or array    Added to the angle. [rad]
    distortion, noise_scale : numbers or arrays    How far noise moves the angle, and the noise's own scale.
    octaves : Octaves    Of that noise.

    Returns
    -------
    array    The points' shape and one channel, 0..1.
    """
    # Whole numbers would lie on the edge between two waves.
    point = [
        (np.asarray(each, np.float32) + np.float32(1e-6)) * np.float32(0.999999) for each in point
    ]
    measure = _along_bands if form == "BANDS" else _across_rings
    angle = measure(point, direction) + phase
    if np.any(distortion):
        noise = fractal_noise([each * noise_scale for each in point], octaves)
        angle = angle + distortion * (2 * noise - 1)
    return _PROFILES[profile](angle)[..., None]


def _along_bands(point, direction):
    if direction == "DIAGONAL":
        return (point[0] + point[1] + point[2]) * np.float32(10)
    return point[_AXES[direction]] * np.float32(20)


def _across_rings(point, direction):
    axes = [each for axis, each in enumerate(point) if axis != _AXES.get(direction)]
    return np.sqrt(sum(each * each for each in axes)) * np.float32(20)


def _sine(angle):
    return 0.5 + 0.5 * np.sin(angle - np.float32(np.pi / 2))


def _saw(angle):
    turns = angle / np.float32(2 * np.pi)
    return turns - np.floor(turns)


def _triangle(angle):
    turns = angle / np.float32(2 * np.pi)
    return np.abs(turns - np.floor(turns + np.float32(0.5))) * 2


_PROFILES = {"SIN": _sine, "SAW": _saw, "TRI": _triangle}
