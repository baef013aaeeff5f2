"""Daylight factors: what sensors have under an overcast sky, of what a horizontal plane in the open has.

References
----------
CIE S 011 / ISO 15469:2004, type 16, the traditional overcast sky
"""

import numpy as np

from ..sky.cie import OVERCAST, pattern_of_type
from ..sky.nodes import find_projection
from ..sky.pattern import evaluate
from .coefficients import DaylightCoefficients
from .replicated import balanced_signs

ZENITH = (0.0, 0.0, 1.0)


def find_factors(
    coefficients: DaylightCoefficients, ground_reflectance: float = 0.2, sky_type: int = OVERCAST
) -> np.ndarray:
    """Return daylight factors and what is balanced about them.

    Parameters
    ----------
    coefficients : DaylightCoefficients
    ground_reflectance : float    Of the ground around, which sensors see below the horizon. [-]
    sky_type : int    Of a sky that is the same all around.

    Returns
    -------
    (1 + K, n) float64 array    The mean first, as of `replicated.perturb`. [-]
    """
    projection = find_projection(coefficients.steps)
    pattern = pattern_of_type(sky_type, ZENITH)
    luminances = evaluate(pattern, projection.directions)
    luminances /= (luminances * projection.areas) @ projection.directions[:, 2]
    best, means = projection.project(luminances[None].astype(np.float32))
    sky = np.append(best[0], ground_reflectance / np.pi)
    found = coefficients.sky @ sky
    count = len(found)
    mean = found.mean(axis=0, dtype=np.float64)
    doubt = coefficients.sky[..., :-1].mean(axis=0) @ (0.5 * (best - means)[0])
    causes = [*((found - mean) / np.sqrt(count * (count - 1))), doubt, coefficients.reading * mean]
    return np.concatenate([mean[None], mean + balanced_signs(len(causes)) @ np.stack(causes)])
