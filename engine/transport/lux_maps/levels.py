"""How many samples lumels get in a pass, by the way in which light is sampled, and the pieces of work that these make."""

from dataclasses import dataclass

import numpy as np

LANES = 1 << 20
"""Samples of one launch: a fraction of a second each, so that a cancel is heard soon."""

KINDS = ("direct", "gathered", "guided", "mirrored")
"""Ways in which light is sampled: next-event to lights, rays, points on bright cells, next-event over plane mirrors."""

ALL_KINDS = DIRECT, GATHERED, GUIDED, MIRRORED = 0, 1, 2, 3

COSTS = (1.0, 2.5, 1.5, 1.1)
"""What a sample of each kind costs, relative to next-event; measured in rooms."""

SAMPLE_COST = COSTS[DIRECT] + COSTS[GATHERED]
"""Cost of what counts as one sample."""

FEW, MOST_UNITS = 3, 1 << 22
"""Level below which lumels are worked on apart from the others, where there are more samples than this."""

NO_SAMPLES = 255
"""Level of lumels that get nothing."""


SAMPLE_COUNTS = np.append(2.0 ** np.arange(NO_SAMPLES), 0.0)
"""By level."""


@dataclass(frozen=True)
class Levels:
    """Samples of every lumel in a pass: two to the power of the level, by `KINDS`. (4, n) uint8"""

    columns: np.ndarray

    @classmethod
    def even(cls, count: int, samples: int, kinds: tuple[int, ...]) -> "Levels":
        """As many of each of these kinds for all; a power of two."""
        columns = np.full((len(KINDS), count), NO_SAMPLES, dtype=np.uint8)
        columns[list(kinds)] = samples.bit_length() - 1
        return cls(columns)

    def total(self) -> float:
        """Sum of `samples`."""
        sums = [
            float(np.bincount(each, minlength=NO_SAMPLES + 1) @ SAMPLE_COUNTS)
            for each in self.columns
        ]
        return float(np.dot(sums, COSTS)) / SAMPLE_COST

    def lowered(self, steps: int) -> "Levels":
        """Samples halved so many times, but at least one."""
        lower = np.arange(NO_SAMPLES + 1, dtype=np.int64) - steps
        lower = np.maximum(lower, 0)
        lower[NO_SAMPLES] = NO_SAMPLES
        return Levels(lower.astype(np.uint8)[self.columns])

    def only(self, chosen: np.ndarray) -> "Levels":
        """None outside the chosen lumels. (n,) bool"""
        return Levels(np.where(chosen, self.columns, np.uint8(NO_SAMPLES)))

    def samples(self, part=slice(None)) -> np.ndarray:
        """Samples by lumel: as many pairs of one next-event and one gathering ray would cost as much. (n,)"""
        return (
            sum(c * count_of(each[part]) for c, each in zip(COSTS, self.columns, strict=True))
            / SAMPLE_COST
        )


def count_of(levels: np.ndarray) -> np.ndarray:
    """Samples by level."""
    return SAMPLE_COUNTS[levels]


@dataclass(frozen=True)
class Units:
    """Pieces of work of equal length: samples of a lumel that follow each other.

    Parameters
    ----------
    lumel : (u,) int array    Within the span.
    first : (u,) int array    Number of the first sample.
    samples : int    Of every unit.
    levels : (n,) uint8 array    Of the lumels of the span.
    """

    lumel: np.ndarray
    first: np.ndarray
    samples: int
    levels: np.ndarray

    def split(self, lanes: int = LANES):
        """Yield parts that fit a launch."""
        most = max(lanes // self.samples, 1)
        for start in range(0, len(self.lumel), most):
            part = slice(start, start + most)
            yield Units(self.lumel[part], self.first[part], self.samples, self.levels)

    def add(self, sums: np.ndarray, values: np.ndarray) -> None:
        """Add the means that sums (u, channels) make to the values (n, channels) of their lumels."""
        begins = np.flatnonzero(np.diff(self.lumel, prepend=-1))
        rows = self.lumel[begins]
        values[rows] += np.add.reduceat(sums, begins, axis=0) / count_of(self.levels[rows])[:, None]


def batches(levels: np.ndarray, known: np.ndarray):
    """Yield the work of all known lumels as `Units`; those of few samples apart where units would be too many."""
    chosen = known & (levels != NO_SAMPLES)
    if not chosen.any():
        return
    few = chosen & (levels < FEW)
    is_one = float(count_of(levels[chosen]).sum()) <= MOST_UNITS or few.all() or not few.any()
    for group in [chosen] if is_one else [few, chosen & ~few]:
        lumels = np.flatnonzero(group)
        lowest = int(levels[lumels].min())
        counts = 1 << (levels[lumels].astype(np.int64) - lowest)
        lumel = np.repeat(lumels, counts)
        number = np.arange(len(lumel)) - np.repeat(np.cumsum(counts) - counts, counts)
        yield Units(lumel, number << lowest, 1 << lowest, levels)
