"""A job cut into chunks that owe nothing to each other: how many samples each has, and its seed.

What the chunks are follows from the job alone, never from who computes them or how fast: so the same chunks give the same
result, whoever computed which of them in whatever order.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

from ..accuracy.stopping import StopRule

SEEDS = 1 << 31
"""Seeds are numbers below it."""

OF_ONE_SIZE = 8
"""Chunks of the same number of samples; then they double: an end is met closely, and long jobs have few of them."""


@dataclass(frozen=True)
class Chunk:
    """A part of a job. ``samples``: of every value."""

    number: int
    seed: int
    samples: int


@dataclass(frozen=True)
class Grain:
    """How finely a kind of job may be cut.

    Parameters
    ----------
    least : int    Samples of a value in the first chunks: below, errors are not believed, or what is prepared takes longer.
    most : int    Of a value in the longest chunks.
    step : int    Samples come in multiples of it.
    """

    least: int
    most: int
    step: int = 1


def cut(rule: StopRule, seed: int, grain: Grain) -> Iterator[Chunk]:
    """Cut a job; without end where its rule names no number of samples.

    Parameters
    ----------
    rule : StopRule    Only its ``samples`` matter: all else is known no sooner than when chunks are done.
    seed : int    Of the job.
    grain : Grain
    """
    number, begun = 0, 0
    while rule.samples is None or begun < rule.samples:
        samples = min(grain.least << min(number // OF_ONE_SIZE, 40), grain.most)
        if rule.samples is not None:
            left = rule.samples - begun
            # What would be left is no chunk of its own.
            if left < samples + grain.least:
                samples = -(-left // grain.step) * grain.step
        yield Chunk(number, seed_of(seed, number), samples)
        number, begun = number + 1, begun + samples


def seed_of(seed: int, number: int) -> int:
    """Seed of a chunk: no two of a job have the same, and they tell nothing of each other."""
    return _mix((_mix(seed % SEEDS) + number) % SEEDS)


def _mix(value: int) -> int:
    """Permute the numbers below 2^31: xors with shifted selves and products with odd numbers can both be undone."""
    for factor in (0x45D9F3B, 0x119DE1F3):
        value ^= value >> 16
        value = value * factor % SEEDS
    return value ^ (value >> 15)


@dataclass
class Tally:
    """Takes chunks as they come and gives them in their order, each once.

    A second answer of a chunk, of a worker that was given up and came back, goes nowhere.
    """

    next: int = 0
    _early: dict[int, object] = field(default_factory=dict)

    def take(self, number: int, answer) -> None:
        """Take the answer of a chunk."""
        if number >= self.next:
            self._early.setdefault(number, answer)

    def has(self, number: int) -> bool:
        """Whether a chunk's answer has come."""
        return number < self.next or number in self._early

    def give(self) -> Iterator:
        """Answers that are next in order."""
        while self.next in self._early:
            answer = self._early.pop(self.next)
            self.next += 1
            yield answer
