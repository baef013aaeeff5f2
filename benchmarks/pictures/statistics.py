"""Statistics of the benchmark of pictures: true errors without a converged picture, times to an error, bias by blocks."""

import math
from dataclasses import dataclass

import numpy as np

from ...engine.accuracy.student import t_quantile
from ..common.statistics import Reach

TARGETS = (0.10, 0.05, 0.02)
"""Relative errors of a pixel to which programs race. [-]"""

BASE = 4
"""Last runs from which it is read how the error goes on."""

COARSEST = 2.0 * max(TARGETS)
"""Error above which a run tells neither that nor whether stated errors are true: a bright stray pixel counts by its own
luminance, so that large errors fall more slowly than by the power of the samples. [-]"""

STEEPEST, FLATTEST = -0.75, -0.1
"""Exponents of the error in the samples that are believed beyond the runs; a flatter one has come to the end of what it can
do."""

INDEPENDENT, UNSURE = -0.5, 0.1
"""Exponent of independent paths, which is taken where too few runs are fine enough to tell theirs, or where they scatter so
much that it has a larger standard error."""

MOST = 4.0
"""Square of the relative error for which a pixel counts at most: a reference has its own stray bright ones."""

BLOCK = 16
"""Side of the blocks in which bias is looked for. [pixel]"""

CONFIDENCE = 0.95
"""That nothing is called a bias which is none, in all blocks of a picture together."""


@dataclass(frozen=True, eq=False)
class Reference:
    """Mean of two independent pictures of a program, which tell its error by their difference.

    Parameters
    ----------
    first, second : (h, w) float array    Luminances. [cd/m2]
    """

    first: np.ndarray
    second: np.ndarray

    @property
    def luminance(self) -> np.ndarray:
        """Their mean, (h, w). [cd/m2]"""
        return 0.5 * (self.first.astype(np.float64) + self.second)

    @property
    def variance(self) -> float:
        """Square of its own relative error. [-]"""
        half = 0.5 * (self.first.astype(np.float64) - self.second)
        return float(((half * weights_of(self.luminance)) ** 2).mean())

    def variance_of(self, luminance: np.ndarray) -> float:
        """Square of the true relative error of an independent picture; by chance it may be below 0. [-]

        Both pictures are off by errors of their own, so the product of the two differences has the expectation of the
        square of the true error, whatever noise they have.
        """
        first, second = (luminance - each.astype(np.float64) for each in (self.first, self.second))
        shares = first * second * weights_of(luminance) ** 2
        return float(np.clip(shares, -MOST, MOST).mean())


def weights_of(luminance: np.ndarray) -> np.ndarray:
    """One over the larger of a pixel's own and the mean luminance, as in `picture.relative_error`. (h, w)"""
    return 1.0 / np.maximum(luminance, luminance.mean())


def error_of_pair(first: np.ndarray, second: np.ndarray) -> float:
    """Relative error of either of two pictures of equal work, by their difference. [-]"""
    return math.sqrt(2.0 * Reference(first, second).variance)


def seconds_to(samples, seconds, errors, target: float) -> Reach:
    """Time to a relative error: between runs, or beyond them by the power law of the last ones and the time of a sample.

    Parameters
    ----------
    samples, seconds, errors : sequence of float    Of runs with more and more work.
    target : float
    """
    samples, seconds, errors = (
        np.asarray(each, dtype=np.float64) for each in (samples, seconds, errors)
    )
    above = np.flatnonzero(errors > target)
    if len(above) == 0:
        return Reach(float(seconds[0]), "<")
    # A lucky run before a worse one does not count.
    last = int(above[-1])
    if last + 1 < len(errors):
        ends = slice(last, last + 2)
        x, y = np.log(seconds[ends]), np.log(np.maximum(errors[ends], 1e-12))
        share = (math.log(target) - y[0]) / (y[1] - y[0])
        return Reach(float(np.exp(x[0] + share * (x[1] - x[0]))))
    base = find_base(errors)
    power = power_of(samples[base], errors[base])
    if power > FLATTEST:
        return Reach(float(seconds[-1]), ">")
    power = max(power, STEEPEST)
    level = math.sqrt(np.mean((errors[base] / samples[base] ** power) ** 2))
    needed = max((target / level) ** (1.0 / power), samples[-1])
    further = (needed - samples[-1]) * _seconds_each(samples, seconds)
    return Reach(float(seconds[-1] + further), "", True)


