"""Cells: coarse elements of all matt surfaces that hold the light which falls on them, for gathering to read.

A triangle larger than a cell is divided along two of its edges; smaller ones that lie together and face the same way share a
cell. Front and back are apart. What is held is the irradiance that passes the surface's coat (see `diffuse`).

The light is found by sweeps: every cell gathers from the cells of the sweep before, so each adds one interreflection more,
until the rest is negligible. Before every pass of a job one more sweep, with points of its own, takes the place of the old
values.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ..compiled.diffuse import DiffuseTable
from .bands import Bands
from .cell_division import (
    PLACES,
    Elements,
    areas_of,
    divide,
    find_neighbours,
    growth,
    share_inside,
    turn,
    unpack_grid,
)

EVEN_SHARE = 0.1
"""Share of the cells that is spread over all surfaces by area."""

FEWEST_DEPOSITS, LEAST_BOX, MOST_BOX = 16, 1.0 / 256.0, 0.5
"""Traced paths in a cell from which on they tell where in it their light lies; least side of that box, and the share of the
cell from which on it is the whole cell. [-]"""

FRONT, BACK = 0, 1


class CellSet:
    """Cells of a compiled scene, with their values on the device.

    Parameters
    ----------
    scene : CompiledScene
    count : int    About how many cells there may be.
    importance : callable
        Says how often a job looks at each shape: numbers of shapes (n,) to shares (n,). The more often, the finer.
    refine : callable or None    Gives a factor on ``count``, from the sizes of cells by shape that it would make. [m]

    Attributes
    ----------
    sizes : (shapes,) array    Of cells, by the number of their shape; 0 for what has none. [m]
    """

    def __init__(self, scene, count: int, importance, refine=None):
        self.scene = scene
        self.matt = DiffuseTable(scene)
        self.bands = Bands(scene.mean_light)
        offsets, near, sizes, made = self._divide(count, importance, refine)
        cells = sum(len(m.area) for m in made)
        self.count = cells
        self.area = np.concatenate([m.area for m in made]) if made else np.zeros(0)
        self._offsets = upload(mi.UInt32, offsets)
        self._first = upload(mi.UInt32, _join([m.first for m in made]))
        self._grid = upload(mi.UInt32, _join([m.grid for m in made]))
        self._shape = upload(mi.UInt32, _join([m.shape for m in made]))
        self.shapes = _join([m.shape[:, 0] for m in made])
        self._prim = upload(mi.UInt32, _join([m.prim for m in made]))
        self._uv = upload(mi.Float, _join([m.uv for m in made]))
        self.whole = np.concatenate([m.whole for m in made]) if made else np.zeros(0)
        self.sides = np.flatnonzero(np.repeat(self.area > 0.0, 2)).astype(np.uint32)
        # In memory from the first: what is known to be zero would make kernels of its own.
        self.values = dr.opaque(mi.Float, 0.0, max(2 * cells * self.bands.count, 1))
        self.uneven = dr.opaque(mi.Bool, False, max(2 * cells, 1))
        self._put_members(made)
        self._near = upload(mi.Float, near)
        self.sizes = near
        self.neighbours = find_neighbours(made, sizes)
        # Light traced from the lights, see `put_traced`.
        self.traced = None
        self._boxes = None
        # Guide to that light for points that paths come to, see `cell_guide.choose_spots`.
        self.spots = None
        self._host_table = (
            offsets,
            _join([m.first for m in made]).astype(np.int64),
            _join([m.grid for m in made]).astype(np.int64),
        )
        self._corner = self._find_corners()
        dr.eval(
            self._offsets, self._first, self._grid, self._shape, self._prim, self._uv, self.values
        )
        dr.eval(self.uneven, self._near)

    def _divide(self, count: int, importance, refine):
        """Cells of all shapes, part by part with their sizes; first triangles and sizes by the numbers of shapes."""
        scene = self.scene
        wanted = set(self.matt.shapes)
        parts = [part for _, part, _ in scene.parts() if part.number in wanted]
        triangles = {part.number: scene.triangles(part) for part in parts}
        # By place, so that the order of ids decides nothing.
        parts.sort(key=lambda part: tuple(triangles[part.number][0].ravel().tolist()))
        areas = np.array([float(areas_of(triangles[part.number]).sum()) for part in parts])
        shares = np.asarray(importance([part.number for part in parts]), dtype=np.float64)
        # A share of the cells for every part by its area, so that nothing is coarse beyond all measure.
        shares = EVEN_SHARE * areas / max(areas.sum(), 1e-300) + (1.0 - EVEN_SHARE) * shares
        near = np.zeros(scene.shape_count)
        numbers = [part.number for part in parts]

        def find_sizes(count: float) -> np.ndarray:
            sizes = np.sqrt(2.0 * areas / np.maximum(count * shares, 1e-9))
            sizes = np.maximum(sizes, 1e-9)
            return sizes * growth(triangles, parts, sizes, 4 * max(int(count), 1))

        sizes = near[numbers] = find_sizes(count)
        if refine is not None:
            sizes = near[numbers] = find_sizes(count * refine(near))
        offsets = np.zeros(scene.shape_count, dtype=np.uint32)
        start, made, cells = 0, [], 0
        for part, size in zip(parts, sizes, strict=True):
            offsets[part.number] = start
            start += len(triangles[part.number])
            made.append(divide(triangles[part.number], part.number, float(size), cells))
            cells += len(made[-1].area)
        return offsets, near, sizes, made

    def _find_corners(self) -> np.ndarray:
        """Cells along both edges of every cell's triangle, and the first cell there. (c, 3)"""
        _, first, grid = self._host_table
        made = np.ones((self.count, 3))
        across, up, _ = unpack_grid(grid)
        if self.count:
            # Triangles come in the order of their cells; of those that share one any will do.
            made[first[: len(grid)]] = np.column_stack([across, up, first])
            is_begun = np.zeros(self.count, dtype=bool)
            is_begun[first] = True
            made = made[np.maximum.accumulate(np.where(is_begun, np.arange(self.count), 0))]
        return made

    def _put_members(self, made: list[Elements]) -> None:
        """Upload which triangles share cells."""
        counts = np.array([len(m.members) for m in made], dtype=np.int64)
        begins = np.cumsum(counts) - counts
        firsts = [m.first_member + begin for m, begin in zip(made, begins, strict=True)]
        firsts = np.concatenate([*firsts, [counts.sum()]]).astype(np.uint32)
        # Halvings that find one of them; 0: no cell is shared.
        self._halvings = int(np.diff(firsts.astype(np.int64)).max(initial=0)).bit_length()
        self.shared = np.diff(firsts.astype(np.int64)) > 0
        self._first_member = upload(mi.UInt32, firsts)
        none = [np.zeros(1)]
        self._members = upload(mi.UInt32, _join([m.members for m in made] + none))
        self._member_ends = upload(mi.Float, _join([m.ends for m in made] + none))
        dr.eval(self._first_member, self._members, self._member_ends)

    def __bool__(self) -> bool:
        """Whether there is anything to read."""
        return self.count > 0

    def put_traced(self, deposits) -> None:
        """Take the light that traced paths brought, as irradiance that passes the coat (`light_paths.Deposits`)."""
        side, passing, local = self._find_deposits(deposits)
        flux = np.bincount(side, deposits.flux * passing, 2 * self.count)
        area = np.repeat(self.area, 2)
        light = np.where(area > 0.0, flux / np.where(area > 0.0, area, 1.0), 0.0)
        # One number for all wavelengths: as if its spectrum were the mean light's.
        self.traced = upload(mi.Float, light / self.bands.illuminance())
        boxes = self._find_boxes(side[passing > 0.0], local[passing > 0.0])
        self._boxes = upload(mi.Float, boxes)
        dr.eval(self.traced, self._boxes)

    def sides_of(self, deposits) -> tuple[np.ndarray, np.ndarray]:
        """Sides of cells on which light landed, and how much of it passes the coat: 0 without cells. (m,), (m,)"""
        return self._find_deposits(deposits)[:2]

    def _find_deposits(self, deposits):
        """As `sides_of`, and where in their cells, in sides of these (m, 2)."""
        offsets, first, grid = self._host_table
        shape = deposits.shape.astype(np.int64)
        passing = self.matt.passing(shape, deposits.cosine)
        triangle = np.where(passing > 0.0, offsets[shape] + deposits.prim.astype(np.int64), 0)
        across, up, corner = unpack_grid(grid[triangle])
        u, v = turn(deposits.uv[:, 0], deposits.uv[:, 1], corner)
        i = np.minimum((u * across).astype(np.int64), across - 1)
        j = np.minimum((v * up).astype(np.int64), up - 1)
        side = 2 * (first[triangle] + j * across + i) + deposits.back
        local = np.stack([u * across - i, v * up - j], axis=1)
        return np.where(passing > 0.0, side, 0), passing, local

    def _find_boxes(self, side: np.ndarray, local: np.ndarray) -> np.ndarray:
        """Boxes around what landed on each side. (2 c, 5)

        Low and high corner in sides of the cell, and how much more light there is in the box than on the mean.
        """
        boxes = np.tile([0.0, 0.0, 1.0, 1.0, 1.0], (2 * max(self.count, 1), 1))
        order = np.argsort(side, kind="stable")
        found, begins, many = np.unique(side[order], return_index=True, return_counts=True)
        if not len(found):
            return boxes
        low = np.minimum.reduceat(local[order], begins, axis=0)
        high = np.maximum.reduceat(local[order], begins, axis=0)
        # The outermost of n even points lie so far within.
        margin = (high - low) / np.maximum(many - 1, 1)[:, None]
        margin = np.maximum(margin, 0.5 * (LEAST_BOX - (high - low)))
        low, high = np.clip(low - margin, 0.0, 1.0), np.clip(high + margin, 0.0, 1.0)
        width = high - low
        is_small = (many >= FEWEST_DEPOSITS) & (width.prod(axis=1) < MOST_BOX)
        # Triangles that share a cell have no sides to count by.
        is_small &= ~self.shared[found // 2]
        found, low, high, width = (each[is_small] for each in (found, low, high, width))
        cell = found // 2
        across, up, begin = self._corner[cell].T
        place = (found // 2 - begin) % across, (found // 2 - begin) // across
        u, v = (place[0] + low[:, 0]) / across, (place[1] + low[:, 1]) / up
        part = share_inside(u, v, across / width[:, 0], up / width[:, 1])
        lit = part * width.prod(axis=1) * self.whole[cell]
        factor = np.divide(self.area[cell], lit, out=np.ones(len(lit)), where=lit > 0.0)
        boxes[found] = np.column_stack([low, high, factor])
        return boxes

    # ---- inside kernels ----

    def side(self, shape, prim, uv, is_back, active):
        """Number of the cell's side at a hit. ``uv``: barycentric."""
        return self.locate(shape, prim, uv, is_back, active)[0]

    def locate(self, shape, prim, uv, is_back, active):
        """Number of the cell's side at a hit, and where in it: Point2f in sides of a cell. ``uv``: barycentric."""
        number = dr.reinterpret_array(mi.UInt32, shape)
        triangle = dr.gather(mi.UInt32, self._offsets, number, active) + prim
        grid = dr.gather(mi.UInt32, self._grid, triangle, active)
        across, up, corner = unpack_grid(grid)
        w = 1.0 - uv.x - uv.y
        u = dr.select(corner == 0, uv.x, dr.select(corner == 1, uv.y, w))
        v = dr.select(corner == 0, uv.y, dr.select(corner == 1, w, uv.x))
        x, y = dr.maximum(u, 0.0) * mi.Float(across), dr.maximum(v, 0.0) * mi.Float(up)
        i, j = dr.minimum(mi.UInt32(x), across - 1), dr.minimum(mi.UInt32(y), up - 1)
        cell = dr.gather(mi.UInt32, self._first, triangle, active) + j * across + i
        side = 2 * cell + dr.select(is_back, mi.UInt32(BACK), mi.UInt32(FRONT))
        return side, mi.Point2f(x - mi.Float(i), y - mi.Float(j))

    def near(self, shape, active):
        """Size of the cells of a shape. [m]"""
        return dr.gather(mi.Float, self._near, dr.reinterpret_array(mi.UInt32, shape), active)

    def value(self, side, wavelengths, active):
        """Spectral irradiance that passes the coat."""
        return self.bands.read(self.values, side, wavelengths, active)

    def traced_value(self, side, local, wavelengths, active):
        """Spectral irradiance that traced paths bring and that passes the coat. ``local``: as of `locate`."""
        light = dr.gather(mi.Float, self.traced, side, active)
        return self.bands.grey(light * self.concentration(side, local, active), wavelengths)

    def concentration(self, side, local, active):
        """Traced light at a point of a cell, relative to its mean. [-]"""
        low, high, factor = self.box(side, active)
        is_in = (local.x >= low.x) & (local.y >= low.y) & (local.x <= high.x) & (local.y <= high.y)
        return dr.select(is_in, factor, 0.0)

    def box(self, side, active):
        """Box in which traced light lies, in sides of the cell, and its `concentration` there. (Point2f, Point2f, Float)"""
        a, b, c, d, factor = (
            dr.gather(mi.Float, self._boxes, side * 5 + k, active) for k in range(5)
        )
        return mi.Point2f(a, b), mi.Point2f(c, d), factor

    def point(self, side, sample):
        """Surface at a point of a cell, seen from that side; its row; and whether it lies in the triangle.

        Points are even over the whole cell of a grid, or over all triangles that share a cell. ``sample``: Point2f.
        """
        cell = side // 2
        shape = dr.gather(mi.UInt32, self._shape, cell * PLACES)
        prim = dr.gather(mi.UInt32, self._prim, cell * PLACES)
        triangle = dr.gather(mi.UInt32, self._offsets, shape) + prim
        grid = dr.gather(mi.UInt32, self._grid, triangle)
        # Lanes that are not there read zero, and must not divide by it.
        across, up, corner = unpack_grid(grid)
        across, up = dr.maximum(across, 1), dr.maximum(up, 1)
        local = cell - dr.gather(mi.UInt32, self._first, triangle)
        u = (mi.Float(local % across) + sample.x) / mi.Float(across)
        v = (mi.Float(local // across) + sample.y) / mi.Float(up)
        w = 1.0 - u - v
        place = mi.Point2f(
            dr.select(corner == 0, u, dr.select(corner == 1, w, v)),
            dr.select(corner == 0, v, dr.select(corner == 1, u, w)),
        )
        inside = w > 0.0
        if self._halvings:
            shared, member, point = self._member(cell, sample)
            prim = dr.select(shared, member, prim)
            place, inside = dr.select(shared, point, place), inside | shared
        si = self._turned(self.scene.interaction_at(shape, prim, place), side)
        return si, self.matt.row(si.shape, True), inside

    def _member(self, cell, sample):
        """Whether triangles share a cell; one of these, drawn by area; and an even point on it."""
        low = dr.gather(mi.UInt32, self._first_member, cell)
        end = dr.gather(mi.UInt32, self._first_member, cell + 1)
        shared, begin = end > low, mi.UInt32(low)
        high = dr.select(shared, end - 1, low)
        for _ in range(self._halvings):
            middle = (low + high) // 2
            beyond = dr.gather(mi.Float, self._member_ends, middle, shared) <= sample.x
            low = dr.select(beyond & (low < high), middle + 1, low)
            high = dr.select(beyond, high, dr.maximum(middle, low))
        left = dr.gather(mi.Float, self._member_ends, low - 1, shared & (low > begin))
        right = dr.gather(mi.Float, self._member_ends, low, shared)
        rest = dr.clip((sample.x - left) / dr.maximum(right - left, 1e-12), 0.0, 1.0)
        root = dr.sqrt(rest)
        member = dr.gather(mi.UInt32, self._members, low, shared)
        return shared, member, mi.Point2f(root * (1.0 - sample.y), root * sample.y)

    def place(self, side, number, active=True):
        """Surface at a point of a cell's side, seen from that side, and what the matt table knows it as.

        Parameters
        ----------
        side : UInt32
        number : UInt32    Which of its `PLACES` points.
        """
        point = (side // 2) * PLACES + number
        shape = dr.gather(mi.UInt32, self._shape, point, active)
        si = self.scene.interaction_at(
            shape,
            dr.gather(mi.UInt32, self._prim, point, active),
            dr.gather(mi.Point2f, self._uv, point, active),
            active,
        )
        si = self._turned(si, side)
        return si, self.matt.row(si.shape, active)

    @staticmethod
    def _turned(si, side):
        turn = dr.select(side % 2 == BACK, -1.0, 1.0)
        si.n *= turn
        si.sh_frame = mi.Frame3f(si.sh_frame.n * turn)
        si.t = mi.Float(0.0)
        return si


def _join(arrays) -> np.ndarray:
    return np.concatenate([a.reshape(-1) for a in arrays]) if arrays else np.zeros(4, np.uint32)
