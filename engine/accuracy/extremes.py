"""Least and largest value of a noisy map, with the range that holds the true one.

The largest of many estimates is too large: where values are alike, the one that noise has raised most wins. So the place is
chosen by one half of the samples and the value is read in the other, which knows nothing of the choice.
"""

import math
from dataclasses import dataclass

import numpy as np

from .student import t_quantile

PROBABILITY = 0.95
"""Of the ranges. [-]"""


@dataclass(frozen=True)
class Extreme:
    """An extreme value of a map.

    Parameters
    ----------
    value : float    Mean of what each half says of the place that the other half has chosen.
    low, high : float    Range that holds the true extreme with `PROBABILITY` at least; infinite width: nothing is known.
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Halves:
    """Estimates of a map, and those of its two independent halves.

    Parameters
    ----------
    mean, error : (n,) array    Estimates of all samples, and their standard errors.
    even, odd : (n,) array    Estimates of the halves; `mean` is their mean weighted by samples.
    even_share : (n,) array    Share of the samples that the even half has; 0 or 1: the other half has none. [-]
    freedom : float    Degrees of freedom of the errors. [-]
    """

    mean: np.ndarray
    error: np.ndarray
    even: np.ndarray
    odd: np.ndarray
    even_share: np.ndarray
    freedom: float


def find_largest(halves: Halves, common: float = 0.0) -> Extreme:
    """Largest value of a map.

    Parameters
    ----------
    halves : Halves    Of at least one value.
    common : float    Relative standard error that all values have in common. [-]

    Returns
    -------
    Extreme

    Notes
    -----
    The value is no larger on average than the true extreme, by about one standard error at most where many values compete.
    Below, the range ends where the chosen places may be; above, where no single value can be expected to be: the place of
    the true extreme is one of them, so that one interval suffices however many there are.
    """
    known = (halves.even_share > 0.0) & (halves.even_share < 1.0)
    if not known.any():
        return Extreme(float(halves.mean.max()), 0.0, math.inf)
    t = t_quantile(0.5 * (1.0 + PROBABILITY), max(halves.freedom, 1.0))
    value, error = _read_crosswise(halves, known)
    low = value - t * error
    high = max(float((halves.mean + t * halves.error).max()), value)
    shared = t * common * abs(value)
    return Extreme(
        value, value - math.hypot(value - low, shared), value + math.hypot(high - value, shared)
    )


def find_least(halves: Halves, common: float = 0.0) -> Extreme:
    """Least value of a map that is nowhere below 0; as `find_largest`."""
    turned = Halves(
        -halves.mean, halves.error, -halves.even, -halves.odd, halves.even_share, halves.freedom
    )
    found = find_largest(turned, common)
    if not math.isfinite(found.high):
        return Extreme(-found.value, 0.0, math.inf)
    # The other way round, a negative zero would win.
    return Extreme(max(0.0, -found.value), max(0.0, -found.high), max(0.0, -found.low))


def part_by_mean(
    least: Extreme, largest: Extreme, mean: float, mean_error: float, freedom: float = math.inf
) -> tuple[Extreme, Extreme]:
    """Bound extremes by the mean, which lies between them and is known far better than any value; none is below 0.

    Parameters
    ----------
    mean, mean_error : float    Mean of the map and its standard error.
    """
    reach = t_quantile(0.5 * (1.0 + PROBABILITY), max(freedom, 1.0)) * mean_error
    highest, lowest = mean + reach, mean - reach
    below = (min(least.value, mean), min(least.low, highest), min(least.high, highest))
    above = (max(largest.value, mean), max(largest.low, lowest, 0.0), max(largest.high, lowest))
    return Extreme(*below), Extreme(*above)


def divide(extreme: Extreme, mean: float, mean_error: float, freedom: float = math.inf) -> Extreme:
    """Relate an extreme to the mean, such as for uniformity; ``mean_error``: standard error of the mean."""
    if not mean > 0.0:
        return Extreme(0.0, 0.0, math.inf)
    value = extreme.value / mean
    t = t_quantile(0.5 * (1.0 + PROBABILITY), max(freedom, 1.0))
    shared = t * value * mean_error / mean
    low = value - math.hypot(value - extreme.low / mean, shared)
    return Extreme(value, max(low, 0.0), value + math.hypot(extreme.high / mean - value, shared))


def _read_crosswise(halves: Halves, known: np.ndarray) -> tuple[float, float]:
    """Value at the places that the halves choose for each other, and its standard error."""
    rows = np.flatnonzero(known)
    by_even = rows[halves.even[rows].argmax()]
    by_odd = rows[halves.odd[rows].argmax()]
    # Shares of the samples that the value is read with, and so its variances there.
    shares = np.array([1.0 - halves.even_share[by_even], halves.even_share[by_odd]])
    values = np.array([halves.odd[by_even], halves.even[by_odd]], dtype=np.float64)
    variances = np.array([halves.error[by_even], halves.error[by_odd]], np.float64) ** 2 / shares
    weights = shares / shares.sum()
    return float(weights @ values), math.sqrt(float(weights**2 @ variances))
