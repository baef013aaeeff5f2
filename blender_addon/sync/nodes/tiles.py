"""Values on several tiles side by side: (1, n, c), those of one tile after the other and one for what is outside."""

from dataclasses import replace

import numpy as np

from ....engine.scene.texture import Tile

MOST = 1 << 26
"""Values that resampling makes at most."""


def common_layout(tiled, layouts, sides) -> tuple:
    """Return what pictures are brought to where one of them has tiles: its layout, as fine as the finest of each tile.

    Parameters
    ----------
    tiled : Layout    That has tiles.
    layouts : sequence of Layout    All of them.
    sides : (2,) array    Height and width that pictures without tiles need on each.

    Returns
    -------
    (Layout, bool)    Layout, and whether nothing is lost.
    """
    least = (int(np.ceil(sides[1] - 1e-3)), int(np.ceil(sides[0] - 1e-3)))
    sizes: dict[tuple[int, int], tuple[int, int]] = {}
    for each in layouts:
        if not each.tiles or not np.allclose(each.transform, tiled.transform):
            continue
        for tile in each.tiles:
            old = sizes.get(tile[:2], least)
            sizes[tile[:2]] = (max(old[0], tile.width), max(old[1], tile.height))
    whole = sum(width * height for width, height in sizes.values())
    part = min(1.0, (MOST / whole) ** 0.5)
    tiles = tuple(
        Tile(*place, *(max(int(part * side), 1) for side in size))
        for place, size in sorted(sizes.items())
    )
    return replace(tiled, tiles=tiles), whole <= MOST


def count(tiles) -> int:
    """Return how many values there are."""
    return sum(tile.width * tile.height for tile in tiles) + 1


def places_on(tiles, transform: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return u and v at all values, moved by a matrix (3, 3); what is outside is far from all tiles. (1, n)"""
    parts = []
    for tile in tiles:
        v, u = np.meshgrid(
            tile.line + (np.arange(tile.height) + 0.5) / tile.height,
            tile.column + (np.arange(tile.width) + 0.5) / tile.width,
            indexing="ij",
        )
        parts.append(np.stack([u.ravel(), v.ravel(), np.ones(u.size)]))
    parts.append(np.array([[-2.0], [-2.0], [1.0]]))
    u, v, _ = transform @ np.concatenate(parts, axis=1)
    return u[None], v[None]


def look_up(field, u, v, look_up_one) -> np.ndarray:
    """Return values of a field of tiles at places, as Cycles finds tiles.

    Parameters
    ----------
    field : Field
    u, v : arrays of one shape
    look_up_one : callable    As of this function, for a field of one picture.
    """
    layout, channels = field.layout, field.values.shape[-1]
    u, v = np.broadcast_arrays(np.asarray(u, np.float64), np.asarray(v, np.float64))
    column, line = np.trunc(u), np.trunc(v)
    made = np.empty((*u.shape, channels), np.float32)
    made[:] = field.values[0, -1]
    start = 0
    for tile in layout.tiles:
        size = tile.width * tile.height
        # Minus nought is nought: just before the first tile is outside its edge.
        here = (column == tile.column) & (line == tile.line)
        if here.any():
            pixels = field.values[0, start : start + size].reshape(
                tile.height, tile.width, channels
            )
            one = replace(field, values=pixels, layout=replace(layout, tiles=()))
            made[here] = look_up_one(one, u[here] - tile.column, v[here] - tile.line)
        start += size
    return made
