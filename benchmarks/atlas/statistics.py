"""Statistics of the benchmark of the atlas: times to an error, intervals, means of ratios."""

import math
from dataclasses import dataclass

import numpy as np

TARGETS = (0.02, 0.01)
"""Relative errors to which programs race. [-]"""

STEEPEST, FLATTEST = -1.0, -0.1
"""Exponents of the error in the time that are believed when a program is thought on; one that is flatter has come to the end
of what it can do."""

CONFIDENCE = 0.95


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


def student_quantile(probability: float, freedom: float) -> float:
    """Quantile of Student's t, by the integral of its density. ``freedom``: at least 1; ``probability`` above 1/2."""
    low, high = 0.0, 1.0
    while _student_share(high, freedom) < probability:
        high *= 2.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _student_share(middle, freedom) < probability:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _student_share(t: float, freedom: float) -> float:
    """Probability of being below t.

    With t = sqrt(n) tan(a) the density becomes a power of a cosine, smooth between finite ends.
    """
    nodes, weights = np.polynomial.legendre.leggauss(64)
    end = math.atan(t / math.sqrt(freedom))
    angles = 0.5 * end * (nodes + 1.0)
    integral = 0.5 * end * float(weights @ np.cos(angles) ** (freedom - 1))
    log_scale = math.lgamma(0.5 * (freedom + 1)) - math.lgamma(0.5 * freedom)
    return 0.5 + math.exp(log_scale) / math.sqrt(math.pi) * integral