def find_base(errors: np.ndarray) -> np.ndarray:
    """Indices of the runs by which the error goes on: the last ones that are fine enough, or the last one alone."""
    last = np.arange(max(len(errors) - BASE, 0), len(errors))
    fine = last[errors[last] <= COARSEST]
    return fine if len(fine) else last[-1:]


def power_of(samples: np.ndarray, errors: np.ndarray) -> float:
    """Exponent of the error in the samples by some runs. [-]"""
    if len(samples) < 3:
        return INDEPENDENT
    x, y = np.log(samples), np.log(errors)
    x = x - x.mean()
    power = float(x @ y / (x @ x))
    rest = y - y.mean() - power * x
    error = math.sqrt(rest @ rest / (len(x) - 2) / (x @ x))
    return INDEPENDENT if error > UNSURE else power


def _seconds_each(samples: np.ndarray, seconds: np.ndarray) -> float:
    """Time of one further sample: what is learned once is no part of it. [s]"""
    if len(samples) < 2:
        return float(seconds[-1] / samples[-1])
    fitted = float(np.polyfit(samples[-BASE:], seconds[-BASE:], 1)[0])
    return fitted if fitted > 0.0 else float(seconds[-1] / samples[-1])


def block_means(luminance: np.ndarray) -> np.ndarray:
    """Means of whole blocks of (h, w) pixels, or of (n, h, w) pictures; what is left at the edges is left out."""
    *rest, height, width = luminance.shape
    rows, columns = height // BLOCK, width // BLOCK
    cut = luminance[..., : rows * BLOCK, : columns * BLOCK].astype(np.float64)
    return cut.reshape(*rest, rows, BLOCK, columns, BLOCK).mean(axis=(-3, -1))


def find_bias(ours: np.ndarray, plain: np.ndarray) -> dict:
    """Compare block means of pictures of two methods with several seeds each.

    Parameters
    ----------
    ours, plain : (n, h, w) array    Luminances. [cd/m2]

    Returns
    -------
    dict    All over the mean luminance [%]: ``mean``: difference of the whole, ``mean_interval``: half of its interval of
        95 %; ``noise``: root mean square of the standard errors of the blocks' differences, ``spread``: of the differences
        beyond that; ``largest``: largest difference of a block, ``interval``: half of the interval that holds for all
        blocks at once, median of the blocks; ``worst``: largest difference beyond its block's interval, 0 where none is;
        and ``seeds``, ``blocks``: how many.
    """
    count = len(ours)

    def differ(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        error = np.sqrt((a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / count)
        return a.mean(axis=0) - b.mean(axis=0), error

    return _judge(ours, plain, differ, 2 * (count - 1))


def find_moved(shared: np.ndarray, own: np.ndarray) -> dict:
    """Compare block means of pictures of the same samples with and without something; as `find_bias`.

    What the samples have by chance both have, so that smaller differences are found.
    """
    count = len(own)

    def differ(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (a - b).mean(axis=0), (a - b).std(axis=0, ddof=1) / math.sqrt(count)

    return _judge(shared, own, differ, count - 1)


def _judge(first: np.ndarray, second: np.ndarray, differ, freedom: int) -> dict:
    """What `find_bias` returns; ``differ(a, b)``: mean differences and their standard errors, of ``freedom`` degrees."""
    level = 100.0 / float(second.mean())
    difference, error = (level * each for each in differ(block_means(first), block_means(second)))
    wholes = (each.mean(axis=(1, 2), dtype=np.float64) for each in (first, second))
    whole, whole_error = (level * each for each in differ(*wholes))
    # By Bonferroni for all blocks at once.
    each = t_quantile(1.0 - 0.5 * (1.0 - CONFIDENCE) / difference.size, freedom)
    noise = float((error**2).mean())
    return {
        "seeds": len(second),
        "blocks": int(difference.size),
        "mean": float(whole),
        "mean_interval": float(t_quantile(0.5 + 0.5 * CONFIDENCE, freedom) * whole_error),
        "noise": math.sqrt(noise),
        "spread": math.sqrt(max(float((difference**2).mean()) - noise, 0.0)),
        "largest": float(np.abs(difference).max()),
        "interval": float(each * np.median(error)),
        "worst": float(np.maximum(np.abs(difference) - each * error, 0.0).max()),
    }
