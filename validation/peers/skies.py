"""Luminance of the CIE's skies for the peers, kept apart from the engine's so that a mistake there shows."""

import numpy as np
from lumenray.engine.scene.light import CieSky

PARAMETERS = {
    1: (4.0, -0.7, 0.0, -1.0, 0.0),
    2: (4.0, -0.7, 2.0, -1.5, 0.15),
    3: (1.1, -0.8, 0.0, -1.0, 0.0),
    4: (1.1, -0.8, 2.0, -1.5, 0.15),
    5: (0.0, -1.0, 0.0, -1.0, 0.0),
    6: (0.0, -1.0, 2.0, -1.5, 0.15),
    7: (0.0, -1.0, 5.0, -2.5, 0.3),
    8: (0.0, -1.0, 10.0, -3.0, 0.45),
    9: (-1.0, -0.55, 2.0, -1.5, 0.15),
    10: (-1.0, -0.55, 5.0, -2.5, 0.3),
    11: (-1.0, -0.55, 10.0, -3.0, 0.45),
    12: (-1.0, -0.32, 10.0, -3.0, 0.45),
    13: (-1.0, -0.32, 16.0, -3.0, 0.3),
    14: (-1.0, -0.15, 16.0, -3.0, 0.3),
    15: (-1.0, -0.15, 24.0, -2.8, 0.15),
}
"""a, b, c, d, e of the standard general skies by type (CIE S 011/E:2003, table 1)."""

OVERCAST = 16
"""The traditional overcast sky, L = L_z (1 + 2 sin(elevation)) / 3."""

_STEPS = 720
"""Midpoints of the quadrature over elevation; twice as many around."""


def relative_luminance(sky: CieSky, directions: np.ndarray) -> np.ndarray:
    """Luminance over an unstated unit, of directions (..., 3) above the horizon."""
    height = np.maximum(directions[..., 2], 1e-9)
    if sky.type == OVERCAST:
        return (1.0 + 2.0 * height) / 3.0
    a, b, c, d, e = PARAMETERS[sky.type]
    cosine = np.clip(directions @ unit_sun(sky), -1.0, 1.0)
    scattered = c * (np.exp(d * np.arccos(cosine)) - np.exp(d * np.pi / 2.0)) + e * cosine**2
    return (1.0 + a * np.exp(b / height)) * (1.0 + scattered)


def unit_sun(sky: CieSky) -> np.ndarray:
    """Unit vector to the sun."""
    sun = np.asarray(sky.towards_sun, dtype=np.float64)
    return sun / np.linalg.norm(sun)


def luminance_scale(sky: CieSky) -> float:
    """Luminance of what `relative_luminance` calls 1. [cd/m2]"""
    # Midpoints in sin^2 of the elevation weigh by the cosine to the zenith.
    square = (np.arange(_STEPS) + 0.5) / _STEPS
    around = 2.0 * np.pi * (np.arange(2 * _STEPS) + 0.5) / (2 * _STEPS)
    up, out = np.sqrt(square)[:, None], np.sqrt(1.0 - square)[:, None]
    directions = np.stack(
        [out * np.cos(around), out * np.sin(around), np.broadcast_to(up, (_STEPS, 2 * _STEPS))],
        axis=-1,
    )
    return float(sky.illuminance / (np.pi * relative_luminance(sky, directions).mean()))


def ground_luminance(sky: CieSky) -> float:
    """Of every direction below the horizon. [cd/m2]"""
    return float(sky.ground_reflectance * sky.illuminance / np.pi)
