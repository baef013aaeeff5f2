"""What drawing directions from a table needs: how likely each of its cells is, for each of its incidences.

A cell lies between neighbouring radial angles and azimuths. Within it directions are drawn evenly over solid angle, so
that the density is one number per cell; it follows the root mean square of f cos in the cell, the density of least
variance among those, and never falls below a part of the largest value there, which bounds every weight.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...scene.memo import recall_latest
from ...scene.scattering import ScatterTable
from ..data.table import albedos_of, direction_of, is_symmetric

POINTS = 4
"""Points along each side of a cell, both ends among them: of many cells only a corner is above the horizon."""

LEAST = 0.25
"""Share of a cell's largest f cos that its density follows at least."""


@dataclass(frozen=True, eq=False)
class TableCells:
    """Densities and cumulative shares of the cells of a table.

    Parameters
    ----------
    density : (p, s, t - 1, a - 1) float64 array    Over solid angle. [1/sr]
    radial : (p, s, t - 1) float64 array    Cumulative shares of rings, the last is 1. [-]
    azimuth : (p, s, t - 1, a - 1) float64 array    Cumulative shares of cells in a ring, the last is 1. [-]
    albedo : (p, s, w) float64 array    What is scattered, by band. [-]
    """

    density: np.ndarray
    radial: np.ndarray
    azimuth: np.ndarray
    albedo: np.ndarray


def reach_around(table: ScatterTable) -> ScatterTable:
    """Return a table whose radial angles go to 180 degrees, where their last values hold."""
    if table.radials[-1] >= np.pi - 1e-6:
        return table
    return replace(
        table,
        radials=np.append(table.radials, np.pi),
        values=np.concatenate([table.values, table.values[:, :, -1:]], axis=2),
    )


def prepare_cells(table: ScatterTable) -> TableCells:
    """Find how likely the cells of a table are; its radial angles go to 180 degrees."""
    values, *others = table.arrays()[5:6] + table.arrays()[:5]
    return recall_latest(values, "cells", others, None, lambda: _find_cells(table))


def _find_cells(table: ScatterTable) -> TableCells:
    ring = np.abs(np.diff(np.cos(table.radials)))[:, None]
    sides = 2.0 if is_symmetric(table) else 1.0
    angle = ring * np.diff(table.azimuths) * sides
    shape = (len(table.rotations), len(table.incidences), *angle.shape)
    mass = np.zeros(shape)
    for s in range(shape[1]):
        cosine = _effective_cosine(table, s)
        for p in range(shape[0]):
            mass[p, s] = _wanted_density(table, p, s, cosine) * angle
    total = mass.sum(axis=(2, 3), keepdims=True)
    mass = np.where(total > 0.0, mass / np.maximum(total, 1e-300), angle / angle.sum())
    rings = mass.sum(axis=3)
    within = np.where(
        rings[..., None] > 0.0, mass / np.maximum(rings[..., None], 1e-300), 1.0 / mass.shape[3]
    )
    albedo = albedos_of(table, table.incidences, table.rotations)
    return TableCells(
        mass / np.maximum(angle, 1e-300), _cumulative(rings), _cumulative(within), albedo
    )


def _wanted_density(table: ScatterTable, p: int, s: int, cosine: np.ndarray) -> np.ndarray:
    """What the densities of the cells of one incidence follow. (t - 1, a - 1)"""
    share = np.linspace(0.0, 1.0, POINTS)
    mean = table.values[p, s].mean(axis=-1, dtype=np.float64)
    f = _inside_values(_inside_values(mean, 0, share), 1, share)
    shape = (len(table.radials) - 1, POINTS, len(table.azimuths) - 1, POINTS)
    value = (f * cosine).reshape(shape)
    rms = np.sqrt((value**2).mean(axis=(1, 3)))
    return np.maximum(rms, LEAST * value.max(axis=(1, 3)))


def _cumulative(shares: np.ndarray) -> np.ndarray:
    total = np.cumsum(shares, axis=-1)
    return total / total[..., -1:]


def _inside(axis: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Points within all intervals of an axis."""
    return (axis[:-1, None] + np.diff(axis)[:, None] * share).ravel()


def _inside_values(values: np.ndarray, axis: int, share: np.ndarray) -> np.ndarray:
    """Values at the points of `_inside` along one axis of an array."""
    values = np.moveaxis(values, axis, -1)
    made = values[..., :-1, None] + (values[..., 1:] - values[..., :-1])[..., None] * share
    return np.moveaxis(made.reshape(*values.shape[:-1], -1), -1, axis)


def _effective_cosine(table: ScatterTable, s: int) -> np.ndarray:
    """Cosine to the normal, root mean square over an incidence and its neighbours: the cell serves between them too."""
    share = np.linspace(0.0, 1.0, POINTS)
    radials, azimuths = _inside(table.radials, share), _inside(table.azimuths, share)
    # The ends hold down to the normal and up to the horizon.
    incidences = np.concatenate([[0.0], table.incidences, [0.5 * np.pi - 1e-3]])
    square = 0.0
    for each in incidences[s : s + 3]:
        radial, azimuth = np.meshgrid(radials, azimuths, indexing="ij")
        square = square + np.maximum(direction_of(each, radial, azimuth)[..., 2], 0.0) ** 2
    return np.sqrt(square / 3.0)
