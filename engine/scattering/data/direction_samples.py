"""Values that were measured in directions, on a polar grid with holes or anywhere, made continuous.

Polar grids count a radial angle from an axis and an azimuth about it. Whether the axis is the normal or the mirror
direction is all the same here.
"""

from dataclasses import dataclass

import numpy as np

from .table import place_on

SAME = 2e-5
"""Angles that differ by less are one. [rad]"""

MOST_HOLES = 4
"""Grid points to each measured direction, above which directions count as lying on no grid."""

NEAREST = 8
"""Measured directions by which a value between them is made."""

MOST_POINTS = 30_000
"""Directions that lie on no grid, at most."""

CHUNK = 1 << 22
"""Pairs of directions that are compared in one go."""


@dataclass(frozen=True, eq=False)
class PolarGrid:
    """Values on a polar grid, linear in between.

    Parameters
    ----------
    radials : (t,) float64 array    Ascending from 0. [rad]
    azimuths : (a,) float64 array    Ascending from 0 to pi, where both sides are alike, else to 2 pi. [rad]
    values : (t, a, w) float64 array    Without holes.
    """

    radials: np.ndarray
    azimuths: np.ndarray
    values: np.ndarray

    @property
    def is_symmetric(self) -> bool:
        """Whether both sides are alike."""
        return bool(self.azimuths[-1] < 1.5 * np.pi)

    def read(self, radial, azimuth) -> np.ndarray:
        """Values at polar coordinates; the last radial angle holds beyond. (n,), (n,) -> (n, w)"""
        azimuth = np.asarray(azimuth) % (2.0 * np.pi)
        if self.is_symmetric:
            azimuth = np.where(azimuth > np.pi, 2.0 * np.pi - azimuth, azimuth)
        (t, t_share), (a, a_share) = (
            place_on(self.radials, radial),
            place_on(self.azimuths, azimuth),
        )
        found = np.zeros((len(t), self.values.shape[2]))
        last = len(self.radials) - 1
        for row, r_weight in ((t, 1.0 - t_share), (np.minimum(t + 1, last), t_share)):
            for column, a_weight in ((a, 1.0 - a_share), (a + 1, a_share)):
                found += (r_weight * a_weight)[:, None] * self.values[row, column]
        return found


def merge_angles(angles) -> tuple[np.ndarray, np.ndarray]:
    """The angles that occur, ascending and without what rounding sets apart, and the number of each. (k,), (n,)"""
    order = np.argsort(angles, kind="stable")
    ascending = np.asarray(angles, dtype=np.float64)[order]
    is_new = np.append(True, np.diff(ascending) > SAME)
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.cumsum(is_new) - 1
    return ascending[is_new], number


def grid_samples(radial, azimuth, values) -> PolarGrid | None:
    """Put measured directions on a polar grid and fill its holes.

    Holes take what lies between the nearest along the radial angle, or, at azimuths without data, along the azimuth. The
    ends hold. Data of one side only count for both.

    Parameters
    ----------
    radial, azimuth : (n,) arrays    In any order; directions that occur twice are averaged. [rad]
    values : (n, w) array    nan where nothing was measured; something is for every band.

    Returns
    -------
    PolarGrid or None    None: the directions lie on no grid.
    """
    azimuth, is_symmetric = fold_azimuth(azimuth)
    radials, row = merge_angles(radial)
    azimuths, column = merge_angles(azimuth)
    if len(radials) * len(azimuths) > MOST_HOLES * len(row) + 64:
        return None
    sums = np.zeros((len(radials), len(azimuths), values.shape[1]))
    counts = np.zeros(sums.shape)
    good = np.isfinite(values)
    np.add.at(sums, (row, column), np.where(good, values, 0.0))
    np.add.at(counts, (row, column), good)
    with np.errstate(invalid="ignore"):
        grid = sums / counts
    pole = None
    if radials[0] < SAME:
        # One direction, at whatever azimuth it stands.
        pole = sums[0].sum(axis=0) / np.maximum(counts[0].sum(axis=0), 1.0)
        pole = np.where(counts[0].any(axis=0), pole, np.nan)
        radials, grid = radials[1:], grid[1:]
    if not len(radials):
        radials, grid = np.array([0.5 * np.pi]), np.broadcast_to(pole, (1, *grid.shape[1:])).copy()
    _fill_along(radials, grid)
    _fill_around(azimuths, grid, is_symmetric)
    grid, azimuths = _close(grid, azimuths, is_symmetric)
    mean = grid[0, :-1].mean(axis=0) if not is_symmetric else grid[0].mean(axis=0)
    pole = mean if pole is None else np.where(np.isfinite(pole), pole, mean)
    grid = np.concatenate([np.broadcast_to(pole, (1, *grid.shape[1:])), grid])
    return PolarGrid(np.append(0.0, radials), azimuths, grid)


