"""Light transport by tensor trees, evaluated exactly.

Sampling takes a cell of a grid over both directions, exactly in proportion to the value times the cosine where the tree is
no finer than the grid. Below its cells it goes down the tree, by means over the rest of the incident cell.
"""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...scene.scattering import TensorTree
from ..data.tree import BELOW_HALF, BELOW_ONE, levels_of, means_of, raster_of
from .patch_lobe import LARGEST_SINE_SQUARED, Bands, find_interval, steps_for

FINEST_GRID = {3: 7, 4: 5}
"""Halvings of every coordinate to which sampling follows a tree, by its rank: about a million cells."""

EVEN_SHARE = 0.1
"""Share of samples that spread like the cosine where a tree is finer than the grid, so that weights stay bounded."""

VALUE = 1 << 31
"""Children from this number on are values: their complements."""


class TreeLobe:
    """One side of a material, known by a tensor tree.

    Parameters
    ----------
    tree : TensorTree
    weigh : callable
        (values (..., w), wavelengths (w,)) -> (..., b): what transport uses of the wavelengths, all or one mean of them.
    factor : float    On all values. [-]
    """

    def __init__(self, tree: TensorTree, weigh, factor: float = 1.0):
        values = weigh(tree.values * np.float32(factor), tree.wavelengths)
        tree = replace(tree, values=values)
        self.rank = tree.rank
        self._children = upload(mi.UInt32, tree.children.astype(np.int32).view(np.uint32))
        self._bands = Bands(tree.values, tree.wavelengths)
        depth = len(levels_of(tree))
        levels = min(depth, FINEST_GRID[tree.rank])
        size = 1 << levels
        raster = raster_of(tree, levels).mean(axis=-1).reshape(-1, size, size)
        rows = raster.sum(axis=2)
        total = rows.sum(axis=1)
        self._albedos = upload(mi.Float, total * np.pi / size**2)
        self._rows = upload(mi.Float, _cumulated(rows))
        self._columns = upload(mi.Float, _cumulated(raster))
        self._size = dr.opaque(mi.UInt32, size)
        self._steps = steps_for(size)
        self._is_finer = depth > levels
        if self._is_finer:
            self._levels = dr.opaque(mi.UInt32, levels)
            self._shares = upload(mi.Float, _shares(tree))

    # ---- coordinates ----

    def _incident(self, wi):
        """Incident coordinates within [0, 1). tuple of mi.Float"""
        if self.rank == 4:
            return _square_of(wi.x, wi.y)
        sine = dr.sqrt(dr.square(wi.x) + dr.square(wi.y))
        return (dr.clip(0.5 - 0.5 * sine, 0.0, BELOW_HALF),)

    def _cell_of(self, wi):
        """Number of the grid's incident cell. mi.UInt32"""
        size = mi.Float(self._size)
        number = mi.UInt32(0)
        for place in self._incident(wi):
            number = number * self._size + mi.UInt32(place * size)
        return number

    def _turn(self, wi):
        """Cosine and sine of the azimuth from which outgoing ones count."""
        if self.rank == 4:
            return mi.Float(1.0), mi.Float(0.0)
        sine = dr.sqrt(dr.square(wi.x) + dr.square(wi.y))
        inverse = dr.rcp(dr.maximum(sine, 1e-20))
        return dr.select(sine > 0.0, -wi.x * inverse, -1.0), -wi.y * inverse

    def _outgoing(self, wi, wo):
        c, s = self._turn(wi)
        return _square_of(c * wo.x + s * wo.y, c * wo.y - s * wo.x)

    # ---- transport ----

    def evaluate(self, wi, wo, wavelengths, active):
        """Value times the cosine of wo, and the density of `sample`. mi.Spectrum [1/sr], mi.Float [1/sr]

        Both directions must be above the horizon where ``active``. A sample that rounding takes to where nothing is
        scattered has the density 0.
        """
        u, v = self._outgoing(wi, wo)
        number, within = self._descend((*self._incident(wi), u, v), active)
        value = self._bands.look_up(number, wavelengths, active) * wo.z
        size = mi.Float(self._size)
        cell = self._cell_of(wi)
        row, column = mi.UInt32(u * size), mi.UInt32(v * size)
        step = self._size + 1
        density = dr.square(size) * within
        density *= _share_at(self._rows, cell * step + row, active)
        density *= _share_at(self._columns, (cell * self._size + row) * step + column, active)
        if self._is_finer:
            density = dr.lerp(density, 1.0, EVEN_SHARE)
        return value, density * wo.z * dr.inv_pi

    def _descend(self, coordinates, active):
        """Number of the value at a point of the tree, and density in the grid's cell. mi.UInt32, mi.Float"""

        def body(node, level, within, *places):
            child = node * (1 << self.rank)
            finer = []
            for k, place in enumerate(places):
                upper = place >= 0.5
                child += dr.select(upper, mi.UInt32(1 << k), 0)
                finer.append(2.0 * place - dr.select(upper, mi.Float(1.0), 0.0))
            if self._is_finer:
                below = level >= self._levels
                within *= dr.select(below, dr.gather(mi.Float, self._shares, child, below), 1.0)
            return (dr.gather(mi.UInt32, self._children, child), level + 1, within, *finer)

        start = dr.select(active, mi.UInt32(0), mi.UInt32(VALUE))
        places = [mi.Float(place) for place in coordinates]
        node, _, within, *_ = dr.while_loop(
            state=(start, mi.UInt32(0), mi.Float(1.0), *places),
            cond=lambda node, *_: node < VALUE,
            body=body,
            label="tensor tree",
        )
        return ~node, within

    def sample(self, wi, sample, active):
        """Direction for a point of the unit square. mi.Vector3f"""
        cell = self._cell_of(wi)
        x, is_even = sample.x, mi.Bool(False)
        if self._is_finer:
            is_even = sample.x < EVEN_SHARE
            x = dr.select(is_even, x / EVEN_SHARE, (x - EVEN_SHARE) / (1.0 - EVEN_SHARE))
        row, u = self._choose(self._rows, cell, x, active)
        _, v = self._choose(self._columns, cell * self._size + row, sample.y, active)
        if self._is_finer:
            u, v = self._refine(wi, u, v, active & ~is_even)
            u, v = dr.select(is_even, x, u), dr.select(is_even, sample.y, v)
        disk = mi.warp.square_to_uniform_disk_concentric(mi.Point2f(u, v))
        square = dr.square(disk.x) + dr.square(disk.y)
        # Rounding may take points to the rim, and beyond.
        disk *= dr.select(
            square > LARGEST_SINE_SQUARED, dr.sqrt(LARGEST_SINE_SQUARED / square), 1.0
        )
        z = dr.sqrt(1.0 - dr.minimum(square, LARGEST_SINE_SQUARED))
        c, s = self._turn(wi)
        return mi.Vector3f(c * disk.x - s * disk.y, c * disk.y + s * disk.x, z)

    def _refine(self, wi, u, v, active):
        """Move a point that is even in the grid's cell so that it follows the tree below. mi.Float, mi.Float"""
        known = self.rank - 2

        def body(node, level, width, left, lower, u, v, *places):
            child = node * (1 << self.rank)
            finer = []
            for k, place in enumerate(places):
                upper = place >= 0.5
                child += dr.select(upper, mi.UInt32(1 << k), 0)
                finer.append(2.0 * place - dr.select(upper, mi.Float(1.0), 0.0))
            below = level >= self._levels
            quarters = [
                dr.select(
                    below, dr.gather(mi.Float, self._shares, child + (q << known), below), 1.0
                )
                for q in range(4)
            ]
            width *= 0.5
            u, right = _halve(u, quarters[0] + quarters[2], quarters[1] + quarters[3])
            v, above = _halve(
                v,
                dr.select(right, quarters[1], quarters[0]),
                dr.select(right, quarters[3], quarters[2]),
            )
            left += dr.select(right, width, 0.0)
            lower += dr.select(above, width, 0.0)
            child += dr.select(right, mi.UInt32(1 << known), 0)
            child += dr.select(above, mi.UInt32(2 << known), 0)
            node = dr.gather(mi.UInt32, self._children, child)
            return (node, level + 1, width, left, lower, u, v, *finer)

        start = dr.select(active, mi.UInt32(0), mi.UInt32(VALUE))
        corner = mi.Float(1.0), mi.Float(0.0), mi.Float(0.0)
        places = [mi.Float(place) for place in self._incident(wi)]
        _, _, width, left, lower, u, v, *_ = dr.while_loop(
            state=(start, mi.UInt32(0), *corner, mi.Float(u), mi.Float(v), *places),
            cond=lambda node, *_: node < VALUE,
            body=body,
            label="point of a tensor tree",
        )
        return dr.fma(width, u, left), dr.fma(width, v, lower)

    def _choose(self, table, line, sample, active):
        """Cell of a line of cumulated shares, and a point in it on the unit interval. mi.UInt32, mi.Float"""
        first = line * (self._size + 1)
        place = find_interval(table, first, first + self._size - 1, sample, self._steps, active)
        low = dr.gather(mi.Float, table, place, active)
        high = dr.gather(mi.Float, table, place + 1, active)
        rest = dr.clip((sample - low) / dr.maximum(high - low, 1e-12), 0.0, 1.0)
        place -= first
        return place, (mi.Float(place) + rest) / mi.Float(self._size)

    def reflectance(self, wi, wavelengths, active):
        """Share of light that is scattered, the mean over the bands at every wavelength. (Spectrum)"""
        return mi.Spectrum(self.albedo(wi, active))

    def albedo(self, wi, active):
        """Share of light that is scattered, mean over the wavelengths and the grid's incident cell. mi.Float [-]"""
        return dr.gather(mi.Float, self._albedos, self._cell_of(wi), active)


