"""The table of a sky that is computed by scattering: what its cells hold, and how it is looked up.

Columns go round from the direction opposite to the sun, rows from the lowest point up, crowded at the horizon: half-way
between the middle and an edge of the table the elevation is a quarter of a right angle. Halves are mirror images.
"""

import numpy as np

from .directions import elevations

WIDTH = 512
"""Columns of the whole circle."""


def mirror(half: np.ndarray) -> np.ndarray:
    """Return the whole table from the half before the sun's meridian. (rows, WIDTH/2, 3) -> (rows, WIDTH, 3)"""
    return np.concatenate([half, half[:, ::-1]], axis=1)


def columns_of(directions, towards_sun) -> np.ndarray:
    """Place of directions round the table, 0.5 at the sun. (..., 3), (3,) -> (...) [0..1]"""
    own = np.arctan2(directions[..., 1], directions[..., 0])
    return (0.5 - (own - np.arctan2(towards_sun[1], towards_sun[0])) / (2.0 * np.pi)) % 1.0


def rows_of(directions) -> np.ndarray:
    """Place of directions from the lowest point to the zenith, 0.5 at the horizon. (..., 3) -> (...) [0..1]"""
    elevation = elevations(directions)
    return 0.5 + 0.5 * np.copysign(np.sqrt(np.abs(elevation) / (0.5 * np.pi)), elevation)


def look_up(table: np.ndarray, u, v) -> np.ndarray:
    """Interpolate between the middles of cells; beyond the outer ones their values hold. (rows, columns, 3) -> (..., 3)"""
    height, width = table.shape[:2]
    x = np.clip(np.asarray(u) * width - 0.5, 0.0, width - 1.0)
    y = np.clip(np.asarray(v) * height - 0.5, 0.0, height - 1.0)
    left = np.minimum(x.astype(int), width - 2)
    low = np.minimum(y.astype(int), height - 2)
    a, b = (x - left)[..., None], (y - low)[..., None]
    return (table[low, left] * (1.0 - a) + table[low, left + 1] * a) * (1.0 - b) + (
        table[low + 1, left] * (1.0 - a) + table[low + 1, left + 1] * a
    ) * b
