"""Flux in zones about the luminaire's vertical, whatever the polar axis of the distribution."""

import numpy as np

from ..scene.distribution import IntensityDistribution
from .distribution import TURN, flux

NODES = 12
"""Points of the Gauss-Legendre rule in each piece of the azimuth."""

WIDEST_PIECE = np.deg2rad(15.0)
"""Widest piece of the azimuth for one rule. [rad]"""


def flux_within(distribution: IntensityDistribution, half_angle) -> np.ndarray:
    """Flux within cones about the luminaire's -z.

    Exact for the bilinear interpolant where the grid's polar axis is vertical. For another axis (types A and B) the cone
    cuts an interval out of each meridian of the grid: the integral over it is in closed form, and that over the azimuth is a
    Gauss-Legendre sum, cut where a meridian touches a cone.

    Parameters
    ----------
    half_angle : (n,) array    0..pi. [rad]

    Returns
    -------
    (n,) float64 array    [lm]
    """
    half_angle = np.atleast_1d(np.asarray(half_angle, dtype=np.float64))
    vertical = distribution.frame[2, 2]
    if abs(abs(vertical) - 1.0) < 1e-12:
        if vertical > 0.0:
            return np.array([flux(distribution, 0.0, angle) for angle in half_angle])
        return np.array([flux(distribution, np.pi - angle, np.pi) for angle in half_angle])
    azimuth, weight = _azimuth_rule(distribution, half_angle)
    column, share = _columns(distribution.azimuth, azimuth)
    meridian = _Meridians(distribution)
    # The cosine to -z along a meridian is a cos(polar) + b sin(polar) = r cos(polar - middle).
    b = -(distribution.frame[2, 0] * np.cos(azimuth) + distribution.frame[2, 1] * np.sin(azimuth))
    r, middle = np.hypot(vertical, b), np.arctan2(b, vertical)
    total = np.zeros(len(half_angle))
    for i, angle in enumerate(half_angle):
        cosine = np.cos(angle)
        # Where r is 0 the cosine to -z is, all along; otherwise the interval is middle -/+ reach, repeated every turn.
        ratio = np.divide(cosine, r, out=np.full_like(r, np.sign(cosine)), where=r > 1e-12)
        reach = np.arccos(np.clip(ratio, -1.0, 1.0))
        for turn in (-TURN, 0.0, TURN):
            low = meridian.integral(column, share, middle - reach + turn)
            high = meridian.integral(column, share, middle + reach + turn)
            total[i] += weight @ (high - low)
    return total


def _azimuth_rule(distribution, half_angle) -> tuple[np.ndarray, np.ndarray]:
    """Points of azimuth and their weights, cut at the grid's columns and where a meridian touches a cone. [rad]"""
    grid = distribution.azimuth
    low, high = (grid[0], grid[-1]) if len(grid) > 1 else (0.0, TURN)
    even = np.linspace(low, high, int(np.ceil((high - low) / WIDEST_PIECE)) + 1)
    across = np.hypot(*distribution.frame[2, :2])
    steepest = np.arctan2(distribution.frame[2, 1], distribution.frame[2, 0])
    squared = (np.cos(half_angle) ** 2 - distribution.frame[2, 2] ** 2) / across**2
    leaning = np.arccos(np.sqrt(squared[(squared >= 0.0) & (squared <= 1.0)]))
    touching = np.concatenate([s + steepest for s in (leaning, -leaning)])
    touching = low + np.mod(np.concatenate([touching, touching + np.pi]) - low, TURN)
    cuts = np.unique(np.concatenate([even, grid, touching[touching < high]]))
    # Near the azimuth where a meridian touches a cone the interval grows like a square root: the sine removes that.
    point, weight = np.polynomial.legendre.leggauss(NODES)
    point, weight = np.sin(0.5 * np.pi * point), weight * 0.5 * np.pi * np.cos(0.5 * np.pi * point)
    half = 0.5 * np.diff(cuts)[:, None]
    middle = 0.5 * (cuts[1:] + cuts[:-1])[:, None]
    return (middle + half * point).ravel(), (half * weight).ravel()


def _columns(grid, azimuth) -> tuple[np.ndarray, np.ndarray]:
    """Column of the grid before each azimuth, and the place between it and the next, 0..1."""
    if len(grid) == 1:
        return np.zeros(len(azimuth), dtype=int), np.zeros(len(azimuth))
    column = np.clip(np.searchsorted(grid, azimuth, side="right") - 1, 0, len(grid) - 2)
    return column, (azimuth - grid[column]) / (grid[column + 1] - grid[column])


class _Meridians:
    """Integrals of intensity times sin(polar) from the grid's first polar angle, along its columns and between them."""

    def __init__(self, distribution):
        self.polar = distribution.polar
        self.table = distribution.intensity
        if len(distribution.azimuth) == 1:
            self.table = np.repeat(self.table, 2, axis=0)
        self.slope = np.diff(self.table, axis=1) / np.diff(self.polar)
        row = np.arange(len(self.polar) - 1)
        pieces = self._piece(slice(None), row, self.polar[1:])
        self.sums = np.concatenate([np.zeros((len(self.table), 1)), np.cumsum(pieces, 1)], axis=1)

    def integral(self, column, share, polar) -> np.ndarray:
        """Integral up to polar angles, which may lie outside the grid. [rad -> lm/rad]"""
        polar = np.clip(polar, self.polar[0], self.polar[-1])
        row = np.searchsorted(self.polar, polar, side="right") - 1
        row = np.clip(row, 0, len(self.polar) - 2)
        low = self.sums[column, row] + self._piece(column, row, polar)
        high = self.sums[column + 1, row] + self._piece(column + 1, row, polar)
        return low * (1.0 - share) + high * share

    def _piece(self, column, row, polar) -> np.ndarray:
        """Integral from the start of a cell to a polar angle in it."""
        start = self.polar[row]
        width = polar - start
        level = 2.0 * np.sin(0.5 * (start + polar)) * np.sin(0.5 * width)
        ramp = np.sin(polar) - np.sin(start) - width * np.cos(polar)
        return self.table[column, row] * level + self.slope[column, row] * ramp
