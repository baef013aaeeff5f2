"""Sample points: Owen-scrambled Sobol pairs for the first dimensions of a path, a random stream for the rest.

A *pair* is the two-dimensional (0, 2)-sequence of Sobol with nested uniform scrambling. Different pairs of one path
use independent scrambles and an independent shuffle of the index (padding), so any number of pairs can be drawn.

References
----------
B. Burley: Practical Hash-based Owen Scrambling, JCGT 9(4), 2020. The second dimension's generator matrix is Pascal's
triangle modulo 2, which factors into five shifts.
"""

import drjit as dr
import mitsuba as mi


def hash_words(a, b):
    """Mix two 32-bit words into one (PCG-style multiply and xorshift)."""
    x = (a ^ 0x9E3779B9) + b * mi.UInt32(0x85EBCA6B)
    x ^= x >> 16
    x *= mi.UInt32(0x7FEB352D)
    x ^= x >> 15
    x *= mi.UInt32(0x846CA68B)
    x ^= x >> 16
    return x


def _permute(x, seed):
    """Laine-Karras permutation: a nested uniform scramble of bit-reversed numbers."""
    x += seed
    x ^= x * mi.UInt32(0x6C50B47C)
    x ^= x * mi.UInt32(0xB82F1E52)
    x ^= x * mi.UInt32(0xC7AFE638)
    x ^= x * mi.UInt32(0x8D22F6E6)
    return x


def _pascal(x):
    """Multiply the bit vector by Pascal's triangle modulo 2."""
    x ^= (x >> 16) & 0x0000FFFF
    x ^= (x >> 8) & 0x00FF00FF
    x ^= (x >> 4) & 0x0F0F0F0F
    x ^= (x >> 2) & 0x33333333
    x ^= (x >> 1) & 0x55555555
    return x


def _to_unit(x):
    """Map 32 bits to [0, 1) without ever giving 1."""
    return mi.Float(x >> 8) * (1.0 / 16777216.0)


def sobol_pair(index, seed, pair: int):
    """Point ``index`` of the scrambled sequence number ``pair``.

    Parameters
    ----------
    index : UInt32    Position in the sequence.
    seed : UInt32    One per independent sequence (pixel, half).
    pair : int    Which pair of dimensions.

    Returns
    -------
    Point2f    In [0, 1)^2.
    """
    seed = hash_words(mi.UInt32(seed), mi.UInt32(2 * pair + 1))
    shuffled = dr.brev(_permute(dr.brev(mi.UInt32(index)), seed))
    first = dr.brev(_permute(mi.UInt32(shuffled), hash_words(seed, mi.UInt32(0x51633E2D))))
    second = dr.brev(
        _permute(_pascal(mi.UInt32(shuffled)), hash_words(seed, mi.UInt32(0x68BC21EB)))
    )
    return mi.Point2f(_to_unit(first), _to_unit(second))


def launch_stream(index, salt: int, seed: int, purpose: int):
    """Return a generator for every lane of a launch; other salts, seeds and purposes give independent ones."""
    salt, seed = dr.opaque(mi.UInt32, salt), dr.opaque(mi.UInt32, seed & 0xFFFFFFFF)
    return random_stream(index, hash_words(hash_words(salt, seed), mi.UInt32(purpose)))


def random_stream(index, seed):
    """Return a PCG32 generator of its own for every lane."""
    return mi.PCG32(
        initstate=mi.UInt64(hash_words(index, seed)), initseq=mi.UInt64(hash_words(seed, index))
    )
