"""Samples that are no numbers, counted on the device where they are left out of sums."""

import drjit as dr
import mitsuba as mi
import numpy as np


class LostSamples:
    """Counters of a launch, one for each row of its sums.

    Parameters
    ----------
    rows : int
    """

    def __init__(self, rows: int):
        self._counts = dr.zeros(mi.UInt32, rows)

    def keep(self, channels, row, active=True) -> list:
        """The channels of samples with 0 for what is no number; such samples are counted where they are active.

        ``row``: where each belongs.
        """
        is_lost = mi.Bool(False)
        for channel in channels:
            is_lost |= ~dr.isfinite(channel)
        # Where none is lost, next to nothing is done. Other modes would make the size a part of the kernel.
        dr.scatter_add(self._counts, mi.UInt32(1), row, is_lost & active, mode=dr.ReduceMode.Direct)
        return [dr.select(dr.isfinite(channel), channel, 0.0) for channel in channels]

    def counts(self) -> np.ndarray:
        """How many were lost by row, once the channels are evaluated. (rows,)"""
        return np.array(self._counts)
