"""Verdicts: whether a value with an error meets a limit, and how much longer it takes to know."""

import math
from dataclasses import dataclass
from enum import Enum
from statistics import NormalDist

_NORMAL = NormalDist()

WRONG = 0.05
"""Probability of a wrong verdict of a requirement at most, also where it was looked at several times. [-]"""

LOOKS = 4
"""Looks that share it: a run that is not decided may be gone on with three times."""

CHOSEN = 2
"""Factor by which a look has to be more certain as its time is chosen by what was seen before: where a range is about to
leave the limit, one looks again soon, and is wrong more often than at times that were set before."""

PATIENCE = 1e4
"""Times as long beyond which nothing is foretold: value and limit are the same as far as one can tell."""


class State(Enum):
    """How a limit stands."""

    MET = "met"
    NOT_MET = "not met"
    UNDECIDED = "not decided yet"
    UNKNOWN = "not measured"


@dataclass(frozen=True)
class Range:
    """A value, and the range that holds the true one.

    Parameters
    ----------
    value : float
    low, high : float    The true value is below the one, or above the other, with the probability `tail` at most each.
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Verdict:
    """What is known of one limit.

    Parameters
    ----------
    name : str    Of the limit, for people.
    limit : float
    is_most : bool    Whether the value must not be above the limit, instead of below.
    found : Range or None    None: not measured.
    state : State
    more : float or None    Of the time so far, how much more decides it as likely as not; None where it is decided or never
        will be. [-]
    """

    name: str
    limit: float
    is_most: bool
    found: Range | None
    state: State
    more: float | None = None


def tail(limits: int) -> float:
    """Probability with which the ends of ranges may be passed, where a requirement has so many limits. [-]"""
    return WRONG / (CHOSEN * LOOKS * max(limits, 1))


def reach(limits: int) -> float:
    """Half width of a range of a normal value, in its standard errors, where a requirement has so many limits. [-]"""
    return _NORMAL.inv_cdf(1.0 - tail(limits))


def judge(
    name: str, limit: float, found: Range | None, limits: int = 1, is_most: bool = False
) -> Verdict:
    """Judge a value by a limit.

    Parameters
    ----------
    name : str
    limit : float    Least value, or largest.
    found : Range or None    None: not measured.
    limits : int    How many the requirement has.
    is_most : bool
    """
    if found is None:
        return Verdict(name, limit, is_most, None, State.UNKNOWN)
    above, below = found.low >= limit, found.high < limit
    if is_most:
        above, below = found.low > limit, found.high <= limit
        above, below = below, above
    if above or below:
        return Verdict(name, limit, is_most, found, State.MET if above else State.NOT_MET)
    return Verdict(name, limit, is_most, found, State.UNDECIDED, _more(found, limit, reach(limits)))


def overall(verdicts) -> State:
    """How a requirement stands by its limits: met if all are, not met if one is not; what is not measured does not count."""
    return join_states(each.state for each in verdicts)


def join_states(states) -> State:
    """As `overall`, of states."""
    states = [state for state in states if state is not State.UNKNOWN]
    if not states:
        return State.UNKNOWN
    if State.NOT_MET in states:
        return State.NOT_MET
    return State.UNDECIDED if State.UNDECIDED in states else State.MET


def more_of(verdicts) -> float | None:
    """Of the time so far, how much more decides what is open as likely as not; None where nothing is open or foretold."""
    open_ones = [each.more for each in verdicts if each.state is State.UNDECIDED]
    if not open_ones or None in open_ones:
        return None
    return max(open_ones)


def _more(found: Range, limit: float, width: float) -> float | None:
    """Of the time so far, how much more until a value is as likely decided as not.

    After r times as long the estimate is normal about the present one, with the variance (1 - 1/r) of the present one's, and
    its range is narrower by the root of r.
    """
    gap = found.value - limit
    half = found.high - found.value if gap < 0.0 else found.value - found.low
    if not math.isfinite(half) or half <= 0.0:
        return None
    # In standard errors.
    gap = abs(gap) * width / half

    def chance(ratio: float) -> float:
        spread = math.sqrt(1.0 - 1.0 / ratio)
        needed = width / math.sqrt(ratio)
        return _NORMAL.cdf((gap - needed) / spread) + _NORMAL.cdf((-gap - needed) / spread)

    low, high = 1.0 + 1e-6, PATIENCE
    if chance(high) < 0.5:
        return None
    for _ in range(60):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if chance(middle) < 0.5 else (low, middle)
    return high - 1.0
