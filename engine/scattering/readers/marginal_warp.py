"""The unit square brought to itself so that a density becomes even: marginal along y first, then conditional along x.

The density is bilinear between the points of a grid and may depend on parameters, linear between theirs. Positions where it
is high are spread out, so what is tabulated after the map has its points where the density has its weight.

References
----------
Dupuy & Jakob, An adaptive parameterization for efficient material acquisition and rendering, doi:10.1145/3272127.3275059
"""

import numpy as np

from ..data.table import place_on


class Slices:
    """Grids of values that depend on parameters, linear between the points of each and constant beyond the ends.

    Parameters
    ----------
    axes : sequence of (k,) arrays    Parameters, ascending.
    """

    def __init__(self, axes):
        self.axes = [np.asarray(axis, dtype=np.float64) for axis in axes]

    def corners(self, parameters) -> list[tuple[np.ndarray, np.ndarray]]:
        """Numbers of the grids around parameters, each (n,), counted with the last axis fastest; and their weights.

        Both are of one element where no axis has more than one point.
        """
        found = [(np.zeros(1, dtype=np.int64), np.ones(1))]
        for axis, value in zip(self.axes, parameters, strict=True):
            if len(axis) == 1:
                continue
            below, share = place_on(axis, value)
            found = [
                (number * len(axis) + step, weight * part)
                for number, weight in found
                for step, part in ((below, 1.0 - share), (below + 1, share))
            ]
        return found


def place_in(count: int, value) -> tuple[np.ndarray, np.ndarray]:
    """Cell of an even grid of points over 0 to 1 in which values lie, and where within it. (n,), (n,)"""
    scaled = np.clip(value, 0.0, 1.0) * (count - 1)
    cell = np.minimum(scaled.astype(np.int64), count - 2)
    return cell, scaled - cell


def read_bilinear(grid: np.ndarray, x, y) -> np.ndarray:
    """Values of a grid (rows, columns) over the unit square, x along the columns. (n,)"""
    (row, down), (column, along) = place_in(grid.shape[0], y), place_in(grid.shape[1], x)
    upper = grid[row, column] * (1.0 - along) + grid[row, column + 1] * along
    lower = grid[row + 1, column] * (1.0 - along) + grid[row + 1, column + 1] * along
    return upper * (1.0 - down) + lower * down


class MarginalWarp:
    """A density on the unit square that is made even.

    Parameters
    ----------
    density : (p, t, r, c) array    At parameters, on rows along y and columns along x. Not negative; each grid has a sum.
    slices : Slices    The parameters of the first two axes.
    """

    def __init__(self, density, slices: Slices):
        density = np.asarray(density, dtype=np.float64)
        density = density.reshape(-1, *density.shape[2:])
        _, rows, columns = density.shape
        self.slices = slices
        # Integrals along each row up to every column, and over all of x up to every row.
        along = np.zeros(density.shape)
        np.cumsum(0.5 * (density[..., 1:] + density[..., :-1]), axis=2, out=along[..., 1:])
        along /= columns - 1
        row = along[..., -1]
        down = np.zeros(row.shape)
        np.cumsum(0.5 * (row[:, 1:] + row[:, :-1]), axis=1, out=down[:, 1:])
        down /= rows - 1
        whole = down[:, -1]
        self.density = density / whole[:, None, None]
        self.along = along / whole[:, None, None]
        self.down = down / whole[:, None]

    def make_even(self, x, y, corners) -> tuple[np.ndarray, np.ndarray]:
        """Where positions come to lie once the density is even.

        Parameters
        ----------
        x, y : (n,) arrays    Within 0 to 1.
        corners : list    What `Slices.corners` returns for the parameters.

        Returns
        -------
        (n,), (n,) arrays    Within 0 to 1; 0 in x where a row carries nothing.
        """
        rows, columns = self.density.shape[1:]
        (row, v), (column, u) = place_in(rows, y), place_in(columns, x)
        density, along = self.density.ravel(), self.along.ravel()
        part, whole, below = 0.0, 0.0, 0.0
        for number, weight in corners:
            sides = []
            for r in (row, row + 1):
                line = number * rows + r
                at = line * columns + column
                low, high = density.take(at), density.take(at + 1)
                cell = (low + 0.5 * (high - low) * u) * u / (columns - 1)
                sides.append((along.take(at) + cell, along.take(line * columns + columns - 1)))
            (upper, upper_row), (lower, lower_row) = sides
            part = part + weight * ((1.0 - v) * upper + v * lower)
            whole = whole + weight * ((1.0 - v) * upper_row + v * lower_row)
            within = (upper_row + 0.5 * (lower_row - upper_row) * v) * v / (rows - 1)
            below = below + weight * (self.down[number, row] + within)
        share = np.where(whole > 0.0, part / np.where(whole > 0.0, whole, 1.0), 0.0)
        return np.clip(share, 0.0, 1.0), np.clip(below, 0.0, 1.0)