def fold_azimuth(azimuth) -> tuple[np.ndarray, bool]:
    """Azimuths within 0 to 2 pi, or, where all are of one side, within 0 to pi; and whether they are. (n,) [rad]"""
    azimuth = np.asarray(azimuth, dtype=np.float64) % (2.0 * np.pi)
    azimuth = np.where(azimuth > 2.0 * np.pi - SAME, 0.0, azimuth)
    if np.all(azimuth <= np.pi + SAME):
        return np.minimum(azimuth, np.pi), True
    if np.all((azimuth >= np.pi - SAME) | (azimuth <= SAME)):
        return np.clip(np.where(azimuth > SAME, 2.0 * np.pi - azimuth, 0.0), 0.0, np.pi), True
    return azimuth, False


def _fill_along(radials, grid) -> None:
    """Fill holes along the radial angle, where an azimuth has any data in a band; in place."""
    for column, band in np.argwhere(np.isnan(grid).any(axis=0) & ~np.isnan(grid).all(axis=0)):
        line = grid[:, column, band]
        good = np.isfinite(line)
        grid[:, column, band] = np.interp(radials, radials[good], line[good])


def _fill_around(azimuths, grid, is_symmetric: bool) -> None:
    """Fill azimuths that have no data in a band from their neighbours; in place."""
    for band in np.flatnonzero(np.isnan(grid[0]).any(axis=0)):
        good = np.isfinite(grid[0, :, band])
        if not good.any():
            continue
        known, values = azimuths[good], grid[:, good, band]
        if not is_symmetric:
            known = np.concatenate([[known[-1] - 2.0 * np.pi], known, [known[0] + 2.0 * np.pi]])
            values = np.concatenate([values[:, -1:], values, values[:, :1]], axis=1)
        below, share = place_on(known, azimuths)
        above = np.minimum(below + 1, len(known) - 1)
        grid[:, :, band] = values[:, below] * (1.0 - share) + values[:, above] * share


def _close(grid, azimuths, is_symmetric: bool):
    """Add what is missing of the azimuths 0 and pi, or 0 and 2 pi."""
    end = np.pi if is_symmetric else 2.0 * np.pi
    if azimuths[0] > SAME:
        first = grid[:, :1]
        if not is_symmetric:
            share = azimuths[0] / (azimuths[0] + 2.0 * np.pi - azimuths[-1])
            first = grid[:, :1] * (1.0 - share) + grid[:, -1:] * share
        grid, azimuths = np.concatenate([first, grid], axis=1), np.append(0.0, azimuths)
    else:
        azimuths = np.append(0.0, azimuths[1:])
    if not is_symmetric or azimuths[-1] < end - SAME:
        grid = np.concatenate([grid, grid[:, -1:] if is_symmetric else grid[:, :1]], axis=1)
        return grid, np.append(azimuths, end)
    return grid, np.append(azimuths[:-1], end)


@dataclass(frozen=True, eq=False)
class ScatteredSamples:
    """Values in directions that lie on no grid; between them the plane that fits the nearest best.

    Parameters
    ----------
    directions : (n, 3) float64 array    Unit vectors.
    values : (n, w) float64 array
    """

    directions: np.ndarray
    values: np.ndarray

    def read(self, wanted) -> np.ndarray:
        """Values in directions, never beyond those of the nearest; measured ones come back. (m, 3) -> (m, w)"""
        wanted = np.asarray(wanted, dtype=np.float64)
        step = max(CHUNK // len(self.directions), 1)
        parts = [self._read(wanted[k : k + step]) for k in range(0, len(wanted), step)]
        return np.concatenate(parts) if parts else np.zeros((0, self.values.shape[1]))

    def _read(self, wanted) -> np.ndarray:
        count = min(NEAREST, len(self.directions))
        cosine = wanted @ self.directions.T
        near = np.argpartition(-cosine, count - 1, axis=1)[:, :count]
        away = self.directions[near] - wanted[:, None, :]
        square = (away**2).sum(axis=2)
        reach = square.max(axis=1, keepdims=True) + 1e-12
        weight = (1.0 - 0.999 * square / reach) / (square + 1e-6 * reach)
        weight /= weight.sum(axis=1, keepdims=True)
        # Two level directions across the wanted one.
        first = np.cross(
            wanted, np.where(np.abs(wanted[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 1.0, 0]])
        )
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        second = np.cross(wanted, first)
        flat = [(away * axis[:, None, :]).sum(axis=2) for axis in (first, second)]
        terms = np.stack([np.ones_like(square), *flat], axis=2)
        scale = np.sqrt(reach)[:, :, None]
        terms[:, :, 1:] /= scale
        system = np.einsum("nki,nk,nkj->nij", terms, weight, terms)
        # Slopes across what is measured in one plane only are none.
        system += np.diag([0.0, 1e-6, 1e-6])
        values = self.values[near]
        right = np.einsum("nki,nk,nkw->niw", terms, weight, values)
        made = np.linalg.solve(system, right)[:, 0]
        return np.clip(made, values.min(axis=1), values.max(axis=1))
