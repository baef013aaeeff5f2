"""What maps lack because samples were no numbers."""

from dataclasses import replace

import numpy as np

from ..accuracy.lost_samples import find_missing
from .estimates import Estimates
from .layer_state import LayerState
from .means import ObjectMean


def hold_lost_light(
    states: list[LayerState], estimates: Estimates, means: list[ObjectMean], floors: np.ndarray
) -> tuple[Estimates, np.ndarray]:
    """Let the errors of lumels and of the means of maps hold what they may lack. Lumels are widened by what they lost alone.

    Parameters
    ----------
    states : list of LayerState
    estimates : Estimates
    means : list of ObjectMean
    floors : (m,) array    What the error of each mean must be at least by others. [lx]

    Returns
    -------
    (Estimates, (m,) array)    The same with what is lost.
    """
    for state in states:
        if not state.losses.any:
            continue
        light, error = state.sums.mean(), estimates.standard_error.copy()
        shares = state.losses.shares_of(state.sums.samples())
        missing = np.zeros(len(means))
        area = sum(float(each.areas.sum()) for each in means)
        whole = sum(float(each.areas @ light[each.rows]) for each in means) / max(area, 1e-300)
        for each in means:
            lacks, missing[each.number] = _find_missing(each, light, shares, whole)
            error[each.rows] = np.hypot(error[each.rows], lacks.astype(np.float32))
        estimates = replace(estimates, standard_error=error)
        floors = np.hypot(floors, missing)
    return estimates, floors


def _find_missing(own: ObjectMean, light, shares, whole: float) -> tuple[np.ndarray, float]:
    """What the lumels of a map lack, and its mean. ((k,), float) [lx]

    The brightest lumel stands for those of which nothing is left, the mean of the ``whole`` for a map that is dark.
    """
    light, shares, total = light[own.rows], shares[own.rows], max(float(own.areas.sum()), 1e-300)
    mean = float(own.areas @ light) / total or whole
    lacks = find_missing(light, shares, mean)
    lost = float(find_missing(mean, own.areas @ shares / total))
    if np.isfinite(lost):
        lacks = np.where(np.isfinite(lacks), lacks, light.max(initial=mean))
        lost = max(lost, float(own.areas @ lacks) / total)
    return lacks, lost
