"""Where on the disk that covers a scene the light of a sun is worth following.

Through a keyhole a millionth of a sun's light enters. The disk is divided into cells; after a survey the cells from which
light reached what counts, and those around them, get most of the rays. A share of them stays even over the disk, so that
nothing is left out and weights stay bounded.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload

SIDE = 512
"""Cells across the disk."""

RESOLUTION = 1 << 23
"""Different numbers by which cells are chosen, those of a random number in single precision."""

EVEN_SHARE = 0.3
"""Share of the rays that go on being spread evenly."""


class SunMap:
    """Draws points of the unit disk, evenly until it has learned."""

    def __init__(self):
        self._centre = (np.arange(SIDE) + 0.5) / SIDE * 2.0 - 1.0
        # Cells that reach into the disk.
        nearest = np.maximum(np.abs(self._centre) - 1.0 / SIDE, 0.0)
        self._inside = np.add.outer(nearest**2, nearest**2) < 1.0
        self._set(self._inside / self._inside.sum())

    def _set(self, shares: np.ndarray) -> None:
        """Set the probability of every cell, row by row. (SIDE, SIDE)"""
        limits = np.cumsum(shares.ravel())
        # Every cell gets some of the numbers by which cells are chosen, and its probability is their exact share.
        limits = np.round(limits * (RESOLUTION / limits[-1])) / RESOLUTION
        own = np.diff(limits, prepend=0.0)
        limits[np.flatnonzero(own)[-1] :] = 2.0
        self._cdf, self._shares = upload(mi.Float, limits), upload(mi.Float, own)
        dr.eval(self._cdf, self._shares)

    def learn(self, cell: np.ndarray, use: np.ndarray) -> None:
        """Draw by what came of rays.

        Parameters
        ----------
        cell : (n,) int array    Where they were drawn.
        use : (n,) array    What they brought, at least 0.
        """
        count = np.bincount(cell, minlength=SIDE * SIDE)
        total = np.bincount(cell, use, minlength=SIDE * SIDE)
        mean = np.sqrt(np.divide(total, count, out=np.zeros_like(total), where=count > 0))
        mean = mean.reshape(SIDE, SIDE)
        if not mean.sum() > 0.0:
            return
        # What few rays have missed lies next to what they found.
        padded = np.pad(mean, 1)
        spread = sum(padded[i : i + SIDE, j : j + SIDE] for i in range(3) for j in range(3))
        spread = spread * self._inside
        even = self._inside / self._inside.sum()
        self._set(EVEN_SHARE * even + (1.0 - EVEN_SHARE) * spread / spread.sum())

    def draw(self, choice, place):
        """Draw points. ``choice``: a number in [0, 1); ``place``: two.

        Returns
        -------
        (Float, Float)    Coordinates on the disk.
        """
        last = SIDE * SIDE - 1
        cell = dr.binary_search(0, last, lambda i: dr.gather(mi.Float, self._cdf, i) <= choice)
        x = (mi.Float(cell % SIDE) + place.x) * (2.0 / SIDE) - 1.0
        y = (mi.Float(cell // SIDE) + place.y) * (2.0 / SIDE) - 1.0
        return x, y

    def find(self, x, y):
        """Cell of a place and density there.

        Returns
        -------
        (UInt32, Float)    Density over the area of a disk of radius 1, 0 beside the cells.
        """
        column, row = (x + 1.0) * (0.5 * SIDE), (y + 1.0) * (0.5 * SIDE)
        inside = (column >= 0.0) & (column < SIDE) & (row >= 0.0) & (row < SIDE)
        cell = dr.select(inside, mi.UInt32(dr.maximum(row, 0.0)) * SIDE + mi.UInt32(dr.maximum(column, 0.0)), 0)  # fmt: skip
        share = dr.gather(mi.Float, self._shares, cell, inside)
        return cell, dr.select(inside, share * (0.25 * SIDE * SIDE), 0.0)
