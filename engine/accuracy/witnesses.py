"""Two witnesses: whether two independent estimates of the same quantities agree, and what is stated where they do not."""

from dataclasses import dataclass

import numpy as np

from .student import t_quantile

CHANCE = 6.3e-5
"""Probability of finding any difference at all that stems from the second's errors: that of four standard errors."""

DOUBT = 0.1
"""Probability of finding a difference that is worth another look where there is none. [-]"""

OWN_ERRORS = 3.0
"""Standard errors of the first that a difference must exceed: where it states so much, more of it does no harm."""


@dataclass(frozen=True)
class Verdict:
    """What a comparison says.

    Parameters
    ----------
    difference : (n,) array    Second estimate less the first.
    differs : (n,) bool array    Where it is more than chance explains, quantity by quantity.
    floor : (n,) array    What the error of the first must be at least; 0 where nothing is known against it.
    rest : float    Difference of the mean of all quantities that do not differ by themselves; 0 where chance explains it.
    is_doubtful : bool    Whether chance explains what is left, but hardly: a second of smaller error should decide.
    """

    difference: np.ndarray
    differs: np.ndarray
    floor: np.ndarray
    rest: float = 0.0
    is_doubtful: bool = False

    @property
    def agrees(self) -> bool:
        """Whether nothing differs."""
        return not self.differs.any() and self.rest == 0.0


def batch_error(values: np.ndarray) -> np.ndarray:
    """Standard error of the mean over independent batches. (b, ...) -> (...)"""
    count = len(values)
    return values.std(axis=0, ddof=1) / np.sqrt(count)


def compare(
    first,
    first_error,
    second,
    second_error,
    freedom,
    weights,
    hidden=0.0,
    batches=None,
    doubt=DOUBT,
) -> Verdict:
    """Compare two estimates of several quantities.

    A difference d counts where d^2 > (3 e_1)^2 + (t e_2)^2, with the errors e_1 of what is stated and e_2 of the witness. t
    is Student's for the probability `CHANCE`, shared between all quantities and their mean (Bonferroni), for the witness is
    the less exact one as a rule and must not blame what is right; a first that is uncertain itself is soon made more so.

    Parameters
    ----------
    first, first_error : (n,) array    Estimates and standard errors; infinite errors are of what is not known.
    second, second_error : (n,) array
    freedom : float    Degrees of freedom of the second's errors.
    weights : (n,) array    For the mean.
    hidden : (n,) array or float
        What a single path of the second may bring, whatever its error; so many paths k may have missed by chance that all do
        with the probability asked for, exp(-k). It makes the second smaller only.
    batches : (b, n) array or None
        Independent estimates whose mean is the second: its errors may have much in common. None: they have nothing.
    doubt : float    Probability of finding a difference that is worth another look where there is none. [-]

    Returns
    -------
    Verdict
    """
    first, second = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    own, other = np.asarray(first_error, float) ** 2, np.asarray(second_error, float) ** 2
    weights = np.asarray(weights, dtype=np.float64)
    difference = second - first
    hidden = np.broadcast_to(np.asarray(hidden, dtype=np.float64), difference.shape)
    if len(difference) == 0:
        return Verdict(difference, np.zeros(0, dtype=bool), difference)
    chance = 0.5 * CHANCE / (len(difference) + 1)
    limit = t_quantile(1.0 - chance, freedom)
    near = t_quantile(1.0 - 0.5 * doubt / (len(difference) + 1), freedom)
    # As an error, of which there are as many.
    hidden = hidden * (-np.log(chance) / limit)
    other = other + np.where(difference < 0.0, hidden, 0.0) ** 2
    known = np.isfinite(own) & np.isfinite(other)
    differs = known & _exceeds(difference, own, other, limit)
    floor = np.where(differs, np.abs(difference), 0.0)
    rest = 0.0
    is_doubtful = bool((known & ~differs & (difference**2 > near**2 * (own + other))).any())
    others = known & ~differs & (weights > 0.0)
    if others.any():
        part = weights[others] / weights[others].sum()
        mean = float(part @ difference[others])
        sums = [float(part**2 @ each[others]) for each in (own, other)]
        if batches is not None:
            sums[1] = float(batch_error(batches[:, others] @ part) ** 2)
        # What hides from one may hide from all.
        sums[1] += float(part @ hidden[others]) ** 2 if mean < 0.0 else 0.0
        if _exceeds(mean, *sums, limit):
            rest = mean
            floor[others] = abs(mean)
        else:
            is_doubtful |= bool(mean**2 > near**2 * sum(sums))
    return Verdict(difference, differs, floor, rest, is_doubtful)


def _exceeds(difference, own, other, limit: float) -> np.ndarray:
    """Whether differences are more than errors explain. ``own``, ``other``: variances."""
    return difference**2 > OWN_ERRORS**2 * own + limit**2 * other
