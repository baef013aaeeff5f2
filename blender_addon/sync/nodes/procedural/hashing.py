"""Numbers that look random but follow from whole numbers or from the bits of floats alone.

Every function takes arrays that broadcast. Whole numbers wrap at 32 bits on purpose.

References
----------
Blender source, ``intern/cycles/util/hash.h``.
R. J. Jenkins, "lookup3", 2006.
M. Jarzynski and M. Olano, "Hash Functions for GPU Rendering", JCGT 9 (3), 2020.
"""

import numpy as np

_START = 0xDEADBEEF

_MIXING = ((0, 2, 4, 1), (1, 0, 6, 2), (2, 1, 8, 0), (0, 2, 16, 1), (1, 0, 19, 2), (2, 1, 4, 0))
"""Steps between two groups of keys: changed word, word taken away, its rotation, word added to that."""

_ENDING = ((2, 1, 14), (0, 2, 11), (1, 0, 25), (2, 1, 16), (0, 2, 4), (1, 0, 14), (2, 1, 24))
"""Last steps: changed word, the other word, its rotation."""

_FACTOR, _ADDEND = 1664525, 1013904223

_LARGEST = np.float32(2147483647.0)

_CROSSED = {
    2: ((0, 1, None), (1, 0, None)),
    3: ((0, 1, 2), (1, 2, 0), (2, 0, 1)),
    4: ((0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)),
}
"""By dimension: the number that is changed and the two whose product is added to it."""


def hash_integers(*keys) -> np.ndarray:
    """Return 32 bits that follow from one to four whole numbers.

    Parameters
    ----------
    keys : arrays of integers    Their lowest 32 bits count.

    Returns
    -------
    array of uint32    In the common shape.
    """
    keys = [np.asarray(key).astype(np.uint32) for key in keys]
    shape = np.broadcast_shapes(*(key.shape for key in keys))
    start = np.uint32((_START + 4 * len(keys) + 13) & 0xFFFFFFFF)
    words = [np.full(shape, start) for _ in range(3)]
    with np.errstate(over="ignore"):
        for number, key in enumerate(keys[:3]):
            words[number] += key
        if len(keys) == 4:
            for changed, other, turn, third in _MIXING:
                words[changed] -= words[other]
                words[changed] ^= _rotate(words[other], turn)
                words[other] += words[third]
            words[0] += keys[3]
        for changed, other, turn in _ENDING:
            words[changed] ^= words[other]
            words[changed] -= _rotate(words[other], turn)
    return words[2]


def _rotate(word, turn):
    return (word << np.uint32(turn)) | (word >> np.uint32(32 - turn))


def hash_floats(*keys) -> np.ndarray:
    """Return numbers 0..1 that follow from the bits of one to four floats.

    Parameters
    ----------
    keys : arrays of float32

    Returns
    -------
    array of float32    In the common shape.
    """
    bits = [np.asarray(key, np.float32).view(np.uint32) for key in keys]
    return hash_integers(*bits).astype(np.float32) * np.float32(2.0**-32)


def hash_to_colour(*keys) -> np.ndarray:
    """Return three numbers 0..1 that follow from the bits of one to four floats, as a last axis.

    Parameters
    ----------
    keys : arrays of float32
    """
    if len(keys) == 4:
        x, y, z, w = keys
        parts = [hash_floats(*each) for each in (keys, (z, x, w, y), (w, z, y, x))]
    else:
        parts = [hash_floats(*keys), *(hash_floats(*keys, np.float32(seed)) for seed in (1, 2))]
    return np.stack(parts, axis=-1)


def hash_to_place(*keys) -> list[np.ndarray]:
    """Return as many numbers 0..1 as keys, that follow from the keys' bits.

    Parameters
    ----------
    keys : one to four arrays of float32
    """
    if len(keys) == 4:
        return [hash_floats(*keys[4 - turn :], *keys[: 4 - turn]) for turn in range(4)]
    seeds = [(), *((np.float32(seed),) for seed in range(1, len(keys)))]
    return [hash_floats(*keys, *seed) for seed in seeds]


def hash_cell(cell) -> list[np.ndarray]:
    """Return as many numbers 0..1 for a cell of a grid as it has coordinates.

    Parameters
    ----------
    cell : sequence of two to four arrays of integers

    Returns
    -------
    list of float32 arrays
    """
    numbers = [np.asarray(each).astype(np.int32) * np.int32(_FACTOR) for each in cell]
    numbers = [each + np.int32(_ADDEND) for each in numbers]
    _cross(numbers)
    numbers = [each ^ (each >> np.int32(16)) for each in numbers]
    _cross(numbers)
    return [(each & np.int32(0x7FFFFFFF)).astype(np.float32) / _LARGEST for each in numbers]


def _cross(numbers):
    for changed, first, second in _CROSSED[len(numbers)]:
        factor = np.int32(_FACTOR) if second is None else numbers[second]
        numbers[changed] = numbers[changed] + numbers[first] * factor
