"""Statistics of programs that race: times to an error, means of ratios."""

import math
from dataclasses import dataclass

import numpy as np

STEEPEST, FLATTEST = -1.0, -0.1
"""Exponents of the error in the time that are believed when a program is thought on; one that is flatter has come to the end
of what it can do."""


@dataclass(frozen=True)
class Reach:
    """Time to an error.

    Parameters
    ----------
    seconds : float    At least so many where ``bound`` is ``>``, at most where it is ``<``.
    bound : str    Empty where the time is known.
    is_thought_on : bool    Whether it lies beyond the runs, on the line through the last of them.
    """

    seconds: float
    bound: str = ""
    is_thought_on: bool = False


def seconds_to(points: list[tuple[float, float]], target: float) -> Reach:
    """Time to a relative error, between runs or beyond them.

    Parameters
    ----------
    points : list of (seconds, error)    Runs with more and more work.
    target : float
    """
    points = sorted(points)
    x = np.log([max(seconds, 1e-9) for seconds, _ in points])
    y = np.log([max(error, 1e-12) for _, error in points])
    goal = math.log(target)
    met = np.flatnonzero(y <= goal)
    if len(met) and met[0] == 0:
        return Reach(points[0][0], "<")
    if len(met):
        k = int(met[0])
        share = (goal - y[k - 1]) / (y[k] - y[k - 1])
        return Reach(float(np.exp(x[k - 1] + share * (x[k] - x[k - 1]))))
    if len(points) < 2:
        return Reach(points[-1][0], ">")
    slope = np.polyfit(x[-3:], y[-3:], 1)[0]
    if slope > FLATTEST:
        return Reach(points[-1][0], ">")
    slope = max(slope, STEEPEST)
    return Reach(float(np.exp(x[-1] + (goal - y[-1]) / slope)), "", True)


def geometric_mean(values) -> float | None:
    """Geometric mean, None of nothing."""
    values = [value for value in values if value is not None and value > 0.0]
    return float(np.exp(np.mean(np.log(values)))) if values else None


def median(values) -> float | None:
    """Median, None of nothing."""
    return float(np.median(list(values))) if len(values) else None
