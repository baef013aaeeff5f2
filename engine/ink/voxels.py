"""Packings on a grid: which share of each cell particles of each kind fill.

For the scalar equation the mean permittivity of a cell is what it does to waves that are long against the cell (there is no
polarisation that depends on shapes), so what stairs make wrong falls with the square of the step.
"""

import numpy as np

from .packing import Packing

SAMPLES = 3
"""Points along each side of a cell by which shares are counted."""

PIECE = 1 << 22
"""Points that are looked at in one go."""

SLAB = 1 << 24
"""Points of the grid that are held at once."""


def fill_shares(packing: Packing, shape) -> np.ndarray:
    """Share of each cell that each population fills; its mean is the population's share of the volume.

    Parameters
    ----------
    shape : (int, int)    Cells along the depth and sideways.

    Returns
    -------
    (p, z, y, x) float64 array
    """
    layers, columns = shape
    kinds = len(packing.populations)
    made = np.zeros((kinds, layers, columns, columns))
    centres, radii, owners = packing.spheres()
    labels = packing.kinds[owners] + 1
    side = columns * SAMPLES
    step, rise = packing.width / side, packing.thickness / (layers * SAMPLES)
    at_once = max(1, SLAB // (side * side * SAMPLES))
    for low in range(0, layers, at_once):
        high = min(low + at_once, layers)
        points = np.zeros(((high - low) * SAMPLES, side, side), np.uint8)
        top, bottom = low * SAMPLES * rise, high * SAMPLES * rise
        here = np.flatnonzero((centres[:, 2] + radii > top) & (centres[:, 2] - radii < bottom))
        _stamp(points, centres[here], radii[here], labels[here], step, rise, low * SAMPLES)
        blocks = points.reshape(high - low, SAMPLES, columns, SAMPLES, columns, SAMPLES)
        for kind in range(kinds):
            made[kind, low:high] = (blocks == kind + 1).mean(axis=(1, 3, 5))
    for kind, population in enumerate(packing.populations):
        mean = made[kind].mean()
        if mean > 0.0:
            made[kind] *= population.share / mean
    return made


def _stamp(points, centres, radii, labels, step: float, rise: float, first: int) -> None:
    """Mark the points within spheres, spheres of like size together."""
    depth, side, _ = points.shape
    flat = points.reshape(-1)
    order = np.argsort(radii, kind="stable")
    start = 0
    while start < len(order):
        largest = radii[order[min(start + 1024, len(order)) - 1]]
        across = 2 * int(np.ceil(largest / step)) + 1
        down = 2 * int(np.ceil(largest / rise)) + 1
        count = max(1, min(1024, PIECE // (across * across * down)))
        own = order[start : start + count]
        start += count
        x, y = (
            np.floor(centres[own, k, None] / step).astype(np.int64)
            + np.arange(across)
            - across // 2
            for k in (0, 1)
        )
        z = np.floor(centres[own, 2, None] / rise).astype(np.int64) + np.arange(down) - down // 2
        dx, dy = (((at + 0.5) * step - centres[own, k, None]) ** 2 for k, at in ((0, x), (1, y)))
        dz = ((z + 0.5) * rise - centres[own, 2, None]) ** 2
        within = dz[:, :, None, None] + dy[:, None, :, None] + dx[:, None, None, :]
        within = within < (radii[own] ** 2)[:, None, None, None]
        z -= first
        within &= ((z >= 0) & (z < depth))[:, :, None, None]
        number, k, j, i = np.nonzero(within)
        place = (z[number, k] * side + y[number, j] % side) * side + x[number, i] % side
        flat[place] = labels[own][number]
