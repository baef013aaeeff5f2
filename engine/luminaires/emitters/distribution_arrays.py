"""Arrays of one intensity distribution, as the device wants them: finer grids, running shares, a coarse map."""

from dataclasses import dataclass

import numpy as np

from ...errors import SceneError
from ...scene.distribution import IntensityDistribution
from ..distribution import TURN, flux, intensity_at, polar_weights

WIDEST_CELL = np.deg2rad(10.0)
"""Polar cells are cut to this width, which changes nothing of a bilinear function; the series in `_draw_polar` needs it."""

MOST_BINS = 1 << 16
"""Longest table by which a cell is found."""

IMPORTANCE = 64
"""Rows of the coarse map by which lights are chosen, an octahedral one."""

FLOOR = 0.1
"""Share of the mean below which no direction's importance falls: from parts of an opening the direction is another one."""

MOST_CELLS = 1 << 16
"""Cells that an uneven grid may be cut into, at least, to become an even one."""

FINEST = 1000
"""Steps of even grids are whole numbers of 1/1000 degree."""


@dataclass
class PreparedDistribution:
    """Arrays of one distribution, as the device wants them."""

    header: dict[str, int]
    ranges: np.ndarray
    azimuth_guide: np.ndarray
    polar_guide: np.ndarray
    azimuth_nodes: np.ndarray
    polar_nodes: np.ndarray
    cells: np.ndarray
    rows: np.ndarray
    columns: np.ndarray
    sums: np.ndarray
    importance: np.ndarray
    crowding: int
    contrast: float
    sharpness: float
    is_even: bool


def _refined(grid: np.ndarray, widest: float) -> np.ndarray:
    """Grid with cells cut into equal parts no wider than this."""
    parts = np.maximum(np.ceil(np.diff(grid) / widest - 1e-9).astype(int), 1)
    pieces = [
        low + (high - low) * np.arange(count) / count
        for low, high, count in zip(grid[:-1], grid[1:], parts, strict=True)
    ]
    return np.concatenate([*pieces, grid[-1:]])


def _guide(grid: np.ndarray) -> tuple[np.ndarray, int]:
    """Table by which the cell of a value is found: for even bins the first cell, and where the next one begins.

    Returns
    -------
    (bins, 2) float32 array, int    And the largest number of cells that begin inside one bin; mostly 1.
    """
    span = grid[-1] - grid[0]
    wanted = np.ceil(span / np.diff(grid).min() * 1.0001)
    bins = int(np.clip(wanted, 1, MOST_BINS))
    edges = grid[0] + span * np.arange(bins) / bins
    single = grid.astype(np.float32)
    # Half a bin's rounding: a value may be taken for its neighbour's bin, so cells are counted from a little before.
    cell = np.searchsorted(grid, edges - 1e-6 * span, side="right") - 1
    cell = np.clip(cell, 0, len(grid) - 2)
    following = np.append(cell[1:], len(grid) - 2)
    crowding = int(np.max(following - cell, initial=0))
    return np.stack([cell.astype(np.float32), single[cell + 1]], axis=1), max(crowding, 1)


def _nodes(grid: np.ndarray) -> np.ndarray:
    """First angle and inverse width of every cell. (n - 1, 2)"""
    return np.stack([grid[:-1], 1.0 / np.diff(grid)], axis=1)


def _even(grid: np.ndarray, widest: float) -> np.ndarray | None:
    """Even grid that has all nodes of this one, None if its angles have no common step."""
    steps = np.rad2deg(grid) * FINEST
    whole = np.round(steps).astype(np.int64)
    if np.abs(steps - whole).max() > 1e-3:
        return None
    step = int(np.gcd.reduce(np.diff(whole)))
    count = (whole[-1] - whole[0]) // max(step, 1)
    if step == 0 or count > MOST_CELLS:
        return None
    count *= int(np.ceil((grid[-1] - grid[0]) / count / widest - 1e-9))
    return np.linspace(grid[0], grid[-1], count + 1)


def _cut(azimuth, polar) -> tuple[np.ndarray, np.ndarray, bool]:
    """Grid with more nodes, at which a bilinear function stays the same: even where that does not take too many."""
    even = _even(azimuth, TURN), _even(polar, WIDEST_CELL)
    limit = max(MOST_CELLS, 4 * len(azimuth) * len(polar))
    if even[0] is not None and even[1] is not None and len(even[0]) * len(even[1]) <= limit:
        return *even, True
    return azimuth, _refined(polar, WIDEST_CELL), False


