"""Luminance distributions of the CIE: the fifteen standard general skies, the traditional overcast sky, and mixtures.

References
----------
CIE S 011/E:2003 (ISO 15469:2004), Spatial distribution of daylight - CIE standard general sky; type 16 here is its
clause on the traditional overcast sky (P. Moon, D. E. Spencer, 1942).
CIE S 003/E:1996 (ISO 15469:1997), Spatial distribution of daylight - CIE standard overcast sky and clear sky
"""

from dataclasses import replace

import numpy as np

from ..errors import SceneError
from .pattern import FINEST, Pattern, evaluate, integrate, unit

COEFFICIENTS = {
    1: (4.0, -0.70, 0.0, -1.0, 0.00),
    2: (4.0, -0.70, 2.0, -1.5, 0.15),
    3: (1.1, -0.80, 0.0, -1.0, 0.00),
    4: (1.1, -0.80, 2.0, -1.5, 0.15),
    5: (0.0, -1.00, 0.0, -1.0, 0.00),
    6: (0.0, -1.00, 2.0, -1.5, 0.15),
    7: (0.0, -1.00, 5.0, -2.5, 0.30),
    8: (0.0, -1.00, 10.0, -3.0, 0.45),
    9: (-1.0, -0.55, 2.0, -1.5, 0.15),
    10: (-1.0, -0.55, 5.0, -2.5, 0.30),
    11: (-1.0, -0.55, 10.0, -3.0, 0.45),
    12: (-1.0, -0.32, 10.0, -3.0, 0.45),
    13: (-1.0, -0.32, 16.0, -3.0, 0.30),
    14: (-1.0, -0.15, 16.0, -3.0, 0.30),
    15: (-1.0, -0.15, 24.0, -2.8, 0.15),
}
"""Gradation a, b and indicatrix c, d, e by type (CIE S 011/E:2003, table 1)."""

OVERCAST = 16
"""Number of the traditional overcast sky."""

CLEAR = 12
"""Number of the standard clear sky, which is that of CIE S 003 too."""


def check_type(kind: int) -> None:
    """Refuse a number that no sky has.

    Raises
    ------
    SceneError    Says which there are.
    """
    if kind not in range(1, OVERCAST + 1):
        raise SceneError(f"the sky's type is {kind}, expected 1 to 15, or 16 for overcast")


def check_cloudiness(cloudiness: float) -> None:
    """Refuse a cloudiness that is none.

    Raises
    ------
    SceneError    It is beyond 0 to 1.
    """
    if not 0.0 <= cloudiness <= 1.0:
        raise SceneError(f"the sky's cloudiness is {cloudiness}, expected 0 to 1")


def sun_direction(elevation: float, azimuth: float) -> np.ndarray:
    """Unit vector to the sun. [rad] ``azimuth``: from +y (north) towards +x (east), the way a compass turns."""
    return np.array(
        [
            np.sin(azimuth) * np.cos(elevation),
            np.cos(azimuth) * np.cos(elevation),
            np.sin(elevation),
        ]
    )


def gradation(kind: int, sine: np.ndarray) -> np.ndarray:
    """phi(Z) of types 1 to 15. ``sine``: of the elevation, 0 to 1. [-]"""
    a, b = COEFFICIENTS[kind][:2]
    sine = np.asarray(sine, dtype=np.float64)
    return 1.0 + a * np.exp(b / np.maximum(sine, 1e-12))


def indicatrix(kind: int, angle: np.ndarray) -> np.ndarray:
    """f(chi) of types 1 to 15. ``angle``: to the sun. [rad -> -]"""
    c, d, e = COEFFICIENTS[kind][2:]
    return 1.0 + c * (np.exp(d * angle) - np.exp(0.5 * d * np.pi)) + e * np.cos(angle) ** 2


def pattern_of_type(kind: int, towards_sun) -> Pattern:
    """Return the luminance over that of the zenith, as a pattern. ``towards_sun``: (3,), any length above 0."""
    sun = unit(towards_sun)
    if kind == OVERCAST:
        return Pattern(0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0 / 3.0, 2.0 / 3.0, FINEST, sun)
    a, b, c, d, e = COEFFICIENTS[kind]
    at_zenith = np.arccos(np.clip(sun[2], -1.0, 1.0))
    level = float(1.0 / (gradation(kind, 1.0) * indicatrix(kind, at_zenith)))
    edge = float(np.exp(0.5 * d * np.pi))
    return Pattern(a, b, c, d, e, edge, level, 0.0, 0.0, FINEST, sun)


def pattern_of_cloudiness(cloudiness: float, towards_sun) -> Pattern:
    """Return the mixture of the clear and the overcast sky of CIE S 003, for a horizontal illuminance of 1 lx.

    Parameters
    ----------
    cloudiness : float    Part of the horizontal illuminance that the overcast sky gives, 0 to 1. [-]
    towards_sun : (3,) array    Any length above 0.

    Returns
    -------
    Pattern    [cd/m2]
    """
    clear, overcast = (pattern_of_type(kind, towards_sun) for kind in (CLEAR, OVERCAST))
    of_clear = (1.0 - cloudiness) / integrate(clear, weigh=True)
    of_overcast = cloudiness / integrate(overcast, weigh=True)
    return replace(
        clear,
        level=clear.level * of_clear,
        base=overcast.base * of_overcast,
        rise=overcast.rise * of_overcast,
    )


def relative_luminance(kind: int, directions, towards_sun) -> np.ndarray:
    """Luminance over that of the zenith.

    Parameters
    ----------
    kind : int    1 to 16.
    directions : (..., 3) array    Unit vectors, +z up.
    towards_sun : (3,) array    Any length above 0.

    Returns
    -------
    (...) float64 array    0 below the horizon. [-]
    """
    return evaluate(pattern_of_type(kind, towards_sun), directions)


def horizontal_ratio(kind: int, towards_sun) -> float:
    """Horizontal illuminance of the sky over its zenith luminance, to about 1e-7. [sr]"""
    return integrate(pattern_of_type(kind, towards_sun), weigh=True)
