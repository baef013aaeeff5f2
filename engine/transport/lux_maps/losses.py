"""Samples of a lux map job that were no numbers, and so were left out."""

from dataclasses import dataclass, field

import numpy as np

from .levels import Levels

WAYS = LUMELS, CELLS, TRACED = 0, 1, 2
"""Where samples are made: at lumels, at cells, and along paths from the lights."""

NAMES = ("samples of the maps", "samples of cells", "light paths")
"""What people call them."""


@dataclass
class Losses:
    """What was lost.

    Parameters
    ----------
    counts : (3, 2) int64 array    Samples lost, and all, by `WAYS`.
    shares : (n,) float64 array or None    Of the samples of every lumel, of the kind that lost the largest part of its own,
        times their weights; None while nothing was lost. [-]
    """

    counts: np.ndarray = field(default_factory=lambda: np.zeros((len(WAYS), 2), dtype=np.int64))
    shares: np.ndarray | None = None

    def note(self, way: int, lost: int, made: int) -> None:
        """Count samples."""
        self.counts[way] += lost, made

    def note_shares(self, span: slice, shares: np.ndarray, count: int) -> None:
        """Note the largest shares (k,) that lumels of a span lost of any kind of samples. ``count``: of all lumels."""
        if self.shares is None:
            self.shares = np.zeros(count)
        self.shares[span] = shares

    def add(self, other: "Losses", levels: Levels) -> None:
        """Add those of a pass. ``levels``: of its samples, which are its weights."""
        shares = other.shares
        self.join(Losses(other.counts, None if shares is None else levels.samples() * shares))

    def join(self, other: "Losses") -> None:
        """Add those of passes that count with their weights already."""
        self.counts = self.counts + other.counts
        if other.shares is not None:
            self.shares = other.shares if self.shares is None else self.shares + other.shares

    @property
    def any(self) -> bool:
        """Whether anything was lost."""
        return bool(self.counts[:, 0].any())

    def shares_of(self, weights: np.ndarray) -> np.ndarray:
        """Share of its light that each lumel is without, where lost samples are like the others. (n,) [-]

        ``weights``: of all passes.
        """
        own = np.zeros(len(weights))
        if self.shares is not None:
            own = np.divide(self.shares, weights, out=own, where=weights > 0.0)
        lost, made = self.counts[[CELLS, TRACED]].T
        return 1.0 - (1.0 - np.minimum(own, 1.0)) * np.prod(1.0 - lost / np.maximum(made, 1))

    def parts(self) -> dict[str, tuple[int, int]]:
        """As of `accuracy.lost_samples.tell_lost`."""
        return dict(zip(NAMES, self.counts.tolist(), strict=True))

    def state(self) -> dict[str, np.ndarray]:
        """Everything, for a checkpoint."""
        return {"counts": self.counts} | ({} if self.shares is None else {"shares": self.shares})
