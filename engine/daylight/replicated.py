"""Standard errors of whatever is computed from noisy illuminances, by balanced replicates of them.

Illuminances are the mean of R independent replicates E_r. What is computed from them, f, is computed K times more, from

    E_k = mean + sum_r h_kr (E_r - mean) / sqrt(R (R - 1)),

where h holds signs whose columns are orthogonal (Hadamard). Each E_k lies about one standard error from the mean, in another
direction, and

    mean over k of (f(E_k) - f(mean))^2

is the square of the standard error of f: exactly that of `Estimate.from_groups` where f is linear, and to the leading order
where f bends. Shares of hours or of areas beyond a bound are steps; many of them add up to a slope, and so the rule holds
for them too, unless hardly any value is within a standard error of the bound. Then no E_k may cross it, and the error would
be 0: it is at least so large that the interval of 95 % reaches one step.

Causes of error that are no replicates, such as what a sky loses between its nodes, are columns of h like these: each with
the amount that it may change the illuminances by.

References
----------
P. J. McCarthy: Pseudo-replication: half samples, Review of the International Statistical Institute 37(3), 1969, 239-264
J. Shao, C. F. J. Wu: Asymptotic properties of the balanced repeated replication method for sample quantiles, The Annals of
Statistics 20(3), 1992, 1571-1593, doi:10.1214/aos/1176348785
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ..accuracy.student import t_quantile
from ..errors import SceneError

PROBABILITY = 0.95
"""Of intervals. [-]"""


@dataclass(frozen=True, eq=False)
class MetricEstimate:
    """What was computed, with its standard error.

    Parameters
    ----------
    value, standard_error : array    Of one shape; scalars have the shape (). The figure's unit.
    freedom : float    Degrees of freedom of the errors; infinite where nothing is left to chance. [-]
    """

    value: np.ndarray
    standard_error: np.ndarray
    freedom: float

    @classmethod
    def exact(cls, value) -> "MetricEstimate":
        """Return a value that no chance is in."""
        value = np.asarray(value, dtype=np.float64)
        return cls(value, np.zeros_like(value), math.inf)

    def interval(self, probability: float = PROBABILITY) -> tuple[np.ndarray, np.ndarray]:
        """Return the ends of the interval that holds the true value with a probability."""
        reach = t_quantile(0.5 * (1.0 + probability), self.freedom) * self.standard_error
        return self.value - reach, self.value + reach


def balanced_signs(count: int) -> np.ndarray:
    """Return signs for replicates, whose columns are orthogonal.

    Parameters
    ----------
    count : int    Of the replicates, at least 2.

    Returns
    -------
    (K, count) array of -1 and 1    K is the least power of two of at least ``count``.
    """
    if count < 2:
        raise SceneError(f"{count} replicate tells nothing of an error, expected 2 at least")
    signs = np.ones((1, 1))
    while len(signs) < count:
        signs = np.block([[signs, signs], [signs, -signs]])
    return signs[:, :count]


def perturb(replicates) -> np.ndarray:
    """Return the mean of replicates, and below it what is balanced about it.

    Parameters
    ----------
    replicates : (R, ...) array    Independent estimates of the same, of equal worth.

    Returns
    -------
    (1 + K, ...) float64 array    The mean first.
    """
    replicates = np.asarray(replicates, dtype=np.float64)
    count = len(replicates)
    mean = replicates.mean(axis=0)
    signs = balanced_signs(count) / math.sqrt(count * (count - 1))
    return np.concatenate([mean[None], mean + np.tensordot(signs, replicates - mean, axes=1)])


def estimate(versions, freedom: float, step=0.0) -> MetricEstimate:
    """Return a figure with its standard error from its versions.

    Parameters
    ----------
    versions : (1 + K, ...) array    The figure of the mean, and those of what is balanced about it.
    freedom : float    Number of replicates less one. [-]
    step : float or array    Least amount by which the figure can differ, such as one hour of 3650; 0: any. The figure's
        unit.

    Raises
    ------
    SceneError    There is nothing but the mean, or no degree of freedom.
    """
    versions = np.asarray(versions, dtype=np.float64)
    if len(versions) < 2 or not freedom > 0.0:
        raise SceneError("the error of a figure needs replicates beside the mean, found none")
    value = versions[0]
    error = np.sqrt(((versions[1:] - value) ** 2).mean(axis=0))
    least = np.asarray(step) / t_quantile(0.5 * (1.0 + PROBABILITY), freedom)
    return MetricEstimate(value, np.maximum(error, least), freedom)


def with_error(
    metric: Callable[[np.ndarray], np.ndarray],
    mean: np.ndarray,
    replicates: Iterable[np.ndarray],
    freedom: float,
    step=0.0,
) -> MetricEstimate:
    """Return a figure of illuminances with its standard error.

    Parameters
    ----------
    metric : callable    From illuminances to a number or an array.
    mean : (sensors, hours) array    [lx]
    replicates : iterable of (sensors, hours) arrays    Balanced about the mean, as `perturb` makes them; one is kept at a
        time. [lx]
    freedom, step    As of `estimate`.
    """
    return estimate([metric(mean), *map(metric, replicates)], freedom, step)


def find_by_sensor(
    metrics: Mapping[str, Callable[[np.ndarray], np.ndarray]],
    blocks: Iterable[Iterable[np.ndarray]],
) -> dict[str, np.ndarray]:
    """Return figures of every sensor in all versions of a year, block by block of sensors.

    What is kept is a number for each sensor and version, so that years of any number of sensors can be judged; figures of
    the whole area are computed from these, version by version.

    Parameters
    ----------
    metrics : dict of callables    By name: from illuminances (sensors, hours) to (sensors,) or (sensors, n).
    blocks : iterable of iterables of (sensors, hours) arrays    For each block of sensors its versions, the mean first; one
        is kept at a time. [lx]

    Returns
    -------
    dict of (1 + K, sensors) or (1 + K, sensors, n) float64 arrays    To be given to `estimate`.

    Raises
    ------
    SceneError    There is no sensor, or blocks have different numbers of versions.
    """
    parts: dict[str, list[np.ndarray]] = {name: [] for name in metrics}
    for block in blocks:
        rows: dict[str, list[np.ndarray]] = {name: [] for name in metrics}
        for version in block:
            for name, metric in metrics.items():
                rows[name].append(np.asarray(metric(version), dtype=np.float64))
        for name, row in rows.items():
            parts[name].append(np.stack(row))
    if not all(parts.values()):
        raise SceneError("there is no sensor whose year can be judged")
    for arrays in parts.values():
        if len({len(array) for array in arrays}) > 1:
            raise SceneError("blocks of sensors have different numbers of replicates")
    return {name: np.concatenate(arrays, axis=1) for name, arrays in parts.items()}


def over_area(metric: Callable[[np.ndarray], float], versions, freedom, step=0.0) -> MetricEstimate:
    """Return a figure of all sensors together with its standard error.

    Parameters
    ----------
    metric : callable    From the sensors' figures (sensors,) or (sensors, n) to a number or an array.
    versions : (1 + K, sensors) or (1 + K, sensors, n) array    As of `find_by_sensor`.
    freedom, step    As of `estimate`.
    """
    return estimate([metric(version) for version in versions], freedom, step)
