"""Time in which a program comes to an error, from runs with more and more work.

A run takes a time that does not depend on the work and one that grows with it; its noise falls with the root of the work,
and what the method leaves out stays. So seconds are s0 + s1 w, and the square of the error is a + b / w, with numbers that
fit the runs best. Curves of the error over the time alone would take what a run costs at least for speed.
"""

import numpy as np

from ..common.statistics import Reach, seconds_to


def find_reach(work, seconds, errors, target: float, has_floor: bool) -> Reach | None:
    """Return the time to an error; None: the runs come down to more than it.

    Parameters
    ----------
    work, seconds, errors : sequence of float    Of runs, with ascending work; two at least.
    target : float    [-]
    has_floor : bool    Whether something may be left out, so that the error does not fall to 0.
    """
    work, seconds, errors = (np.asarray(x, dtype=np.float64) for x in (work, seconds, errors))
    if (errors <= target).any():
        return seconds_to(list(zip(seconds, errors, strict=True)), target)
    floor, slope = _fit_error(work, errors, has_floor)
    if floor >= target**2:
        return None
    wanted = slope / (target**2 - floor)
    rate, start = np.polyfit(work, seconds, 1)
    # Two runs that take the same time tell of no rate; the longest is a bound then.
    return Reach(float(max(start + rate * wanted, seconds.max())), "", True)


def _fit_error(work, errors, has_floor: bool) -> tuple[float, float]:
    """Numbers a and b of error^2 = a + b / work, by least squares of relative differences."""
    square = errors**2
    if has_floor:
        design = np.stack([1.0 / square, 1.0 / (work * square)], axis=1)
        (floor, slope), *_ = np.linalg.lstsq(design, np.ones(len(work)), rcond=None)
        if slope <= 0.0:
            return float(square.min()), 0.0
        if floor > 0.0:
            return float(floor), float(slope)
    inverse = 1.0 / (work * square)
    return 0.0, float(inverse.sum() / (inverse**2).sum())
