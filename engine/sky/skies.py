"""Skies by formula, whichever it is: what they are checked for, their luminances, and the integrals over them.

All state the illuminance of a horizontal plane, which their pattern is brought to; the sun itself is a light of its own.
"""

from dataclasses import replace

import numpy as np

from ..errors import SceneError
from ..scene.light import CieSky, CloudySky, FormulaSky, PerezSky
from . import cie, perez
from .pattern import Pattern, evaluate, integrate


def check_sky(sky: FormulaSky) -> None:
    """Refuse a sky that is none.

    Raises
    ------
    SceneError    Names what is wrong.
    """
    if not (np.isfinite(sky.illuminance) and sky.illuminance >= 0.0):
        raise SceneError(
            f"the sky's horizontal illuminance is {sky.illuminance} lx, expected a number of at least 0"
        )
    if not 0.0 <= sky.ground_reflectance <= 1.0:
        raise SceneError(
            f"the reflectance of the ground is {sky.ground_reflectance}, expected 0 to 1"
        )
    towards = np.asarray(sky.towards_sun, dtype=np.float64)
    if towards.shape != (3,) or not np.isfinite(towards).all() or not np.linalg.norm(towards) > 0.0:
        raise SceneError(f"the direction to the sun is not usable: {sky.towards_sun}")
    match sky:
        case CieSky():
            cie.check_type(sky.type)
        case CloudySky():
            cie.check_cloudiness(sky.cloudiness)
        case PerezSky():
            perez.check_numbers(sky)
    if not integrate(pattern_of(sky), weigh=True) > 0.0:
        raise SceneError(
            "the formula of the sky gives no light from any direction, as its numbers are none of real weather"
        )


def pattern_of(sky: FormulaSky) -> Pattern:
    """Return the luminances of a sky up to a factor."""
    match sky:
        case CieSky():
            return cie.pattern_of_type(sky.type, sky.towards_sun)
        case CloudySky():
            return cie.pattern_of_cloudiness(sky.cloudiness, sky.towards_sun)
    return perez.pattern_of(sky)


def luminance_scale(sky: FormulaSky) -> float:
    """Return what the pattern has to be multiplied by. [cd/m2]"""
    return sky.illuminance / integrate(pattern_of(sky), weigh=True)


def zenith_luminance(sky: FormulaSky) -> float:
    """Luminance of the zenith. [cd/m2]"""
    return luminance_scale(sky) * float(evaluate(pattern_of(sky), (0.0, 0.0, 1.0)))


def with_zenith_luminance(sky: FormulaSky, luminance: float) -> FormulaSky:
    """Return a sky with the illuminance that its zenith's luminance stands for.

    Parameters
    ----------
    sky : FormulaSky    Its own illuminance does not count.
    luminance : float    [cd/m2]

    Raises
    ------
    SceneError    The sky is dark at the zenith, whatever its illuminance.
    """
    pattern = pattern_of(sky)
    zenith = float(evaluate(pattern, (0.0, 0.0, 1.0)))
    if not zenith > 0.0:
        raise SceneError(
            "the sky is dark at its zenith, so that no luminance there tells its light"
        )
    return replace(sky, illuminance=luminance * integrate(pattern, weigh=True) / zenith)


def ground_luminance(sky: FormulaSky) -> float:
    """Luminance of every direction below the horizon. [cd/m2]"""
    return sky.ground_reflectance * sky.illuminance / np.pi


def find_luminances(sky: FormulaSky, directions) -> np.ndarray:
    """Return the luminance of directions.

    Parameters
    ----------
    sky : FormulaSky
    directions : (..., 3) array    Unit vectors, +z up.

    Returns
    -------
    (...) array    [cd/m2]
    """
    directions = np.asarray(directions, dtype=np.float64)
    above = luminance_scale(sky) * evaluate(pattern_of(sky), directions)
    return np.where(directions[..., 2] >= 0.0, above, ground_luminance(sky))


def mean_luminance(sky: FormulaSky) -> float:
    """Mean over all directions, ground included. [cd/m2]"""
    above = luminance_scale(sky) * integrate(pattern_of(sky), weigh=False)
    return (above + 2.0 * np.pi * ground_luminance(sky)) / (4.0 * np.pi)
