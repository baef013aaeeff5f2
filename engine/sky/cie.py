"""Luminance distributions of the CIE: the fifteen standard general skies and the traditional overcast sky.

References
----------
CIE S 011/E:2003 (ISO 15469:2004), Spatial distribution of daylight - CIE standard general sky; type 16 here is its
clause on the traditional overcast sky (P. Moon, D. E. Spencer, 1942).
"""

from functools import lru_cache

import numpy as np

from ..errors import SceneError
from ..scene.light import CieSky

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


def check_sky(sky: CieSky) -> None:
    """Refuse a sky that is none.

    Raises
    ------
    SceneError    Names what is wrong.
    """
    if sky.type not in range(1, OVERCAST + 1):
        raise SceneError(f"the sky's type is {sky.type}, expected 1 to 15, or 16 for overcast")
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
    directions = np.asarray(directions, dtype=np.float64)
    sine = directions[..., 2]
    if kind == OVERCAST:
        return np.where(sine >= 0.0, (1.0 + 2.0 * sine) / 3.0, 0.0)
    sun = np.asarray(towards_sun, dtype=np.float64)
    sun = sun / np.linalg.norm(sun)
    # By the chord: an arc cosine loses half of its digits next to the sun.
    angle = 2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(directions - sun, axis=-1), 1.0))
    zenith = gradation(kind, 1.0) * indicatrix(kind, np.arccos(np.clip(sun[2], -1.0, 1.0)))
    value = gradation(kind, np.maximum(sine, 0.0)) * indicatrix(kind, angle) / zenith
    return np.where(sine >= 0.0, value, 0.0)


def horizontal_ratio(kind: int, towards_sun) -> float:
    """Horizontal illuminance of the sky over its zenith luminance, to about 1e-7. [sr]"""
    return _integral(kind, _key(towards_sun), True)


def total_ratio(kind: int, towards_sun) -> float:
    """Integral of the luminance over the sky's solid angle, over the zenith luminance. [sr]"""
    return _integral(kind, _key(towards_sun), False)


def zenith_luminance(sky: CieSky) -> float:
    """Luminance of the zenith. [cd/m2]"""
    return sky.illuminance / horizontal_ratio(sky.type, sky.towards_sun)


def ground_luminance(sky: CieSky) -> float:
    """Luminance of every direction below the horizon. [cd/m2]"""
    return sky.ground_reflectance * sky.illuminance / np.pi


def mean_luminance(sky: CieSky) -> float:
    """Mean over all directions, ground included. [cd/m2]"""
    above = zenith_luminance(sky) * total_ratio(sky.type, sky.towards_sun)
    return (above + 2.0 * np.pi * ground_luminance(sky)) / (4.0 * np.pi)


def _key(towards_sun) -> tuple[float, float]:
    """All that an integral over the sky depends on: the sun's height, by sine and length of the vector's plan."""
    sun = np.asarray(towards_sun, dtype=np.float64)
    sun = sun / np.linalg.norm(sun)
    return float(np.hypot(sun[0], sun[1])), float(sun[2])


@lru_cache(maxsize=256)
def _integral(kind: int, sun: tuple[float, float], weigh: bool) -> float:
    """Gauss sums over zenith angle and azimuth, in panels that end at the sun, where the luminance has a cusp."""
    nodes, weights = np.polynomial.legendre.leggauss(96)
    height = float(np.arcsin(np.clip(sun[1], -1.0, 1.0)))
    split = min(max(height, 0.0), 0.5 * np.pi)
    # Graded towards the sun from both sides, and towards the horizon, where exp(b / sine) bends.
    elevation, area = [], []
    for low, high, end in ((0.0, split, 1), (split, 0.5 * np.pi, 0)):
        if high - low < 1e-12:
            continue
        t = 0.5 * (nodes + 1.0)
        share = 1.0 - (1.0 - t) ** 3 if end else t**3
        slope = 3.0 * (1.0 - t) ** 2 if end else 3.0 * t**2
        elevation.append(low + (high - low) * share)
        area.append(0.5 * weights * (high - low) * slope)
    elevation, area = np.concatenate(elevation), np.concatenate(area)
    t = 0.5 * (nodes + 1.0)
    azimuth, width = np.pi * t**3, 0.5 * weights * np.pi * 3.0 * t**2
    sine, cosine = np.sin(elevation)[:, None], np.cos(elevation)[:, None]
    directions = np.stack(
        np.broadcast_arrays(cosine * np.cos(azimuth), cosine * np.sin(azimuth), sine), axis=-1
    )
    value = relative_luminance(kind, directions, (sun[0], 0.0, sun[1]))
    value = value * cosine * (sine if weigh else 1.0)
    return float(2.0 * area @ value @ width)
