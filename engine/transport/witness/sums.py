"""Sums that many rays add to at once, the same in whatever order they come.

Rays of all threads take turns as chance has it, and sums of floating-point numbers depend on the order. So amounts are
counted in whole quanta. What is smaller than one counts as one with the probability of its share, so that nothing is lost.
"""

import math

import drjit as dr
import mitsuba as mi
import numpy as np

FINENESS = 48
"""Quanta in what is about the whole, as a power of two: ten thousand times as much still fits."""


class Sums:
    """Sums on the device, all of them 0 at first.

    Parameters
    ----------
    size : int
    whole : float    About all that is added, in whatever unit; its power of two decides the quantum.

    Attributes
    ----------
    counts : Int64    In quanta, to be evaluated with what is added to them.
    """

    def __init__(self, size: int, whole: float):
        self._quantum = 2.0 ** (math.floor(math.log2(min(max(whole, 1e-20), 1e30))) - FINENESS)
        self._scale = dr.opaque(mi.Float, 1.0 / self._quantum)
        self.counts = dr.zeros(dr.int64_array_t(mi.Float), size)

    def add(self, amount, index, active, chance=0.5) -> None:
        """Add amounts, see `quanta`."""
        self.add_quanta(self.quanta(amount, chance), index, active)

    def quanta(self, amount, chance=0.5):
        """Amounts as whole quanta, Int64; what is no finite number is none.

        Parameters
        ----------
        chance : Float    Random, in [0, 1), by which quanta are filled up.
        """
        whole = dr.floor(dr.select(dr.isfinite(amount), amount, 0.0) * self._scale + chance)
        return dr.int64_array_t(mi.Float)(whole)

    def add_quanta(self, count, index, active) -> None:
        """Add what `quanta` gave."""
        dr.scatter_reduce(dr.ReduceOp.Add, self.counts, count, index, active)

    def values(self) -> np.ndarray:
        """All sums, as double precision. (size,)"""
        return np.array(self.counts).astype(np.float64) * self._quantum
