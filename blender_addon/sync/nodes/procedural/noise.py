"""Perlin's gradient noise and its octaves, in one to four dimensions.

References
----------
Blender source, ``intern/cycles/kernel/svm/noise.h``, ``fractal_noise.h`` and ``noisetex.h``.
K. Perlin, "Improving Noise", SIGGRAPH 2002.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from .hashing import hash_floats, hash_integers

MOST_DETAIL = 15.0
"""Octaves above the first at most."""

_PERIOD = np.float32(100000.0)

_FAR = np.float32(1000000.0)
"""From here on floats are so coarse that coordinates would all lie on whole numbers, where noise is 0."""

_SCALES = (0.25, 0.6616, 0.982, 0.8344)
"""What brings noise of one to four dimensions within -1 and 1."""

_LEAST_WEIGHT = 0.001


@dataclass(frozen=True)
class Octaves:
    """How octaves of noise add up; numbers or arrays that broadcast, meanings as in Blender's Noise Texture.

    Attributes
    ----------
    kind : str    FBM, MULTIFRACTAL, HYBRID_MULTIFRACTAL, RIDGED_MULTIFRACTAL or HETERO_TERRAIN.
    normalize : bool    Whether FBM is brought within 0 and 1.
    """

    detail: np.ndarray
    roughness: np.ndarray
    lacunarity: np.ndarray = 2.0
    offset: np.ndarray = 0.0
    gain: np.ndarray = 1.0
    kind: str = "FBM"
    normalize: bool = True


def signed_noise(point) -> np.ndarray:
    """Return gradient noise between -1 and 1.

    Parameters
    ----------
    point : sequence of one to four float32 arrays of one shape    Coordinates.
    """
    corrected = [
        np.fmod(each, _PERIOD) + np.float32(0.5) * (np.abs(each) >= _FAR) for each in point
    ]
    floors = [np.floor(each) for each in corrected]
    cells = [each.astype(np.int32) for each in floors]
    shares = [each - floor for each, floor in zip(corrected, floors, strict=True)]
    fades = [share**3 * (share * (share * 6 - 15) + 10) for share in shares]
    total = np.float32(0.0)
    for corner in product((0, 1), repeat=len(point)):
        bits = hash_integers(*(cell + step for cell, step in zip(cells, corner, strict=True)))
        away = [share - np.float32(step) for share, step in zip(shares, corner, strict=True)]
        weight = np.float32(1.0)
        for fade, step in zip(fades, corner, strict=True):
            weight = weight * (fade if step else 1 - fade)
        total = total + weight * _GRADIENTS[len(point)](bits, *away)
    return total * np.float32(_SCALES[len(point) - 1])


def _signed(value, bits, number):
    return np.where(bits & np.uint32(1 << number), -value, value)


def _along_one(bits, x):
    slope = ((bits & np.uint32(7)) + np.uint32(1)).astype(np.float32)
    return _signed(slope, bits, 3) * x


def _along_two(bits, x, y):
    is_first = (bits & np.uint32(7)) < 4
    near, far = np.where(is_first, x, y), np.where(is_first, y, x)
    return _signed(near, bits, 0) + _signed(2 * far, bits, 1)


def _along_three(bits, x, y, z):
    edge = bits & np.uint32(15)
    second = np.where(edge < 4, y, np.where((edge == 12) | (edge == 14), x, z))
    return _signed(np.where(edge < 8, x, y), bits, 0) + _signed(second, bits, 1)


def _along_four(bits, x, y, z, w):
    edge = bits & np.uint32(31)
    first, second = np.where(edge < 24, x, y), np.where(edge < 16, y, z)
    third = np.where(edge < 8, z, w)
    return _signed(first, bits, 0) + _signed(second, bits, 1) + _signed(third, bits, 2)


_GRADIENTS = {1: _along_one, 2: _along_two, 3: _along_three, 4: _along_four}


def fractal_noise(point, octaves: Octaves) -> np.ndarray:
    """Return octaves of noise, added up or multiplied.

    Parameters
    ----------
    point : sequence of one to four float32 arrays of one shape    Coordinates.
    octaves : Octaves
    """
    return _KINDS[octaves.kind](point, octaves)


def _count(octaves):
    """Return the number of whole octaves, place by place, the largest, and the share of the last one."""
    detail = np.asarray(octaves.detail, np.float32)
    whole = np.trunc(detail)
    return whole, int(whole.max()), detail - np.floor(detail)


def _scaled(point, factor):
    return [each * factor for each in point]


def _sum(point, octaves):
    whole, most, rest = _count(octaves)
    scale = amplitude = np.float32(1.0)
    total = reach = last_total = last_reach = np.float32(0.0)
    for number in range(most + (2 if np.any(rest) else 1)):
        more, farther = total + signed_noise(_scaled(point, scale)) * amplitude, reach + amplitude
        is_whole, is_last = number <= whole, number == whole + 1
        last_total = np.where(is_last, more, last_total)
        last_reach = np.where(is_last, farther, last_reach)
        total, reach = np.where(is_whole, more, total), np.where(is_whole, farther, reach)
        amplitude, scale = amplitude * octaves.roughness, scale * octaves.lacunarity
    if octaves.normalize:
        total = 0.5 * total / reach + 0.5
        last_total = 0.5 * last_total / np.where(rest > 0, last_reach, 1) + 0.5
    return np.where(rest > 0, total + rest * (last_total - total), total)


def _shares(octaves, first):
    """Yield by how much each octave counts, place by place: 1, at last the rest, then 0."""
    whole, most, rest = _count(octaves)
    for number in range(first, most + (2 if np.any(rest) else 1)):
        yield np.where(number <= whole, np.float32(1.0), np.where(number == whole + 1, rest, 0))


def _product(point, octaves):
    value = power = np.float32(1.0)
    for share in _shares(octaves, 0):
        value = value * (share * power * signed_noise(point) + 1)
        power, point = power * octaves.roughness, _scaled(point, octaves.lacunarity)
    return value


def _heterogeneous(point, octaves):
    power = octaves.roughness
    value = octaves.offset + signed_noise(point)
    for share in _shares(octaves, 1):
        point = _scaled(point, octaves.lacunarity)
        value = value + share * (signed_noise(point) + octaves.offset) * power * value
        power = power * octaves.roughness
    return value


def _hybrid(point, octaves):
    value, power, weight = np.float32(0.0), np.float32(1.0), np.float32(1.0)
    for share in _shares(octaves, 0):
        is_heard = weight > _LEAST_WEIGHT
        weight = np.minimum(weight, 1)
        signal = (signed_noise(point) + octaves.offset) * power
        value = value + np.where(is_heard, share * weight * signal, 0)
        weight = np.where(is_heard, weight * octaves.gain * signal, 0)
        power, point = power * octaves.roughness, _scaled(point, octaves.lacunarity)
    return value


def _ridged(point, octaves):
    # Blender leaves out what is left of the detail after whole octaves.
    whole, most, _ = _count(octaves)
    power = octaves.roughness
    signal = (octaves.offset - np.abs(signed_noise(point))) ** 2
    value = signal
    for number in range(1, most + 1):
        point = _scaled(point, octaves.lacunarity)
        weight = np.clip(signal * octaves.gain, 0, 1)
        signal = (octaves.offset - np.abs(signed_noise(point))) ** 2 * weight
        value = value + np.where(number <= whole, signal * power, 0)
        power = power * octaves.roughness
    return value


_KINDS = {
    "FBM": _sum,
    "MULTIFRACTAL": _product,
    "HYBRID_MULTIFRACTAL": _hybrid,
    "RIDGED_MULTIFRACTAL": _ridged,
    "HETERO_TERRAIN": _heterogeneous,
}


def draw_noise(point, octaves: Octaves, distortion, is_colour: bool) -> np.ndarray:
    """Return Blender's Noise Texture.

    Parameters
    ----------
    point : sequence of one to four float32 arrays of one shape    Coordinates times the node's scale.
    octaves : Octaves    Its detail within 0..15, its roughness not negative.
    distortion : number or array    How far noise moves the point.
    is_colour : bool    Whether the Color output is asked for.

    Returns
    -------
    array    The points' shape and one or three channels.
    """
    point = [np.asarray(each, np.float32) for each in point]
    size = len(point)
    if np.any(distortion):
        moves = [signed_noise(_moved(point, seed)) * distortion for seed in range(size)]
        point = [each + move for each, move in zip(point, moves, strict=True)]
    points = [point]
    if is_colour:
        points += [_moved(point, size), _moved(point, size + 1)]
    return np.stack([fractal_noise(each, octaves) for each in points], axis=-1)


def _moved(point, seed):
    """Return the point at another place, 100 to 200 away on each axis, that follows from a number."""
    keys = [(np.float32(seed), np.float32(axis)) for axis in range(len(point))]
    if len(point) == 1:
        keys = [(np.float32(seed),)]
    hundred = np.float32(100)
    moves = [hundred + hundred * hash_floats(*key) for key in keys]
    return [each + move for each, move in zip(point, moves, strict=True)]
