"""How little a path of a sensor may count before roulette pays."""

import math

FIRST = 0.03
"""Variance of a sample without roulette, relative to the square of the mean, that is supposed before any is known: that of
rooms under lamps. [-]"""

COST = 4.0
"""What a path takes to where it has faded to 1, in what it takes to fade to 1 / e of anything; 2 to 6 in rooms. [-]"""

LEAST = 0.02
"""Smallest share at which roulette begins. [-]"""

SURE = 0.5
"""Share of the variance that stands for no roulette, at least: what is reckoned of the latter is not exact. [-]"""

ROUNDS = 40
"""Times that the interval is halved which holds the share."""


def own_variance(reflectance: float) -> float:
    """Variance of a sensor's sample by roulette that begins at the third vertex, over the square of the mean, about. [-]

    Where all surfaces glow alike it is rho^4 (1 + rho - rho^2); sensors that lamps face have less of their light by
    reflections. This was measured in rooms under panels (theory 3.4).
    """
    return reflectance**5


def find_saving(reflectance: float) -> float:
    """Share of the time to an error that late roulette saves, where samples scatter as those in rooms under lamps. [-]"""
    by_roulette, share = own_variance(reflectance), find_share(reflectance)
    late = (FIRST + by_roulette * share**2) * (COST - math.log(share))
    return 1.0 - late / ((FIRST + by_roulette) * COST)


def find_share(reflectance: float, variance: float | None = None, share: float = 1.0) -> float:
    """Throughput below which roulette is played, so that time and variance multiply to the least. [-]

    Parameters
    ----------
    reflectance : float    Of surfaces on the mean; 0: roulette begins at the third vertex. [-]
    variance : float or None    Of samples, over the square of the mean; None: not known. [-]
    share : float    What these were made with.
    """
    by_roulette = own_variance(reflectance)
    if by_roulette <= 0.0:
        return 1.0
    rest = FIRST
    if variance is not None:
        rest = max(variance - by_roulette * share**2, SURE * variance)
    # Of (rest + by_roulette t^2) (COST + ln(1 / t)) the least.
    low, high = math.log(LEAST), 0.0
    for _ in range(ROUNDS):
        middle = 0.5 * (low + high)
        rises = by_roulette * math.exp(2.0 * middle) * (2.0 * COST - 1.0 - 2.0 * middle) > rest
        low, high = (low, middle) if rises else (middle, high)
    return math.exp(high)
