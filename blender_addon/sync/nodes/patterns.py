"""Checker and brick patterns as pictures.

References
----------
Blender source, ``intern/cycles/kernel/svm/checker.h`` and ``brick.h``.
"""

from dataclasses import dataclass

import numpy as np

CHECKER = np.array([[0.0, 1.0], [1.0, 0.0]], np.float32)[..., None]
"""Two by two fields of the checker, which repeats: 1 is the first colour, 0 the second."""


@dataclass(frozen=True)
class Bonding:
    """How bricks are laid; meanings and names as in Blender's Brick Texture."""

    mortar_size: float
    mortar_smooth: float
    bias: float
    brick_width: float
    row_height: float
    offset: float
    offset_frequency: int
    squash: float
    squash_frequency: int


def draw_bricks(x, y, bonding: Bonding) -> tuple[np.ndarray, np.ndarray]:
    """Return the share of mortar and the tint of the brick at scaled coordinates.

    Parameters
    ----------
    x, y : arrays of one shape    Coordinates times the node's scale.

    Returns
    -------
    tuple of arrays    Mortar 0..1, and the share of the second brick colour 0..1.
    """
    row = np.floor(y / bonding.row_height).astype(np.int64)
    width = np.full(x.shape, bonding.brick_width)
    shift = np.zeros(x.shape)
    if bonding.offset_frequency and bonding.squash_frequency:
        width = np.where(row % bonding.squash_frequency, width, width * bonding.squash)
        shift = np.where(row % bonding.offset_frequency, 0.0, width * bonding.offset)
    column = np.floor((x + shift) / width).astype(np.int64)
    across = x + shift - width * column
    up = y - bonding.row_height * row
    tint = np.clip(_noise((row << 16) + (column & 0xFFFF)) + bonding.bias, 0, 1)
    inside = np.minimum(np.minimum(across, up), np.minimum(width - across, bonding.row_height - up))
    return _mortar(inside, bonding), tint


def _mortar(inside, bonding):
    if bonding.mortar_size <= 0:
        return np.zeros(inside.shape)
    depth = 1 - inside / bonding.mortar_size
    if bonding.mortar_smooth == 0:
        return (depth > 0) * 1.0
    soft = np.clip(depth / bonding.mortar_smooth, 0, 1)
    return np.where(depth > 0, soft**2 * (3 - 2 * soft), 0.0)


def _noise(number):
    """Return Cycles' integer noise, 0..1; it wraps at 32 bits on purpose."""
    mask = np.uint64(0xFFFFFFFF)
    n = (number.astype(np.uint64) + np.uint64(1013)) & np.uint64(0x7FFFFFFF)
    n = (n >> np.uint64(13)) ^ n
    square = (n * n) & mask
    inner = (square * np.uint64(60493) + np.uint64(19990303)) & mask
    mixed = (n * inner + np.uint64(1376312589)) & np.uint64(0x7FFFFFFF)
    return 0.5 * mixed.astype(np.float64) / 1073741824.0
