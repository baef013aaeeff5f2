"""Sums of samples of values that have as many of them as each needs."""

import numpy as np

from .estimate import Estimate
from .tails import tail_factor

HALVES = 2


class UnevenSums:
    """Sums of samples in double precision, apart by value and independent group.

    The first and the last half of the groups have numbers of samples of their own, alike in all groups of a half: where each
    half gets samples by what the other one tells, no mean depends on what it was itself (theory 10.9). All groups count
    alike, so the mean is that of both halves' means.

    Parameters
    ----------
    groups : int    Independent ones, even.
    count, channels : int    Values, and numbers of each.

    Attributes
    ----------
    counts : (2, count) array    Samples in each group of a half.
    lost : (count,) array    Samples of all groups that were no numbers.
    """

    def __init__(self, groups: int, count: int, channels: int):
        self.counts = np.zeros((HALVES, count), dtype=np.int64)
        self.lost = np.zeros(count, dtype=np.int64)
        self._each = groups // HALVES
        self._sums = np.zeros((HALVES, count, self._each, channels))
        # Sum and largest of the squares of a half's samples.
        self._tails = np.zeros((2, HALVES, count))

    @property
    def groups(self) -> int:
        """Independent groups."""
        return HALVES * self._each

    @property
    def samples(self) -> float:
        """Samples of a value in a group, on the mean."""
        return float(self.counts.mean()) if self.counts.size else 0.0

    def add(self, half, number, samples, sums, tails, lost) -> None:
        """Add samples to all groups of a half of some values.

        Parameters
        ----------
        half, number : (m,) int array    Which, in ascending order; the same may stand in several rows.
        samples : int    Of each row in a group.
        sums : (m, groups / 2, channels) array
        tails : (2, m) array    Sum and largest of the squares of the samples, over the groups.
        lost : (m,) int array    How many were no numbers, over the groups.
        """
        row = half * self.counts.shape[1] + number
        first = np.flatnonzero(np.diff(row, prepend=-1))
        at = half[first], number[first]
        self.counts[at] += samples * np.diff(first, append=len(row))
        self._sums[at] += np.add.reduceat(sums, first, axis=0)
        self._tails[0][at] += np.add.reduceat(tails[0], first)
        self._tails[1][at] = np.maximum(self._tails[1][at], np.maximum.reduceat(tails[1], first))
        if lost.any():
            np.add.at(self.lost, number, lost)

    def means(self) -> np.ndarray:
        """Means by group; 0 where there are no samples. (groups, count, channels)"""
        made = self._sums / np.maximum(self.counts, 1)[:, :, None, None]
        return made.transpose(0, 2, 1, 3).reshape(self.groups, *made.shape[1::2])

    def variances(self, channel: int = 0) -> np.ndarray:
        """Variance of a single sample, as far as groups of a half tell, by half. (2, count)"""
        if self._each < 2:
            return np.zeros(self.counts.shape)
        means = self._sums[..., channel] / np.maximum(self.counts, 1)[:, :, None]
        return means.var(axis=2, ddof=1) * self.counts

    def tails(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Sum and largest of the squares of what samples are of the mean, and the number of samples. (count,) each"""
        weights = 1.0 / np.maximum(self.groups * self.counts, 1).astype(np.float64) ** 2
        squares, largest = self._tails * weights
        return squares.sum(axis=0), largest.max(axis=0), self._each * self.counts.sum(axis=0)

    def lost_shares(self) -> np.ndarray:
        """Share of its samples that each value has lost. (count,) [-]"""
        return self.lost / np.maximum(self._each * self.counts.sum(axis=0), 1)

    def estimate(self) -> Estimate:
        """Means with their standard errors; those that stem from few samples are the larger, see `tails`."""
        return estimate_with_tails(self.means(), round(self.samples * self.groups), *self.tails())


def estimate_with_tails(means, samples: int, squares, largest, parts) -> Estimate:
    """As `Estimate.from_groups`, with errors that are the larger where they stem from few samples.

    Parameters
    ----------
    means : (groups, n, channels) array
    squares, largest, parts : (n,) array    As of `UnevenSums.tails`.
    """
    made = Estimate.from_groups(means, samples)
    factor = tail_factor(squares, largest, parts)
    events = np.divide(squares, largest, out=np.full(len(squares), np.inf), where=largest > 0.0)
    return Estimate(made.mean, made.standard_error * factor[:, None], samples, events[:, None])
