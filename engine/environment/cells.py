"""Where the pixels of an equirectangular picture lie, and the light that each stands for, exact by `sky.picture`."""

from dataclasses import dataclass

import numpy as np

from ..sky.picture import Grid

POINTS = 4
"""Places in a band for the integrals over it; they are exact to the last digits even for pictures of few rows."""


@dataclass(frozen=True, eq=False)
class Moments:
    """Integrals of what a pixel of value 1 adds to a picture, over the sphere.

    Parameters
    ----------
    solid : (height,) array    Solid angle. [sr]
    plan : (height,) array    Of the direction's horizontal part, along the pixel's azimuth. [sr]
    up : (height,) array    Of the direction's upward part. [sr]
    """

    solid: np.ndarray
    plan: np.ndarray
    up: np.ndarray


def find_moments(grid: Grid) -> Moments:
    """Return the moments of each row's pixels."""
    node, weight = np.polynomial.legendre.leggauss(POINTS)
    node, weight = 0.5 + 0.5 * node, 0.5 * weight
    size = grid.end - grid.start
    solid, plan, up = (np.zeros(grid.height) for _ in range(3))
    for t, share in zip(node, weight, strict=True):
        polar = np.pi * (grid.start + t * size) / grid.height
        area = np.sin(polar) * size * share * (np.pi / grid.height) * (2.0 * np.pi / grid.width)
        for rows, part in ((grid.lower, 1.0 - t), (grid.upper, t)):
            np.add.at(solid, rows, part * area)
            np.add.at(plan, rows, part * area * np.sin(polar))
            np.add.at(up, rows, -part * area * np.cos(polar))
    # Along a row a pixel is a step, or a roof of twice the width: of their Fourier transforms one is left each.
    blur = np.sinc(1.0 / grid.width)
    return Moments(solid, plan * (blur**2 if grid.is_smooth else blur), up)


def azimuths(columns: np.ndarray, width: int) -> np.ndarray:
    """Angles from +x towards +y of the middles of columns. [rad]"""
    return (0.5 - (np.asarray(columns, dtype=np.float64) + 0.5) / width) * 2.0 * np.pi


def directions(rows: np.ndarray, columns: np.ndarray, grid: Grid) -> np.ndarray:
    """Unit vectors to the middles of pixels. (n,), (n,) -> (n, 3) float32"""
    polar = (np.asarray(rows, dtype=np.float64) + 0.5) * np.pi / grid.height
    turn, plan = azimuths(columns, grid.width), np.sin(polar)
    made = (plan * np.cos(turn), plan * np.sin(turn), -np.cos(polar))
    return np.stack([each.astype(np.float32) for each in made], axis=-1)


def place_of(direction, grid: Grid) -> tuple[float, float]:
    """Row and column, with parts of pixels, that a direction is seen at; the middle of the first pixel is (0.5, 0.5)."""
    x, y, z = (float(each) for each in direction)
    row = (np.arctan2(z, np.hypot(x, y)) / np.pi + 0.5) * grid.height
    return float(row), float((0.5 - np.arctan2(y, x) / (2.0 * np.pi)) % 1.0 * grid.width)


def direction_at(u: float, v: float) -> np.ndarray:
    """Unit vector of a place in a picture, 0 to 1 from its left and from its lower edge. (3,)"""
    turn, polar = (0.5 - u) * 2.0 * np.pi, np.pi * v
    return np.array([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), -np.cos(polar)])


def cell_sizes(grid: Grid) -> np.ndarray:
    """Solid angle of each row's pixels as cells. (height,) [sr]"""
    edges = -np.cos(np.pi * np.arange(grid.height + 1) / grid.height)
    return np.diff(edges) * (2.0 * np.pi / grid.width)


def first_row_above(grid: Grid) -> int:
    """Return the number of the lowest row whose pixels give light from above the horizon alone."""
    lowest = 0.5 * grid.height + grid.shift
    return min(int(np.ceil(lowest - 1e-9)), grid.height)
