"""Quantiles of Student's distribution, by which errors become intervals."""

import functools
import math
from statistics import NormalDist

LARGE = 1e5
"""Degrees of freedom from which the first term of the expansion about the normal distribution is right to 1e-9."""


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
