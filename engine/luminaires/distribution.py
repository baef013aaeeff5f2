"""Intensity distributions: value in a direction, flux, and the distribution turned, mirrored or scaled.

Bilinear in the grid's own angles, as LM-63 and EULUMDAT define it. The integrals over the sphere are those of the bilinear
interpolant in closed form, not sums over zones.
"""

from dataclasses import replace

import numpy as np

from ..scene.distribution import IntensityDistribution
from .coordinates import angles

TURN = 2.0 * np.pi
"""A full turn. [rad]"""


def is_closed(distribution: IntensityDistribution) -> bool:
    """Whether the azimuths go all around."""
    azimuth = distribution.azimuth
    return len(azimuth) == 1 or azimuth[-1] - azimuth[0] > TURN - 1e-9


def intensity(distribution: IntensityDistribution, direction) -> np.ndarray:
    """Intensity in directions (..., 3) given in the luminaire's axes. [cd]"""
    azimuth, polar = angles(direction, distribution.frame)
    return intensity_at(distribution, azimuth, polar)


def intensity_at(distribution: IntensityDistribution, azimuth, polar) -> np.ndarray:
    """Intensity at angles of the grid. [rad], [cd]"""
    azimuth, polar = np.broadcast_arrays(
        np.asarray(azimuth, dtype=np.float64), np.asarray(polar, dtype=np.float64)
    )
    table = distribution.intensity
    row, v, inside = _locate(distribution.polar, polar)
    if len(distribution.azimuth) == 1:
        return np.where(inside, table[0, row] * (1.0 - v) + table[0, row + 1] * v, 0.0)
    start = distribution.azimuth[0]
    around = start + np.mod(azimuth - start, TURN)
    column, u, within = _locate(distribution.azimuth, around)
    low = table[column, row] * (1.0 - v) + table[column, row + 1] * v
    high = table[column + 1, row] * (1.0 - v) + table[column + 1, row + 1] * v
    return np.where(inside & within, low * (1.0 - u) + high * u, 0.0)


def _locate(grid: np.ndarray, value) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cell, place in it 0..1, and whether the value lies within the grid; rounding at the ends is forgiven."""
    cell = np.clip(np.searchsorted(grid, value, side="right") - 1, 0, len(grid) - 2)
    place = (value - grid[cell]) / (grid[cell + 1] - grid[cell])
    inside = (value >= grid[0] - 1e-12) & (value <= grid[-1] + 1e-12)
    return cell, np.clip(place, 0.0, 1.0), inside


def polar_weights(polar: np.ndarray, low: float = 0.0, high: float = np.pi) -> np.ndarray:
    """Weights (p,) with which values at the polar angles sum to the integral of interpolant times sin(gamma).

    Parameters
    ----------
    polar : (p,) array    [rad]
    low, high : float    Only between these polar angles. [rad]
    """
    a, b = np.clip(polar[:-1], low, high), np.clip(polar[1:], low, high)
    width = np.diff(polar)
    # The integrals of sin and of (gamma - a) sin over a..b, by half angles, which keep their precision in narrow cells.
    half, middle = 0.5 * (b - a), 0.5 * (a + b)
    total = 2.0 * np.sin(middle) * np.sin(half)
    # (gamma - middle) sin(gamma): only the even part of sin about the middle vanishes.
    lever = 2.0 * np.cos(middle) * _sine_lever(half)
    moment = lever + (middle - polar[:-1]) * total
    upper = moment / width
    weights = np.zeros(len(polar))
    weights[:-1] += total - upper
    weights[1:] += upper
    return weights


def _sine_lever(half: np.ndarray) -> np.ndarray:
    """Sin h - h cos h: half the integral of t sin t over -h..h."""
    series = half**3 / 3.0 * (1.0 - half**2 / 10.0 * (1.0 - half**2 / 28.0))
    return np.where(np.abs(half) < 0.1, series, np.sin(half) - half * np.cos(half))


def azimuth_weights(azimuth: np.ndarray) -> np.ndarray:
    """Weights (a,) with which values at the azimuths sum to the integral over the azimuth. [rad]"""
    if len(azimuth) == 1:
        return np.array([TURN])
    width = np.diff(azimuth)
    weights = np.zeros(len(azimuth))
    weights[:-1] += 0.5 * width
    weights[1:] += 0.5 * width
    return weights


def flux(distribution: IntensityDistribution, low: float = 0.0, high: float = np.pi) -> float:
    """Flux between two polar angles of the grid, exactly that of the bilinear interpolant. [lm]"""
    rows = azimuth_weights(distribution.azimuth) @ distribution.intensity
    return float(rows @ polar_weights(distribution.polar, low, high))


def peak(distribution: IntensityDistribution) -> tuple[float, float, float]:
    """Largest intensity [cd] and the grid's azimuth and polar angle where it is [rad]; the first of several."""
    column, row = np.unravel_index(np.argmax(distribution.intensity), distribution.intensity.shape)
    return (
        float(distribution.intensity[column, row]),
        float(distribution.azimuth[column]),
        float(distribution.polar[row]),
    )


def scaled(distribution: IntensityDistribution, factor: float) -> IntensityDistribution:
    """Return the distribution with all intensities multiplied."""
    return replace(distribution, intensity=distribution.intensity * factor)


def turned(distribution: IntensityDistribution, angle: float) -> IntensityDistribution:
    """Return the distribution turned about the luminaire's vertical, counter-clockwise seen from above. [rad]"""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return replace(distribution, frame=turn @ distribution.frame)


def mirrored(distribution: IntensityDistribution) -> IntensityDistribution:
    """Return the distribution with C counted clockwise: mirrored about the C0-C180 plane."""
    return replace(distribution, frame=np.diag([1.0, -1.0, 1.0]) @ distribution.frame)
