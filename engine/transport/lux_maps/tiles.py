"""Tiles: squares of a few lumels of one chart, which see much the same."""

import numpy as np

TILE = 8
"""Side of the squares. [lumel]"""


def tile_numbers(block, width: int) -> np.ndarray:
    """Number of the tile of every lumel of a block. (n,) ``width``: of the page. [lumel]"""
    y, x = np.divmod(block.index, width)
    across = width // TILE + 1
    key = (block.chart.astype(np.int64) * across + y // TILE) * across + x // TILE
    return np.unique(key, return_inverse=True)[1].reshape(-1)
