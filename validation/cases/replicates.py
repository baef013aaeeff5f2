"""Values made of independent measurements of the same thing, with errors from how these differ."""

from collections.abc import Callable

import numpy as np


def jackknife(function: Callable, parts) -> tuple[np.ndarray, np.ndarray]:
    """Value of a smooth function of a mean, and its standard error.

    What several numbers of a measurement share, such as noise of X, Y and Z by the same wavelengths, is accounted for.

    Parameters
    ----------
    function : callable    From the mean of the parts, (...), to values, (n,).
    parts : (k, ...) array    Independent, of the same expectation; at least two.

    Returns
    -------
    values, errors : (n,) float64 array
    """
    parts = np.asarray(parts, dtype=np.float64)
    count, total = len(parts), parts.sum(axis=0)
    values = np.asarray(function(total / count), dtype=np.float64)
    without = np.array([function((total - part) / (count - 1)) for part in parts])
    return values, np.sqrt((count - 1) * without.var(axis=0))
