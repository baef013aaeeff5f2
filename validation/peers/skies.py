"""Luminance of skies by formula for the peers, kept apart from the engine's so that a mistake there shows."""

import numpy as np

from lumenray.engine.scene.light import CieSky, CloudySky, FormulaSky, PerezSky

from ..sky_formulas import HORIZON, perez_letters

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

CLEAR = 12
"""The clear sky that cloudiness begins with."""

_STEPS = 720
"""Midpoints of the quadrature over elevation; twice as many around."""


def parts_of(sky: FormulaSky) -> list[tuple[float, FormulaSky]]:
    """Skies that a sky is a mixture of, with what the luminance of each counts."""
    if not isinstance(sky, CloudySky):
        return [(1.0, sky)]
    clear, overcast = (CieSky(kind, sky.towards_sun, 1.0) for kind in (CLEAR, OVERCAST))
    shares = (1.0 - sky.cloudiness, clear), (sky.cloudiness, overcast)
    return [(share * luminance_scale(part), part) for share, part in shares]


def letters_of(sky: CieSky | PerezSky) -> tuple[float, ...]:
    """Coefficients a to e, what is taken off the exponential, and the sine below which the gradation is even."""
    if isinstance(sky, PerezSky):
        elevation = float(np.degrees(np.arcsin(unit_sun(sky)[2])))
        return *perez_letters(sky.clearness, sky.brightness, elevation), 0.0, HORIZON
    letters = PARAMETERS[sky.type]
    return *letters, float(np.exp(letters[3] * np.pi / 2.0)), 1e-9


def relative_luminance(sky: FormulaSky, directions: np.ndarray) -> np.ndarray:
    """Luminance over an unstated unit, of directions (..., 3) above the horizon."""
    if isinstance(sky, CloudySky):
        return sum(share * relative_luminance(part, directions) for share, part in parts_of(sky))
    if isinstance(sky, CieSky) and sky.type == OVERCAST:
        return (1.0 + 2.0 * np.maximum(directions[..., 2], 0.0)) / 3.0
    a, b, c, d, e, edge, floor = letters_of(sky)
    cosine = np.clip(directions @ unit_sun(sky), -1.0, 1.0)
    scattered = c * (np.exp(d * np.arccos(cosine)) - edge) + e * cosine**2
    return (1.0 + a * np.exp(b / np.maximum(directions[..., 2], floor))) * (1.0 + scattered)


def unit_sun(sky: FormulaSky) -> np.ndarray:
    """Unit vector to the sun."""
    sun = np.asarray(sky.towards_sun, dtype=np.float64)
    return sun / np.linalg.norm(sun)


def luminance_scale(sky: FormulaSky) -> float:
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


def ground_luminance(sky: FormulaSky) -> float:
    """Of every direction below the horizon. [cd/m2]"""
    return float(sky.ground_reflectance * sky.illuminance / np.pi)
