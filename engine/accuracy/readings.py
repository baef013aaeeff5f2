"""Figures of sensors that belong together: mean, extremes and their ratios, each with the range of the true one."""

from dataclasses import dataclass

import numpy as np

from .extremes import PROBABILITY, Extreme, divide, part_by_mean
from .student import t_quantile

FREEDOM = 15
"""Degrees of freedom of the errors of sensors, which come from 16 groups of samples."""


@dataclass(frozen=True)
class Figures:
    """What sensors that belong together tell.

    Parameters
    ----------
    mean, mean_error : float    [lx]
    least, largest : Extreme    [lx]
    overall : Extreme    U0: the least over the mean. [-]
    diversity : Extreme    Ud: the least over the largest. [-]
    """

    mean: float
    mean_error: float
    least: Extreme
    largest: Extreme
    overall: Extreme
    diversity: Extreme


def judge_readings(values, errors, has_common: bool = True) -> Figures:
    """Figures of readings.

    Parameters
    ----------
    values, errors : (n,) array    Readings and their standard errors, at least one. [lx]
    has_common : bool    Whether errors may have a cause in common.

    Notes
    -----
    Where errors may have a cause in common, that of the mean is the mean of the errors, which it cannot exceed.
    Extremes are those of the readings; their ranges hold the true ones in 95 % of all cases at least: towards the inside any
    of n sensors may be the one, so that the bound holds for all at once (Bonferroni); towards the outside one suffices.
    """
    values, errors = (np.asarray(each, dtype=np.float64) for each in (values, errors))
    single = t_quantile(0.5 * (1.0 + PROBABILITY), FREEDOM)
    at_once = t_quantile(1.0 - 0.5 * (1.0 - PROBABILITY) / len(values), FREEDOM)
    mean, mean_error = float(values.mean()), float(errors.mean())
    if not has_common:
        mean_error = float(np.sqrt((errors**2).mean() / len(errors)))
    least = Extreme(
        float(values.min()),
        max(float((values - single * errors).min()), 0.0),
        float((values + at_once * errors).min()),
    )
    largest = Extreme(
        float(values.max()),
        max(float((values - at_once * errors).max()), 0.0),
        float((values + single * errors).max()),
    )
    least, largest = part_by_mean(least, largest, mean, mean_error, FREEDOM)
    overall = divide(least, mean, mean_error, FREEDOM)
    return Figures(mean, mean_error, least, largest, overall, _over(least, largest))


def _over(least: Extreme, largest: Extreme) -> Extreme:
    """Ratio of two extremes; both ranges hold, so that of the ratio ends where both are at their ends. [-]"""
    if not largest.value > 0.0:
        return Extreme(0.0, 0.0, 1.0)
    high = least.high / largest.low if largest.low > 0.0 else 1.0
    return Extreme(
        least.value / largest.value,
        least.low / largest.high if largest.high > 0.0 else 0.0,
        min(high, 1.0),
    )
