"""Heavy tails: what an error is worth that stems from a few large samples.

A variance of which a share 1/k is due to its largest part is known as well as from k events of one size. Where k events
were seen there may well be k + sqrt(k + 3/4) + 1 of them in the mean (upper limit of 84 %, N. Gehrels, The Astrophysical
Journal 303, 1986, eq. 7), so the mean may lack (sqrt(k + 3/4) + 1) / sqrt(k) of its standard errors: 2.3 for one event.
"""

import numpy as np

TRUSTED = 10.0
"""Events from which a standard error is taken as it is; it scatters as much anyhow."""

HEAVY = 10.0
"""Share of the largest part over that of a mean one from which a tail is heavy: of a few parts each may be large."""


def tail_factor(total, largest, count) -> np.ndarray:
    """Factor by which a standard error grows that stems from few of many parts.

    Parameters
    ----------
    total, largest : (n,) array or float    Sum of what makes up the variance, and the largest part of it; not negative.
    count : (n,) array or float    Number of parts.

    Returns
    -------
    (n,) array    1 where the largest part is less than a share 1 / `TRUSTED`, or like the others. [-]
    """
    total, largest = np.asarray(total, dtype=np.float64), np.asarray(largest, dtype=np.float64)
    is_heavy = (largest > 0.0) & (largest * count > HEAVY * total)
    events = np.divide(total, largest, out=np.full(total.shape, TRUSTED), where=is_heavy)
    events = np.clip(events, 1.0, TRUSTED)
    factor = (np.sqrt(events + 0.75) + 1.0) / np.sqrt(events)
    return np.where(is_heavy & (events < TRUSTED), factor, 1.0)
