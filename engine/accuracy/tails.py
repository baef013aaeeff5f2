"""Heavy tails: what an error is worth that stems from a few large samples.

A variance of which a share 1/k is due to its largest part is as good as that of k events of one size. Events of which k were
seen may well be k + sqrt(k + 3/4) + 1 in the mean (upper limit of 84 %, N. Gehrels, The Astrophysical Journal 303, 1986,
eq. 7), so the mean may lack (sqrt(k + 3/4) + 1) / sqrt(k) standard errors: 2.3 for a single event, 1.2 for 25.
"""

import numpy as np

TRUSTED = 25.0
"""Events from which a standard error is taken as it is: the factor would be 1.2, and so does it scatter anyhow."""


def tail_factor(total, largest) -> np.ndarray:
    """Factor by which a standard error grows that stems from few parts.

    Parameters
    ----------
    total, largest : (n,) array or float    Sum of what makes up the variance, and the largest part of it; not negative.

    Returns
    -------
    (n,) array    1 where the largest part is less than a share 1 / `TRUSTED`, or where there is nothing. [-]
    """
    total, largest = np.asarray(total, dtype=np.float64), np.asarray(largest, dtype=np.float64)
    some = largest > 0.0
    count = np.maximum(np.divide(total, largest, out=np.full_like(total, np.inf), where=some), 1.0)
    count = np.minimum(count, TRUSTED)
    factor = (np.sqrt(count + 0.75) + 1.0) / np.sqrt(count)
    return np.where(some & (count < TRUSTED), factor, 1.0)
