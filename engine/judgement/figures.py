"""Figures of an area from values with errors: mean, least, largest, uniformities, each with the range that holds it."""

import math
from dataclasses import dataclass

import numpy as np

from ..accuracy.student import t_quantile
from .verdict import Range


@dataclass(frozen=True)
class AreaFigures:
    """Figures of an area.

    Parameters
    ----------
    mean, minimum, maximum : Range    [lx]
    uniformity, diversity : Range    Least over mean (Uo), least over largest (Ud). [-]
    """

    mean: Range
    minimum: Range
    maximum: Range
    uniformity: Range
    diversity: Range


def find_figures(
    values, errors, tail: float, freedom: float = math.inf, has_common: bool = False
) -> AreaFigures:
    """Find the figures of an area that sensors share alike.

    Parameters
    ----------
    values, errors : (n,) array    Illuminances and their standard errors. [lx]
    tail : float    Probability with which the true figure may be beyond each end of its range.
    freedom : float    Degrees of freedom of the errors.
    has_common : bool    Whether errors have much in common, so that they do not cancel in the mean.

    Returns
    -------
    AreaFigures

    Notes
    -----
    The least of noisy values is too small. Below, the range of the least ends where no single value can be expected to be:
    the place of the true one is one of them, so one interval suffices. Above, none of all values may be wrong, so that
    ``tail`` is shared out among them.
    """
    values, errors = (np.asarray(each, dtype=np.float64) for each in (values, errors))
    count = len(values)
    # Errors of many sensors know their size better than that of one.
    of_mean = t_quantile(1.0 - tail, freedom if has_common else freedom * count)
    error = float(np.sqrt((errors**2).mean()))
    error = error if has_common else error / math.sqrt(count)
    mean = float(values.mean())
    mean = Range(mean, max(mean - of_mean * error, 0.0), mean + of_mean * error)
    one, every = (t_quantile(1.0 - each, freedom) for each in (tail, tail / count))
    least, largest = float(values.min()), float(values.max())
    low = max(float((values - one * errors).min()), 0.0)
    minimum = Range(least, low, max(float((values + every * errors).min()), low))
    high = float((values + one * errors).max())
    maximum = Range(largest, max(float((values - every * errors).max()), 0.0), high)
    return AreaFigures(mean, minimum, maximum, _ratio(minimum, mean), _ratio(minimum, maximum))


def _ratio(part: Range, whole: Range) -> Range:
    """Ratio of two figures, the first not above the second."""
    if whole.value <= 0.0:
        return Range(0.0, 0.0, math.inf)
    high = min(part.high / whole.low, 1.0) if whole.low > 0.0 else 1.0
    return Range(part.value / whole.value, min(part.low / whole.high, high), high)