def _interpolated(values: np.ndarray, grid: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Rows of a table at other nodes, linearly."""
    if len(grid) == len(nodes):
        return values
    cell = np.clip(np.searchsorted(grid, nodes, side="right") - 1, 0, len(grid) - 2)
    share = ((nodes - grid[cell]) / (grid[cell + 1] - grid[cell])).clip(0.0, 1.0)[:, None]
    return values[cell] * (1.0 - share) + values[cell + 1] * share


def _sharpness(azimuth, polar, table) -> float:
    """How sharp the features of a distribution are: twice the mean squared gradient over the mean square.

    A Gaussian beam has its peak over its mean, as has a Lambertian distribution (4); several beams have the value of one.
    """
    sines = np.sin(0.5 * (polar[:-1] + polar[1:]))
    heights, widths = np.diff(polar), np.diff(azimuth)
    down = np.diff(table, axis=1) / heights
    down = 0.5 * (down[:-1] + down[1:])
    across = np.diff(table, axis=0) / widths[:, None]
    across = 0.5 * (across[:, :-1] + across[:, 1:]) / sines
    middle = 0.25 * (table[:-1, :-1] + table[1:, :-1] + table[:-1, 1:] + table[1:, 1:])
    areas = widths[:, None] * heights * sines
    squared = float((middle**2 * areas).sum())
    return 2.0 * float(((down**2 + across**2) * areas).sum()) / max(squared, 1e-300)


def prepare(distribution: IntensityDistribution) -> PreparedDistribution:
    """Make the arrays of a distribution.

    Raises
    ------
    SceneError    It has no flux.
    """
    total = flux(distribution)
    if not (np.isfinite(total) and total > 0.0):
        raise SceneError(
            f"a luminaire's distribution has a flux of {total:g} lm, expected more than 0"
        )
    old, table = distribution.azimuth, distribution.intensity / total
    if len(old) == 1:
        old, table = np.array([0.0, TURN]), np.repeat(table, 2, axis=0)
    sharpness = _sharpness(old, distribution.polar, table)
    azimuth, polar, is_even = _cut(old, distribution.polar)
    table = _interpolated(table, old, azimuth)
    table = _interpolated(table.T, distribution.polar, polar).T
    quads = np.stack([table[:-1, :-1], table[:-1, 1:], table[1:, :-1], table[1:, 1:]], axis=-1)
    # Flux of every cell: exact, since the polar weights of a cell are those of its two nodes alone.
    pairs = np.array([polar_weights(pair) for pair in np.stack([polar[:-1], polar[1:]], axis=1)])
    planes = table[:, :-1] * pairs[:, 0] + table[:, 1:] * pairs[:, 1]
    fluxes = 0.5 * (planes[:-1] + planes[1:]) * np.diff(azimuth)[:, None]
    azimuth_guide, crowding = _guide(azimuth)
    polar_guide, other = _guide(polar)
    importance = _importance(distribution, total)
    header = {
        "azimuth_bins": len(azimuth_guide),
        "azimuth_cells": len(azimuth) - 1,
        "polar_bins": len(polar_guide),
        "polar_cells": len(polar) - 1,
    }
    return PreparedDistribution(
        header,
        np.array([azimuth[0], azimuth[-1], polar[0], polar[-1]]),
        azimuth_guide,
        polar_guide,
        _nodes(azimuth),
        _nodes(polar),
        quads.reshape(-1, 4),
        _running(fluxes.sum(axis=0)),
        np.concatenate([_running(row) for row in fluxes.T]),
        _sums(fluxes).ravel(),
        importance,
        max(crowding, other),
        float(table.max()) * 4.0 * np.pi,
        sharpness,
        is_even,
    )


def _running(amounts: np.ndarray) -> np.ndarray:
    """Shares summed up, from 0 to 1. (n + 1,)"""
    total = amounts.sum()
    if total <= 0.0:
        return np.linspace(0.0, 1.0, len(amounts) + 1)
    return np.concatenate([[0.0], np.minimum(np.cumsum(amounts) / total, 1.0)])


def _sums(fluxes: np.ndarray) -> np.ndarray:
    """Share of the flux in the cells before each corner of the grid. (a cells + 1, p cells + 1)"""
    sums = np.zeros((fluxes.shape[0] + 1, fluxes.shape[1] + 1))
    sums[1:, 1:] = fluxes.cumsum(axis=0).cumsum(axis=1)
    return sums / sums[-1, -1]


def _importance(distribution: IntensityDistribution, total: float) -> np.ndarray:
    """Intensity relative to its mean over the sphere, by cells of the octahedral map, never below `FLOOR`."""
    fine = 4 * IMPORTANCE
    place = (np.arange(fine) + 0.5) / fine * 2.0 - 1.0
    x, y = np.meshgrid(place, place, indexing="xy")
    z = 1.0 - np.abs(x) - np.abs(y)
    fold = np.maximum(-z, 0.0)
    d = np.stack([x - np.copysign(fold, x), y - np.copysign(fold, y), z], axis=-1)
    azimuth = np.mod(np.arctan2(d[..., 1], d[..., 0]), TURN)
    polar = np.arctan2(np.hypot(d[..., 0], d[..., 1]), -d[..., 2])
    value = intensity_at(distribution, azimuth, polar) * (4.0 * np.pi / total)
    coarse = value.reshape(IMPORTANCE, 4, IMPORTANCE, 4).mean(axis=(1, 3))
    return np.maximum(coarse, FLOOR).ravel()
