"""Where tiles of lumels look for light: rays are sent more often into directions from which more comes.

The square from which a ray's direction is made, by the cosine law, is divided into bins. A few rays through every bin of
every tile tell what comes through it. Then bins are chosen in proportion to the root of the mean square of that, which
makes the variance least, and what a ray brings is divided by how often its bin is chosen. Neighbouring bins share what they
found, and some rays go everywhere alike, so that nothing the few rays have missed weighs much.

References
----------
H. Kahn, A. W. Marshall: Methods of Reducing Sample Size in Monte Carlo Computations, J. Oper. Res. Soc. Am. 1(5), 1953.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload

SIDE = 16
"""Bins along each side of the square."""

BINS = SIDE * SIDE

EVEN = 0.3
"""Share of the rays that goes everywhere alike."""

SHARED = 0.25
"""What of a neighbouring bin counts, relative to a bin's own."""


class Cosine:
    """Rays by the cosine law alone."""

    def sample(self, point):
        """Direction in the receiver's frame, and its density. ``point``: Point2f. [sr-1]"""
        local = mi.warp.square_to_cosine_hemisphere(point)
        return local, mi.warp.square_to_cosine_hemisphere_pdf(local)

    def density(self, local):
        """Density of a direction in the receiver's frame; 0 below its horizon. [sr-1]"""
        return dr.maximum(local.z, 0.0) * dr.inv_pi


class Aims:
    """Tables of tiles on the device.

    Parameters
    ----------
    densities : (t, BINS) array    As `find_densities` gives them.
    """

    def __init__(self, densities: np.ndarray):
        table = densities.astype(np.float64).reshape(-1, SIDE, SIDE)
        table /= np.maximum(table.mean(axis=(1, 2), keepdims=True), 1e-30)
        rows = table.sum(axis=2)
        self._densities = upload(mi.Float, table)
        self._rows = upload(mi.Float, _lower_ends(rows))
        self._columns = upload(mi.Float, _lower_ends(table))
        dr.eval(self._densities, self._rows, self._columns)

    def of_tile(self, tile) -> "TileAim":
        """Rays of receivers in tiles. ``tile``: UInt32."""
        return TileAim(self, tile)


@dataclass(frozen=True)
class TileAim:
    """Rays as the tables of tiles have it, in the manner of `Cosine`."""

    aims: Aims
    tile: object

    def sample(self, point):
        """Direction in the receiver's frame, and its density. ``point``: Point2f. [sr-1]"""
        place, factor = self.warp(point)
        local, density = Cosine().sample(place)
        return local, density * factor

    def warp(self, point):
        """Point of the square as bins are chosen, and its density. ``point``: Point2f. [-]"""
        aims = self.aims
        row, x = _choose(aims._rows, self.tile * SIDE, point.x)
        column, y = _choose(aims._columns, (self.tile * SIDE + row) * SIDE, point.y)
        place = mi.Point2f((mi.Float(row) + x) / SIDE, (mi.Float(column) + y) / SIDE)
        index = self.tile * BINS + row * SIDE + column
        return place, dr.gather(mi.Float, aims._densities, index)

    def density(self, local):
        """Density of a direction in the receiver's frame; 0 below its horizon. [sr-1]"""
        above = local.z > 0.0
        place = mi.warp.cosine_hemisphere_to_square(local)
        row, column = (
            mi.UInt32(dr.clip(each * SIDE, 0.0, SIDE - 1.0)) for each in (place.x, place.y)
        )
        index = self.tile * BINS + row * SIDE + column
        factor = dr.gather(mi.Float, self.aims._densities, index, above)
        return dr.select(above, Cosine().density(local) * factor, 0.0)


def find_densities(squares: np.ndarray) -> np.ndarray:
    """Densities by bin, relative to even ones, from mean squares of what rays bring. (t, BINS) -> (t, BINS) float16"""
    around = squares.reshape(-1, SIDE, SIDE)
    padded = np.pad(around, ((0, 0), (1, 1), (1, 1)), mode="edge")
    near = padded[:, :-2, 1:-1] + padded[:, 2:, 1:-1] + padded[:, 1:-1, :-2] + padded[:, 1:-1, 2:]
    root = np.sqrt(around + SHARED * near).reshape(-1, BINS)
    mean = root.mean(axis=1, keepdims=True)
    relative = np.divide(root, mean, out=np.ones_like(root), where=mean > 0.0)
    return (EVEN + (1.0 - EVEN) * relative).astype(np.float16)


def _lower_ends(weights: np.ndarray) -> np.ndarray:
    """Lower ends of the intervals of 0..1 that the weights of the last axis divide."""
    whole = np.cumsum(weights, axis=-1)
    return (whole - weights) / whole[..., -1:]


def _choose(ends, first, number):
    """Interval that holds a number, and the number's place in it. ``ends``: lower ends, those asked from ``first`` on."""
    index, step = mi.UInt32(0), SIDE // 2
    while step:
        reached = dr.gather(mi.Float, ends, first + index + step) <= number
        index = dr.select(reached, index + step, index)
        step //= 2
    low = dr.gather(mi.Float, ends, first + index)
    is_last = index == SIDE - 1
    high = dr.select(is_last, 1.0, dr.gather(mi.Float, ends, first + index + 1, ~is_last))
    place = (number - low) / dr.maximum(high - low, 1e-9)
    return index, dr.clip(place, 0.0, 1.0 - 1e-6)
