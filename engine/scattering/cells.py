"""What drawing directions from a table needs: how likely each of its cells is, for each of its incidences.

A cell lies between neighbouring radial angles and azimuths. Within it directions are drawn evenly over solid angle, so
that the density is one number per cell; it follows the root mean square of f cos in the cell, the density of least
variance among those, and never falls below a part of the largest value there, which bounds every weight.
"""

from dataclasses import dataclass

import numpy as np

from ..scene.scattering import ScatterTable
from .table import albedo_of, direction_of, is_symmetric

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
    albedo : (p, s) float64 array    Mean over the bands of what is scattered. [-]
    """

    density: np.ndarray
    radial: np.ndarray
    azimuth: np.ndarray
    albedo: np.ndarray


def prepare_cells(table: ScatterTable) -> TableCells:
    """Find how likely the cells of a table are."""
    mean = table.values.mean(axis=-1, dtype=np.float64)
    share = np.linspace(0.0, 1.0, POINTS)
    radials = _inside(table.radials, share)
    azimuths = _inside(table.azimuths, share)
    f = _inside_values(_inside_values(mean, 2, share), 3, share)
    cosine = _effective_cosine(table.incidences, radials, azimuths)
    shape = (*f.shape[:2], len(table.radials) - 1, POINTS, len(table.azimuths) - 1, POINTS)
    value = (f * cosine).reshape(shape).swapaxes(3, 4)
    rms = np.sqrt((value**2).mean(axis=(4, 5)))
    wanted = np.maximum(rms, LEAST * value.max(axis=(4, 5)))
    ring = np.abs(np.diff(np.cos(table.radials)))[:, None]
    sides = 2.0 if is_symmetric(table) else 1.0
    angle = ring * np.diff(table.azimuths) * sides
    mass = wanted * angle
    total = mass.sum(axis=(2, 3), keepdims=True)
    mass = np.where(total > 0.0, mass / np.maximum(total, 1e-300), angle / angle.sum())
    rings = mass.sum(axis=3)
    within = np.where(
        rings[..., None] > 0.0, mass / np.maximum(rings[..., None], 1e-300), 1.0 / mass.shape[3]
    )
    albedo = [[albedo_of(table, s, p).mean() for s in table.incidences] for p in table.rotations]
    return TableCells(
        mass / np.maximum(angle, 1e-300), _cumulative(rings), _cumulative(within), np.array(albedo)
    )


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


def _effective_cosine(incidences, radials, azimuths) -> np.ndarray:
    """Cosine to the normal, root mean square over an incidence and its neighbours: the cell serves between them too."""
    before = np.concatenate([incidences[:1], incidences[:-1]])
    after = np.concatenate([incidences[1:], incidences[-1:]])
    square = 0.0
    for each in (before, incidences, after):
        grid = np.meshgrid(each, radials, azimuths, indexing="ij")
        square = square + np.maximum(direction_of(*grid)[..., 2], 0.0) ** 2
    return np.sqrt(square / 3.0)[None]