def _cumulated(cells: np.ndarray) -> np.ndarray:
    """Cumulated shares of cells in lines; even where all are 0. (..., n) -> (..., n + 1) float32"""
    sums = np.zeros((*cells.shape[:-1], cells.shape[-1] + 1))
    np.cumsum(cells, axis=-1, out=sums[..., 1:])
    even = np.linspace(0.0, 1.0, sums.shape[-1])
    total = sums[..., -1:]
    return np.where(total > 0.0, sums / np.where(total > 0.0, total, 1.0), even).astype(np.float32)


def _shares(tree: TensorTree) -> np.ndarray:
    """Density of each child's quarter of the outgoing square, for the incident part that it stands for. (n, 2 ** rank)"""
    means = means_of(tree).mean(axis=-1)[tree.children].reshape(len(tree.children), 4, -1)
    total = means.sum(axis=1, keepdims=True)
    return np.where(total > 0.0, 4.0 * means / np.where(total > 0.0, total, 1.0), 1.0)


def _halve(place, low, high):
    """Place within the half of an interval that weights give a place of the whole; whether it is the upper half."""
    edge = low / (low + high)
    upper = place >= edge
    within = dr.select(
        upper,
        (place - edge) / dr.maximum(1.0 - edge, 1e-12),
        place / dr.maximum(edge, 1e-12),
    )
    return dr.clip(within, 0.0, BELOW_ONE), upper


def _share_at(table, place, active):
    return dr.gather(mi.Float, table, place + 1, active) - dr.gather(mi.Float, table, place, active)


def _square_of(x, y):
    """Point of the unit square, within [0, 1), for a point of the unit disk. mi.Float, mi.Float"""
    point = mi.warp.uniform_disk_to_square_concentric(mi.Point2f(x, y))
    return tuple(dr.clip(c, 0.0, BELOW_ONE) for c in (point.x, point.y))
