"""Where paths of sensors land on cells: the sun on a cell counts there, not all over it.

A cell of the ground may go on under a building, where nobody sees it and no sun shines. So paths are followed before any
light is asked for, and points are kept of where they met each cell, by the light that they carry back. What sensors at one
end of them all see of a cell is kept apart from what those at the other end see: how much more sun there is on the one than
on the other tells by how much a single sensor may be off the mean.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from .sun_rays import HALVES

PATHS = 1 << 16
"""That are followed."""

DEPTHS = 8
"""Matt surfaces of each of which the place is kept."""

SIDE = 8
"""Points along both sides of a square that stands for a cell: first along one side of it, then along the other."""

FEWEST = 32
"""Landings of a half from which on they stand for where a cell is met; with less points are taken all over it."""


class LandingTable:
    """Notes where paths land, as a `SkyTable` puts down what they find.

    Parameters
    ----------
    sides : (s,) array    Of cells that are known.
    order : (lanes,) array    By which the sensors of the launch's paths are told apart, see `find_order`.
    """

    reads = False

    def __init__(self, sides: np.ndarray, order: np.ndarray):
        self.sides, self._order = sides, order
        count = len(order) * DEPTHS
        self.side = dr.zeros(mi.UInt32, count)
        self.x, self.y, self.amount = (dr.zeros(mi.Float, count) for _ in range(3))
        dr.eval(self.side, self.x, self.y, self.amount)

    def put(self, row, direction, light, share, part, active) -> None:
        """Light is not asked for."""

    def put_cell(self, row, side, local, depth, light, active) -> None:
        """Note where a path meets a cell."""
        amount = light.amount
        active = active & (depth <= DEPTHS) & dr.isfinite(amount) & (amount > 0.0)
        lane = dr.arange(mi.UInt32, dr.width(row))
        index = lane * DEPTHS + dr.maximum(depth, 1) - 1
        dr.scatter(self.side, side, index, active)
        dr.scatter(self.x, local.x, index, active)
        dr.scatter(self.y, local.y, index, active)
        dr.scatter(self.amount, amount, index, active)

    def read(self) -> "Landings":
        """What was noted."""
        kept = np.flatnonzero(np.array(self.amount) > 0.0)
        side, x, y, amount = (
            np.array(each)[kept] for each in (self.side, self.x, self.y, self.amount)
        )
        column = np.minimum(np.searchsorted(self.sides, side), max(len(self.sides) - 1, 0))
        known = self.sides[column] == side if len(self.sides) else np.zeros(len(side), dtype=bool)
        order = self._order[kept // DEPTHS]
        found = order, column, x, y, amount
        return Landings.of(len(self.sides), *(each[known] for each in found))


@dataclass(frozen=True, eq=False)
class Landings:
    """Points where paths meet the sides of cells.

    Parameters
    ----------
    points : (2, s, SIDE * SIDE, 2) float32 array    By half of the sensors; places within the cell. [-]
    known : (2, s) bool array    Where there are enough of them.
    """

    points: np.ndarray
    known: np.ndarray

    @staticmethod
    def of(sides: int, order, column, x, y, amount) -> "Landings":
        """Choose points of every side by the light that paths carry back from them.

        Parameters
        ----------
        sides : int
        order : (n,) array    Of the sensor; those of a side with the lower half of its light are the first half.
        column : (n,) int array    Number of the side.
        x, y : (n,) array    Places within the cell. [-]
        amount : (n,) array    Light.
        """
        ascending = np.lexsort((order, column))
        rank = _rank(column[ascending], amount[ascending])
        half = np.empty(len(column), dtype=int)
        half[ascending] = rank * HALVES
        points = np.zeros((HALVES, sides, SIDE * SIDE, 2), dtype=np.float32)
        known = np.zeros((HALVES, sides), dtype=bool)
        for number in range(HALVES):
            own = np.flatnonzero(half == number)
            known[number] = np.bincount(column[own], minlength=sides) >= FEWEST
            points[number] = _choose(sides, column[own], x[own], y[own], amount[own])
        return Landings(points, known)

    def on_device(self) -> "DeviceLandings":
        """For kernels."""
        return DeviceLandings(
            upload(mi.Float, self.points[..., 0].ravel()),
            upload(mi.Float, self.points[..., 1].ravel()),
            upload(mi.Bool, self.known.ravel()),
            self.known.shape[1],
        )


@dataclass(frozen=True, eq=False)
class DeviceLandings:
    """`Landings` in the device's memory, for so many sides."""

    x: object
    y: object
    known: object
    sides: int

    def place(self, half: int, row, point):
        """Where a point of a unit square lies within the cell of a side, once it is spread as landings are. Point2f"""
        start = dr.opaque(mi.UInt32, half * self.sides) + row
        across, up = (dr.minimum(mi.UInt32(each * SIDE), SIDE - 1) for each in (point.x, point.y))
        index = start * (SIDE * SIDE) + across * SIDE + up
        is_known = dr.gather(mi.Bool, self.known, start)
        x, y = (dr.gather(mi.Float, each, index, is_known) for each in (self.x, self.y))
        return mi.Point2f(dr.select(is_known, x, point.x), dr.select(is_known, y, point.y))


def find_order(positions: np.ndarray) -> np.ndarray:
    """Return places of sensors (n, 3) along the direction in which they lie farthest apart. (n,) [m]"""
    apart = positions - positions.mean(axis=0)
    _, _, axes = np.linalg.svd(apart.T @ apart)
    return apart @ axes[0]


def _choose(sides: int, column, x, y, amount) -> np.ndarray:
    """Points of all sides, as of `Landings`, from landings of a half. (s, SIDE * SIDE, 2)"""
    if not len(x):
        return np.zeros((sides, SIDE * SIDE, 2), dtype=np.float32)
    order = np.lexsort((x, column))
    strip = np.empty(len(x), dtype=np.int64)
    strip[order] = np.minimum(_rank(column[order], amount[order]) * SIDE, SIDE - 1)
    strip += SIDE * column
    order = np.lexsort((y, strip))
    # Where a strip begins, and a rank within it: where none is, its neighbour's will do.
    place = strip[order] + _rank(strip[order], amount[order])
    asked = (np.arange(SIDE * SIDE * sides) + 0.5) / SIDE
    found = order[np.minimum(np.searchsorted(place, asked), len(order) - 1)]
    return np.stack([x[found], y[found]], axis=-1).reshape(sides, SIDE * SIDE, 2)


def _rank(group: np.ndarray, amount: np.ndarray) -> np.ndarray:
    """Share of their group's amounts that lies before the middle of each; groups ascend. (n,) [-]"""
    above = np.concatenate([[0.0], np.cumsum(amount, dtype=np.float64)])
    first, last = (np.searchsorted(group, group, side) for side in ("left", "right"))
    whole = above[last] - above[first]
    return np.clip((above[:-1] + 0.5 * amount - above[first]) / whole, 0.0, np.nextafter(1.0, 0.0))
