"""Values on the device and back, and random places there."""

import numpy as np

LANES = 1 << 18

SIGNIFICANCE = 1e-3 / 100
"""All chi-square tests of a file together fail a right engine with a probability below one in a thousand."""


def upload(values):
    import mitsuba as mi

    from lumenray.engine.arrays import upload

    return upload(mi.Float, values)


def vectors(values):
    """Vectors on the device. (n, 3)"""
    import mitsuba as mi

    return mi.Vector3f(*(upload(column) for column in np.transpose(values)))


def from_device(v):
    return np.array(v, dtype=np.float64).T


def number(value):
    """Whole number that kernels take as data."""
    import drjit as dr
    import mitsuba as mi

    return dr.opaque(mi.UInt32, value)


def random_points(seed, lanes=LANES):
    return next(streams(seed, lanes))


def streams(seed, lanes=LANES):
    """Independent points in the unit square, one after the other; those of neighbouring seeds are not."""
    import mitsuba as mi

    stream = mi.PCG32(size=lanes, initstate=seed)
    while True:
        yield mi.Point2f(stream.next_float32(), stream.next_float32())
