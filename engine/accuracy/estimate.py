"""Means with their standard errors from independent groups of samples."""

from dataclasses import dataclass, replace

import numpy as np


class Accumulator:
    """Sums of samples in double precision, kept apart by independent group, of which all have as many.

    Parameters
    ----------
    groups : int    Number of independently scrambled sequences, at least 2.
    shape : tuple    Shape of one group's values.
    """

    def __init__(self, groups: int, shape):
        self._sum = np.zeros((groups, *np.atleast_1d(shape)), dtype=np.float64)
        self.samples = 0

    @property
    def groups(self) -> int:
        """Number of groups."""
        return len(self._sum)

    def add(self, sums: np.ndarray, samples: int) -> None:
        """Add sums (groups, ...) over ``samples`` new samples of every group."""
        self._sum += sums
        self.samples += samples

    def estimate(self) -> "Estimate":
        """Return mean and standard error so far."""
        means = self._sum / max(self.samples, 1)
        return Estimate.from_groups(means, self.samples * self.groups)


@dataclass(frozen=True)
class Estimate:
    """Values with their standard errors.

    ``mean`` and ``standard_error`` have the shape of the quantity; ``samples`` counts all groups together. ``events``: as
    how many samples of the largest one's size the squares of all add up to; None where nobody counted. ``lost``: how many
    samples of all values together were no numbers. ``floors``: part of the errors that more samples do not lower, the same
    in all channels (n,); None where there is none. ``fewest_most``: samples of the values that have fewest and most of them;
    None where all have as many, and ``samples`` is their mean otherwise.
    """

    mean: np.ndarray
    standard_error: np.ndarray
    samples: int
    events: np.ndarray | None = None
    lost: int = 0
    floors: np.ndarray | None = None
    fewest_most: tuple[int, int] | None = None

    @classmethod
    def from_groups(cls, means: np.ndarray, samples: int) -> "Estimate":
        """Combine group means (groups, ...): Var(mean) = sum (m_g - m)^2 / (G (G - 1)).

        With two groups the standard error is half the difference of the halves, so the root mean square of it over a
        map is the map's error as the reference system defines it, with the factor 1/2 of a mean of two.
        """
        mean = means.mean(axis=0)
        count = len(means)
        variance = ((means - mean) ** 2).sum(axis=0) / (count * (count - 1))
        return cls(mean, np.sqrt(variance), samples)

    def channel(self, number: int) -> "Estimate":
        """One column of an estimate of shape (n, channels)."""
        mean, error = self.mean[:, number], self.standard_error[:, number]
        return Estimate(mean, error, self.samples, lost=self.lost, floors=self.floors)

    def widened(self, floors: np.ndarray) -> "Estimate":
        """With errors that hold what values (n,) may be off by as well, in all channels."""
        whole = floors if self.floors is None else np.hypot(self.floors, floors)
        floors = floors.reshape(len(floors), *[1] * (self.mean.ndim - 1))
        error = np.hypot(self.standard_error, floors)
        return replace(self, standard_error=error, floors=whole)

    def relative_error(self, weights: np.ndarray | None = None) -> float:
        """Standard error of the map: root mean square of the errors over the mean, both weighted by area.

        Parameters
        ----------
        weights : array or None    Areas, of the shape of ``mean``; None: all alike.

        Returns
        -------
        float    Infinite when nothing but zeros was found so far. [-]
        """
        weights = np.ones_like(self.mean) if weights is None else weights
        total = weights.sum()
        mean = float((self.mean * weights).sum() / total) if total > 0.0 else 0.0
        if mean <= 0.0:
            return float("inf")
        return float(np.sqrt((self.standard_error**2 * weights).sum() / total)) / mean

    def largest_error(self, floor: float = 0.0) -> float:
        """Largest standard error of a single value over the value, or over ``floor`` where that is larger. [-]

        A value of 0 without error counts as known.
        """
        scale = np.maximum(np.abs(self.mean), floor)
        unknown = (scale <= 0.0) & (self.standard_error > 0.0)
        if unknown.any():
            return float("inf")
        return float((self.standard_error / np.where(scale > 0.0, scale, 1.0)).max(initial=0.0))


def relative_error(luminance: np.ndarray, standard_error: np.ndarray) -> float:
    """Error of a picture: root mean square of the pixels' over the larger of their own and the mean luminance. [-]

    So a lamp in view counts by its own luminance, and its edge does not hide what happens elsewhere.
    """
    mean = luminance.mean()
    if mean <= 0.0:
        return float("inf")
    return float(np.sqrt(((standard_error / np.maximum(luminance, mean)) ** 2).mean()))
