"""Two witnesses: whether two independent estimates of the same quantities agree, and what is stated where they do not."""

from dataclasses import dataclass

import numpy as np

from .calibration import t_quantile

CHANCE = 6.3e-5
"""Probability of finding any difference at all where there is none: that of four standard errors."""


@dataclass(frozen=True)
class Verdict:
    """What a comparison says.

    Parameters
    ----------
    difference : (n,) array    Second estimate less the first.
    differs : (n,) bool array    Where it is more than chance explains, quantity by quantity.
    floor : (n,) array    What the error of the first must be at least; 0 where nothing is known against it.
    rest : float    Difference of the mean of all quantities that do not differ by themselves; 0 where chance explains it.
    """

    difference: np.ndarray
    differs: np.ndarray
    floor: np.ndarray
    rest: float = 0.0

    @property
    def agrees(self) -> bool:
        """Whether nothing differs."""
        return not self.differs.any() and self.rest == 0.0


def batch_error(values: np.ndarray) -> np.ndarray:
    """Standard error of the mean over independent batches. (b, ...) -> (...)"""
    count = len(values)
    return values.std(axis=0, ddof=1) / np.sqrt(count)


def compare(first, first_error, second, second_error, freedom, weights, hidden=0.0) -> Verdict:
    """Compare two estimates of several quantities.

    A difference counts where it exceeds the joint error times Student's t for the probability `CHANCE`, shared between all
    quantities and their mean (Bonferroni); the degrees of freedom are those of Welch and Satterthwaite.

    Parameters
    ----------
    first, first_error : (n,) array    Estimates and standard errors; infinite errors are of what is not known.
    second, second_error : (n,) array
    freedom : (float, float)    Degrees of freedom of the two errors.
    weights : (n,) array    For the mean.
    hidden : (n,) array or float    What the second may have missed altogether, whatever its error; it makes it smaller only.

    Returns
    -------
    Verdict
    """
    first, second = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    own, other = np.asarray(first_error, float) ** 2, np.asarray(second_error, float) ** 2
    weights = np.asarray(weights, dtype=np.float64)
    difference = second - first
    hidden = np.broadcast_to(np.asarray(hidden, dtype=np.float64), difference.shape)
    other = other + np.where(difference < 0.0, hidden, 0.0) ** 2
    if len(difference) == 0:
        return Verdict(difference, np.zeros(0, dtype=bool), difference)
    share = CHANCE / (len(difference) + 1)
    known = np.isfinite(own) & np.isfinite(other)
    differs = known & _exceeds(difference, own, other, freedom, share)
    floor = np.where(differs, np.abs(difference), 0.0)
    rest = 0.0
    others = known & ~differs & (weights > 0.0)
    if others.any():
        part = weights[others] / weights[others].sum()
        mean = float(part @ difference[others])
        sums = [float(part**2 @ each[others]) for each in (own, other)]
        # What hides from one may hide from all.
        sums[1] += float(part @ hidden[others]) ** 2 if mean < 0.0 else 0.0
        if _exceeds(np.array([mean]), *(np.array([s]) for s in sums), freedom, share)[0]:
            rest = mean
            floor[others] = abs(mean)
    return Verdict(difference, differs, floor, rest)


def _exceeds(difference, own, other, freedom, chance: float) -> np.ndarray:
    total = own + other
    spread = own**2 / freedom[0] + other**2 / freedom[1]
    together = np.divide(total**2, spread, out=np.full_like(total, np.inf), where=spread > 0.0)
    # Few different ones serve all: quantiles are by steps.
    together = np.clip(np.floor(together), 1.0, 200.0)
    limit = np.array([t_quantile(1.0 - 0.5 * chance, float(nu)) for nu in together])
    return np.abs(difference) > limit * np.sqrt(total)
