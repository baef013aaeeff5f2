"""Sums of samples by kind, independent group and receiver, and which kind another sample serves best."""

import numpy as np

from ...accuracy.estimate import Estimate
from ...accuracy.uneven_sums import estimate_with_tails

SPREAD = 64
"""Least samples of a kind: those of the one that has most over this. Light that few samples have missed may still be
there."""

ALIKE = 4.0
"""Kinds whose samples are worth as much as those of the best, but for such a factor, are doubled with it: a doubling lowers
what is gained by a sample to a quarter. [-]"""


class KindSums:
    """What samples of each kind add up to; the light is the sum of the kinds' means.

    Parameters
    ----------
    costs : dict    Cost of a sample by kind.
    groups : int    Independent ones.
    count, channels : int    Receivers, and numbers of each.
    bright : int    Channel of the illuminance.

    Attributes
    ----------
    counts : dict    Samples of every receiver in a group, by kind.
    lost : dict    Samples that were no numbers, by kind: (count,).
    """

    def __init__(self, costs: dict[int, float], groups: int, count: int, channels: int, bright):
        self.costs, self.groups, self._bright = costs, groups, bright
        self.counts = dict.fromkeys(costs, 0)
        self.lost = {kind: np.zeros(count, dtype=np.int64) for kind in costs}
        self._sums = {kind: np.zeros((groups, count, channels)) for kind in costs}
        self._tails = {kind: np.zeros((2, count)) for kind in costs}

    @property
    def samples(self) -> float:
        """Of a receiver over all groups; one of each kind counts as one."""
        return self.samples_of(self.counts)

    def samples_of(self, counts: dict[int, int]) -> float:
        """As `samples`, of other counts by kind."""
        spent = sum(cost * counts.get(kind, 0) for kind, cost in self.costs.items())
        return self.groups * spent / sum(self.costs.values())

    def add(self, kind: int, group: int, part: slice, sums, tails, lost) -> None:
        """Add samples of some receivers; arrays as of `illuminance.Meter.sums`."""
        self._sums[kind][group, part] += sums
        own = self._tails[kind]
        own[0, part] += tails[0]
        own[1, part] = np.maximum(own[1, part], tails[1])
        self.lost[kind][part] += lost

    def extend(self, added: dict[int, int]) -> None:
        """Take note that all receivers have got samples."""
        for kind, more in added.items():
            self.counts[kind] += more

    def means(self, kind: int) -> np.ndarray:
        """Means of a kind by group. (groups, n, channels)"""
        return self._sums[kind] / max(self.counts[kind], 1)

    def estimate(self) -> Estimate:
        """Light with its standard errors; those that stem from few samples are the larger, see `tails`."""
        whole = sum(self.means(kind) for kind in self._sums)
        squares, largest, parts = 0.0, 0.0, 0
        for kind, tails in self._tails.items():
            weight = 1.0 / max(self.groups * self.counts[kind], 1) ** 2
            squares = squares + weight * tails[0]
            largest = np.maximum(largest, weight * tails[1])
            parts += self.groups * self.counts[kind]
        return estimate_with_tails(whole, round(self.samples), squares, largest, parts)

    def lost_shares(self) -> np.ndarray:
        """Share of its samples that each receiver has lost of the kind of which it lost most. (n,) [-]"""
        shares = [
            lost / max(self.groups * self.counts[kind], 1) for kind, lost in self.lost.items()
        ]
        return np.max(shares, axis=0)

    def choose(self, scale: np.ndarray) -> list[int]:
        """Kinds whose samples are to be doubled.

        ``scale``: what errors of receivers count relative to. (n,) [lx]
        """
        worth = {}
        most = max(self.counts.values())
        for kind, cost in self.costs.items():
            means = self.means(kind)[..., self._bright]
            square = float((means.var(axis=0, ddof=1) / scale**2).mean())
            is_starving = self.counts[kind] * SPREAD < most
            worth[kind] = np.inf if is_starving else square / (cost * self.counts[kind])
        best = max(worth.values())
        return [kind for kind, each in worth.items() if each * ALIKE >= best]
