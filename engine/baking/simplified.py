"""What maps may be off by because the scene was simplified."""

from dataclasses import replace

import numpy as np

from .estimates import Estimates
from .means import ObjectMean


def hold_simplifications(
    estimates: Estimates, means: list[ObjectMean], floors: np.ndarray, bound: float
) -> tuple[Estimates, np.ndarray]:
    """Let the errors of lumels and of the means of maps hold the share ``bound`` of their light. [-]

    Parameters
    ----------
    floors : (m,) array    What the error of each mean must be at least by others. [lx]
    """
    if not bound:
        return estimates, floors
    error = np.hypot(estimates.standard_error, np.float32(bound) * estimates.illuminance)
    own = np.array([each.mean for each in means])
    return replace(estimates, standard_error=error), np.hypot(floors, bound * own)
