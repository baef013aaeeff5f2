"""The one shape that all skies by formula have, so that they are the same code on the device and differ by numbers alone.

With the sine s of the elevation and the angle chi to the sun a pattern is

    level (1 + a exp(b / max(s, floor))) (1 + c (exp(d chi) - edge) + e cos^2 chi) + base + rise s

and 0 where that is negative. It means nothing below the horizon.
"""

from dataclasses import astuple, dataclass, replace
from functools import lru_cache

import numpy as np

FINEST = 1e-6
"""Least ``floor``: single precision has no finer sine of an elevation that counts."""


@dataclass(frozen=True)
class Pattern:
    """Luminance by direction, up to a factor.

    Parameters
    ----------
    a, b : float    Gradation. [-]
    c, d, e, edge : float    Scattering about the sun. [-]
    level, base, rise : float    [any unit of luminance]
    floor : float    Sine of the elevation below which the gradation is even. [-]
    sun : (float, float, float)    Unit vector to the sun.
    """

    a: float
    b: float
    c: float
    d: float
    e: float
    edge: float
    level: float
    base: float
    rise: float
    floor: float
    sun: tuple[float, float, float]

    @property
    def numbers(self) -> tuple[float, ...]:
        """All but the sun, in their order."""
        return astuple(self)[:-1]


def unit(direction) -> tuple[float, float, float]:
    """Return a direction of any length as a unit vector."""
    direction = np.asarray(direction, dtype=np.float64)
    return tuple(map(float, direction / np.linalg.norm(direction)))


def evaluate(pattern: Pattern, directions) -> np.ndarray:
    """Return a pattern's value.

    Parameters
    ----------
    pattern : Pattern
    directions : (..., 3) array    Unit vectors, +z up.

    Returns
    -------
    (...) float64 array    0 below the horizon.
    """
    directions = np.asarray(directions, dtype=np.float64)
    sine = directions[..., 2]
    a, b, c, d, e, edge, level, base, rise, floor = pattern.numbers
    # By the chord: an arc cosine loses half of its digits next to the sun.
    half = np.minimum(0.5 * np.linalg.norm(directions - np.array(pattern.sun), axis=-1), 1.0)
    angle, cosine = 2.0 * np.arcsin(half), 1.0 - 2.0 * half**2
    height = np.maximum(sine, 0.0)
    gradation = 1.0 + a * np.exp(b / np.maximum(height, floor))
    scattering = 1.0 + c * (np.exp(d * angle) - edge) + e * cosine**2
    value = level * gradation * scattering + base + rise * height
    return np.where(sine >= 0.0, np.maximum(value, 0.0), 0.0)


def evaluate_all(patterns, directions) -> np.ndarray:
    """Return the values of many patterns in directions; as `evaluate`. n patterns, (q, 3) -> (n, q)"""
    directions = np.asarray(directions, dtype=np.float64)
    sine = directions[:, 2]
    a, b, c, d, e, edge, level, base, rise, floor = (
        np.array(column)[:, None] for column in zip(*(p.numbers for p in patterns), strict=True)
    )
    suns = np.array([pattern.sun for pattern in patterns])
    half = np.sqrt(np.clip(0.5 - 0.5 * suns @ directions.T, 0.0, 1.0))
    angle, cosine = 2.0 * np.arcsin(half), 1.0 - 2.0 * half**2
    height = np.maximum(sine, 0.0)
    gradation = 1.0 + a * np.exp(b / np.maximum(height, floor))
    scattering = 1.0 + c * (np.exp(d * angle) - edge) + e * cosine**2
    value = level * gradation * scattering + base + rise * height
    return np.where(sine >= 0.0, np.maximum(value, 0.0), 0.0)


def integrate(pattern: Pattern, *, weigh: bool) -> float:
    """Return the integral over the sky, to about 1e-7 of it where the pattern is nowhere cut off at 0.

    Parameters
    ----------
    pattern : Pattern
    weigh : bool    By the sine of the elevation, which gives the illuminance of a horizontal plane.

    Returns
    -------
    float    [sr times the pattern's unit]
    """
    x, y, z = pattern.sun
    # Only the sun's height counts.
    return _integral(replace(pattern, sun=(float(np.hypot(x, y)), 0.0, z)), weigh)


@lru_cache(maxsize=1024)
def _integral(pattern: Pattern, weigh: bool) -> float:
    """Gauss sums over elevation and azimuth, in panels that end at the sun, where the luminance has a cusp."""
    nodes, weights = np.polynomial.legendre.leggauss(96)
    height = float(np.arcsin(np.clip(pattern.sun[2], -1.0, 1.0)))
    split = min(max(height, 0.0), 0.5 * np.pi)
    floor = float(np.arcsin(pattern.floor)) if pattern.floor > 1e-3 else 0.0
    # Graded towards the sun from both sides, and towards the horizon, where exp(b / sine) bends.
    elevation, area = [], []
    for low, high, end in ((0.0, split, 1), (split, 0.5 * np.pi, 0)):
        for start, stop in ((low, min(high, floor)), (max(low, floor), high)):
            if stop - start < 1e-12:
                continue
            t = 0.5 * (nodes + 1.0)
            share = 1.0 - (1.0 - t) ** 3 if end else t**3
            slope = 3.0 * (1.0 - t) ** 2 if end else 3.0 * t**2
            elevation.append(start + (stop - start) * share)
            area.append(0.5 * weights * (stop - start) * slope)
    elevation, area = np.concatenate(elevation), np.concatenate(area)
    t = 0.5 * (nodes + 1.0)
    azimuth, width = np.pi * t**3, 0.5 * weights * np.pi * 3.0 * t**2
    sine, cosine = np.sin(elevation)[:, None], np.cos(elevation)[:, None]
    directions = np.stack(
        np.broadcast_arrays(cosine * np.cos(azimuth), cosine * np.sin(azimuth), sine), axis=-1
    )
    value = evaluate(pattern, directions) * cosine * (sine if weigh else 1.0)
    return float(2.0 * area @ value @ width)
