"""Weights of rays by direction inside kernels: what `DirectionWeight.of` gives on the host."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...scene.ray_emission import BANDS, LARGEST_WEIGHT, LEAST_WEIGHT, DirectionWeight

NUMBERS = 14
"""Of a set: coefficients of the polynomial, the axis, where the middle band begins, and the mean."""


class RayWeight:
    """Weights of several sets.

    Parameters
    ----------
    weights : list of DirectionWeight
    """

    def __init__(self, weights: list[DirectionWeight]):
        numbers = [[*each.moments, *each.axis, each.middle, each.mean] for each in weights]
        self._numbers = upload(mi.Float, np.array(numbers))
        self._bands = upload(mi.Float, np.stack([each.bands for each in weights]))
        dr.eval(self._numbers, self._bands)

    def of_set(self, number, active):
        """Return what gives the weight of a direction in the axes of a set. ``number``: UInt32, of the set."""
        found = [
            dr.gather(mi.Float, self._numbers, number * NUMBERS + k, active) for k in range(NUMBERS)
        ]
        moments, axis, middle, mean = found[:9], mi.Vector3f(*found[9:12]), found[12], found[13]

        def weigh(direction):
            x, y, z = direction
            value = mi.Float(1.0)
            terms = (x * x, y * y, z * z, x * y, y * z, z * x, x, y, z)
            for coefficient, term in zip(moments, terms, strict=True):
                value = dr.fma(coefficient, term, value)
            off = dr.minimum(0.5 * dr.squared_norm(direction - axis), 2.0)
            place = BANDS * off / (off + middle * (2.0 - off))
            lower = dr.minimum(mi.UInt32(place), BANDS - 1)
            first = number * (BANDS + 1) + lower
            low, high = (dr.gather(mi.Float, self._bands, first + k, active) for k in range(2))
            value *= dr.lerp(low, high, place - mi.Float(lower))
            return dr.clip(value, LEAST_WEIGHT, LARGEST_WEIGHT) / mean

        return weigh
