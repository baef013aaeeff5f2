"""Seeds: the same one gives the same numbers, another one differs by as much as the errors say."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from .bench import Finding

LEAST_VALUES = 10
"""Values that a group needs for the comparison of seeds."""

CHI_SQUARE_RANGE = (0.5, 2.0)
"""Chi-square per degree of freedom between runs with different seeds, if the stated errors are right."""

DEGREES = 48
"""Degrees of freedom to gather: with ten alone, one honest program in seven would leave the range by chance."""


@dataclass(frozen=True)
class SeedCheck:
    """What repeating a group showed.

    Parameters
    ----------
    group : str    Its id.
    is_identical : bool    Whether the same seed gave the same numbers.
    chi_square : float or None    Per degree of freedom, over runs with different seeds; None: too few values.
    degrees : int    Degrees of freedom it was taken over.
    fault : str    Why the group could not be repeated; empty: it could.
    """

    group: str
    is_identical: bool
    chi_square: float | None
    degrees: int
    fault: str = ""

    @property
    def passes(self) -> bool:
        """Whether the rule on seeds is kept."""
        low, high = CHI_SQUARE_RANGE
        return self.is_identical and (self.chi_square is None or low <= self.chi_square <= high)

    @property
    def sentence(self) -> str:
        """What was found, for people."""
        if self.fault:
            return f"{self.group} could not be repeated: {self.fault}."
        same = "the same numbers" if self.is_identical else "OTHER NUMBERS"
        told = f"{self.group}: the same seed gives {same}"
        if self.chi_square is None:
            return f"{told}."
        word = "" if self.passes or not self.is_identical else ", which its errors do not explain"
        return (
            f"{told}, other seeds differ by a chi-square of {self.chi_square:.2f} "
            f"per degree of freedom ({self.degrees} of them){word}."
        )


def is_identical(a: Finding, b: Finding) -> bool:
    """Tell whether two findings of a group are the same in all numbers, to the last bit."""
    return bool(np.array_equal(a.values, b.values) and np.array_equal(a.errors, b.errors))


def chi_square_per_degree(a: Finding, b: Finding) -> float:
    """Squared differences of two runs with different seeds over their stated variance, averaged over the values.

    Values whose errors are 0 in both runs take no part: nothing about them is random.

    Raises
    ------
    ValueError    None of the values is random.
    """
    variance = np.asarray(a.errors) ** 2 + np.asarray(b.errors) ** 2
    random = variance > 0.0
    if not random.any():
        raise ValueError(f"{a.group.id} has no random values")
    difference = np.asarray(a.values)[random] - np.asarray(b.values)[random]
    return float((difference**2 / variance[random]).mean())


def count_random(finding: Finding) -> int:
    """Count the values that carry a standard error."""
    return int(np.count_nonzero(finding.errors))


def choose_group(findings: Iterable[Finding], case: str) -> Finding | None:
    """The quickest group of a case with at least ten random values, else its quickest with any; None: there is none."""
    random = [found for found in findings if found.group.case == case and count_random(found)]
    large = [found for found in random if count_random(found) >= LEAST_VALUES]
    return min(large or random, key=lambda found: found.seconds, default=None)


def check_seeds(finding: Finding, measure: Callable[[int], Finding], seed: int) -> SeedCheck:
    """Repeat a group with the same seed and with others.

    Parameters
    ----------
    finding : Finding    Of the group, from a run of more than it.
    measure : callable    From a seed to a finding of the group alone.
    seed : int    Of the run.
    """
    first, again = measure(seed), measure(seed)
    identical = is_identical(first, again)
    count = count_random(finding)
    if count < LEAST_VALUES:
        return SeedCheck(finding.group.id, identical, None, 0)
    # Pairs of runs share no run, so that their chi-squares add up.
    pairs = [(first, measure(seed + 1))]
    pairs += [
        (measure(seed + 2 * i), measure(seed + 2 * i + 1)) for i in range(1, -(-DEGREES // count))
    ]
    return SeedCheck(
        finding.group.id,
        identical,
        float(np.mean([chi_square_per_degree(a, b) for a, b in pairs])),
        count * len(pairs),
    )
