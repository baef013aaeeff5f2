"""How right stated errors are: intervals by Student's t, and comparisons with a reference."""

import functools
import math
from statistics import NormalDist

import numpy as np

LARGE = 1e5
"""Degrees of freedom from which the first term of the expansion about the normal distribution is right to 1e-9."""

TABLE = 512
"""Steps in 1 / (degrees of freedom) between which quantiles of many values are interpolated."""


@functools.lru_cache(maxsize=8192)
def t_quantile(probability: float, degrees_of_freedom: float) -> float:
    """Quantile of Student's distribution.

    Parameters
    ----------
    probability : float    In 0..1, both excluded; 0.975 for the half width of an interval of 95 %.
    degrees_of_freedom : float    Above 0, not necessarily whole; infinite: the normal distribution.

    Returns
    -------
    float

    References
    ----------
    M. Abramowitz and I. A. Stegun, Handbook of Mathematical Functions, 26.7.1 and 26.5.8.
    """
    if not (0.0 < probability < 1.0 and degrees_of_freedom > 0.0):
        raise ValueError(f"no quantile {probability} of {degrees_of_freedom} degrees of freedom")
    if probability < 0.5:
        return -t_quantile(1.0 - probability, degrees_of_freedom)
    if degrees_of_freedom >= LARGE:
        z = NormalDist().inv_cdf(probability)
        return z + (z**3 + z) / (4.0 * degrees_of_freedom)
    tail = 1.0 - probability
    low, high = 0.0, 2.0
    while _upper_tail(high, degrees_of_freedom) > tail:
        low, high = high, 2.0 * high
    while high - low > 1e-11 * high:
        middle = 0.5 * (low + high)
        if _upper_tail(middle, degrees_of_freedom) > tail:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def t_quantiles(probability: float, degrees_of_freedom: np.ndarray) -> np.ndarray:
    """Quantiles for many degrees of freedom, each at least 1; right to 1e-5 of themselves."""
    nodes, table = _table(probability)
    return np.exp(np.interp(1.0 / np.asarray(degrees_of_freedom, dtype=np.float64), nodes, table))


def coverage(
    mean,
    error,
    degrees_of_freedom,
    reference,
    reference_error=0.0,
    probability: float = 0.95,
    area=None,
) -> float:
    """Share of the values whose interval holds the reference.

    The half width is t sqrt(error^2 + reference_error^2), with the degrees of freedom of that sum by Welch and
    Satterthwaite, the reference's own error being taken as known. Values that are the reference exactly and state no error
    (in the dark) say nothing and do not count.

    Parameters
    ----------
    mean, error : (n,) array    Values and their stated standard errors. [lx]
    degrees_of_freedom : float or (n,) array    Of the errors, at least 1.
    reference, reference_error : (n,) array or float    [lx]
    probability : float    Of the interval, above 0.5 as a rule.
    area : (n,) array or None    Weights; None: all alike. [m2]

    Returns
    -------
    float    NaN where no value counts. [-]
    """
    own = np.asarray(error, dtype=np.float64) ** 2
    other = np.asarray(reference_error, dtype=np.float64) ** 2
    distance = np.abs(np.asarray(mean, dtype=np.float64) - reference)
    together = own + other
    counts = (together > 0.0) | (distance > 0.0)
    share = np.divide(own, together, out=np.ones_like(together), where=together > 0.0)
    # Beyond 1e9 the distribution is normal; the bound keeps values without an error of their own finite.
    freedom = np.asarray(degrees_of_freedom) / np.maximum(share, 1e-5) ** 2
    width = t_quantiles(0.5 * (1.0 + probability), freedom) * np.sqrt(together)
    weights = counts * (1.0 if area is None else np.asarray(area, dtype=np.float64))
    total = weights.sum()
    return float((weights * (distance <= width)).sum() / total) if total > 0.0 else float("nan")


def error_ratio(mean, error, reference, reference_error=0.0, area=None) -> float:
    """True error of a map over its stated one, both as root mean squares; 1 is right, above 1 claims too much.

    What the reference itself is wrong by is taken off the mean square of the differences. As variances are compared, no
    correction for few degrees of freedom is due.

    Parameters
    ----------
    mean, error : (n,) array    Values and their stated standard errors. [lx]
    reference, reference_error : (n,) array or float    [lx]
    area : (n,) array or None    Weights; None: all alike. [m2]

    Returns
    -------
    float    Infinite where no error is stated and there is one. [-]
    """
    weights = np.ones(np.shape(mean)) if area is None else np.asarray(area, dtype=np.float64)
    difference = np.asarray(mean, dtype=np.float64) - reference
    true = float((weights * (difference**2 - np.asarray(reference_error) ** 2)).sum())
    stated = float((weights * np.asarray(error, dtype=np.float64) ** 2).sum())
    if stated <= 0.0:
        return float("inf") if true > 0.0 else 1.0
    return math.sqrt(max(true, 0.0) / stated)


@functools.lru_cache(maxsize=16)
def _table(probability: float) -> tuple[np.ndarray, np.ndarray]:
    """Logarithms of quantiles over 1 / (degrees of freedom) from 0 to 1."""
    nodes = np.linspace(0.0, 1.0, TABLE + 1)
    freedom = [math.inf, *(1.0 / nodes[1:])]
    return nodes, np.log([t_quantile(probability, each) for each in freedom])


def _upper_tail(t: float, nu: float) -> float:
    """Probability of more than ``t`` >= 0: half the incomplete beta function I_x(nu/2, 1/2), x = nu / (nu + t^2)."""
    x, rest = nu / (nu + t * t), t * t / (nu + t * t)
    a, b = 0.5 * nu, 0.5
    if rest == 0.0:
        return 0.5
    scale = math.exp(
        math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log(rest)
    )
    # The continued fraction is fast on either side of the mean only.
    if x < (a + 1.0) / (a + b + 2.0):
        return 0.5 * scale * _beta_fraction(x, a, b) / a
    return 0.5 * (1.0 - scale * _beta_fraction(rest, b, a) / b)


def _beta_fraction(x: float, a: float, b: float) -> float:
    """Continued fraction of the incomplete beta function, by the method of Lentz."""
    tiny = 1e-300
    c, d = 1.0, 1.0 - (a + b) * x / (a + 1.0)
    d = 1.0 / (d if abs(d) > tiny else tiny)
    value = d
    for m in range(1, 10_000):
        for step in (
            m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)),
        ):
            d = 1.0 + step * d
            d = 1.0 / (d if abs(d) > tiny else tiny)
            c = 1.0 + step / c
            c = c if abs(c) > tiny else tiny
            value *= c * d
        if abs(c * d - 1.0) < 1e-14:
            break
    return value
