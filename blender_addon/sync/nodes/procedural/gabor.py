"""Waves of one frequency within soft spots, strewn at random.

References
----------
Blender source, ``intern/cycles/kernel/svm/gabor.h``.
A. Lagae et al., "Procedural Noise using Sparse Gabor Convolution", ACM TOG 28 (3), 2009.
V. Tavernier et al., "Making Gabor Noise Fast and Normalized", Eurographics 2019.
T. Tricard et al., "Procedural Phasor Noise", ACM TOG 38 (4), 2019.
"""

from itertools import product

import numpy as np

from .hashing import hash_floats

_SPOTS = 8
"""Spots in each cell."""

_LEAST_FREQUENCY = np.float32(0.001)

_SQUARES = {2: 0.25, 3: 0.25 / np.sqrt(2.0)}
"""Integral of the squared wave within one spot, by dimension."""


def draw_gabor(point, frequency, anisotropy, direction) -> dict[str, np.ndarray]:
    """Return Blender's Gabor Texture.

    Parameters
    ----------
    point : sequence of two or three float32 arrays of one shape    Coordinates times the node's scale.
    frequency, anisotropy : numbers or arrays
    direction : number or array, or sequence of three
        In two dimensions the angle of the waves [rad], in three a vector along which they run.

    Returns
    -------
    dict    Arrays of the points' shape by the names of the outputs: Value, Phase and Intensity.
    """
    size = len(point)
    isotropy = 1 - np.clip(anisotropy, 0, 1)
    frequency = np.maximum(frequency, _LEAST_FREQUENCY)
    point = [np.asarray(each, np.float32) for each in point]
    cell = [np.floor(each) for each in point]
    local = [each - floor for each, floor in zip(point, cell, strict=True)]
    if size == 3:
        direction = _unit(direction)
    real = imaginary = np.float32(0.0)
    steps = [np.float32(part) for part in (-1, 0, 1)]
    for step in product(steps, repeat=size):
        corner = [each + part for each, part in zip(cell, step, strict=True)]
        inside = [each - part for each, part in zip(local, step, strict=True)]
        for number in range(0, 3 * _SPOTS, 3):
            seeds = [(*corner, np.float32(number + part)) for part in range(3)]
            along = (_along_plane if size == 2 else _along_space)(direction, isotropy, seeds[0])
            away = [each - own for each, own in zip(inside, _centre(seeds[1]), strict=True)]
            squared = sum(each * each for each in away)
            height = _height(squared) * np.where(hash_floats(*seeds[2]) < 0.5, -1, 1)
            angle = 2 * np.pi * frequency * sum(a * b for a, b in zip(away, along, strict=True))
            real, imaginary = real + height * np.cos(angle), imaginary + height * np.sin(angle)
    largest = 6 * np.sqrt(_SPOTS * 0.5 * _SQUARES[size])
    return {
        "Value": imaginary / largest * 0.5 + 0.5,
        "Phase": (np.arctan2(imaginary, real) + np.pi) / (2 * np.pi),
        "Intensity": np.hypot(real, imaginary) / largest,
    }


def _height(squared):
    """Return how strong a wave is by the squared distance to the middle of its spot."""
    bell = np.exp(-np.pi * squared) * (0.5 + 0.5 * np.cos(np.pi * squared))
    return np.where(squared < 1, bell, 0)


def _unit(vector):
    length = np.sqrt(sum(each * each for each in vector))
    return [each / np.where(length > 0, length, 1) for each in vector]


def _centre(seed):
    if len(seed) == 3:
        x, y, number = seed
        return hash_floats(x, y, number), hash_floats(number, x, y)
    x, y, z, number = seed
    return (
        hash_floats(x, y, z, number),
        hash_floats(z, x, number, y),
        hash_floats(number, z, y, x),
    )


def _along_plane(angle, isotropy, seed):
    turned = angle + (hash_floats(*seed) - 0.5) * np.pi * isotropy
    return np.cos(turned), np.sin(turned)


def _along_space(direction, isotropy, seed):
    x, y, z = direction
    flat = np.hypot(x, y)
    azimuth = np.where(y < 0, -1, 1) * np.arccos(np.clip(x / np.where(flat > 0, flat, 1), -1, 1))
    inclination = np.arccos(np.clip(z, -1, 1))
    a, b, c, d = seed
    inclination = inclination + hash_floats(a, b, c, d) * np.pi * isotropy
    azimuth = azimuth + hash_floats(c, a, d, b) * np.pi * isotropy
    turned = (
        np.sin(inclination) * np.cos(azimuth),
        np.sin(inclination) * np.sin(azimuth),
        np.cos(inclination),
    )
    return [
        np.where(isotropy == 0, own, other) for own, other in zip(direction, turned, strict=True)
    ]
