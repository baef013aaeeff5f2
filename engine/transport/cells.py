"""Cells: coarse elements of all matt surfaces that hold the light which falls on them, for gathering to read.

A triangle larger than a cell is divided along two of its edges; smaller ones that lie together and face the same way share a
cell. Front and back are apart. What is held is the irradiance that passes the surface's coat (see `matt`).

The light is found by sweeps: every cell gathers from the cells of the sweep before, so each adds one interreflection more,
until the rest is negligible. Before every pass of a job one more sweep, with points of its own, takes the place of the old
values.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import upload
from .bands import Bands
from .matt import MattTable

PLACES = 16
"""Points of every cell from which it gathers, four for each quarter of it."""

GROUPED = 0.02
"""Triangles of less than this share of a cell's area join others. [-]"""

EVEN_SHARE = 0.1
"""Share of the cells that is spread over all surfaces by area."""

LARGEST_GRID = 2048
"""Most cells along an edge of a triangle."""

FRONT, BACK = 0, 1


@dataclass(frozen=True)
class _Elements:
    """Cells of all shapes on the host. See `divide`.

    Parameters
    ----------
    first : (t,) uint32    First cell of every triangle.
    grid : (t,) uint32    Cells along its first edge, plus 65536 times those along the second.
    shape, prim : (c, PLACES) uint32; uv : (c, PLACES, 2) float32    Points of every cell.
    area : (c,) float64    0 for cells outside their triangle. [m2]
    has_next : (c,) bool; to_above : (c,) int    Neighbours in the grid of a triangle, see `CellSet`.
    whole : (c,) float64    Area of a cell of the grid, the part outside the triangle included; 0 for grouped ones. [m2]
    """

    first: np.ndarray
    grid: np.ndarray
    shape: np.ndarray
    prim: np.ndarray
    uv: np.ndarray
    area: np.ndarray
    has_next: np.ndarray
    to_above: np.ndarray
    whole: np.ndarray


class CellSet:
    """Cells of a compiled scene, with their values on the device.

    Parameters
    ----------
    scene : CompiledScene
    count : int    About how many cells there may be.
    importance : callable
        Says how often a job looks at each shape: numbers of shapes (n,) to shares (n,). The more often, the finer.
    """

    def __init__(self, scene, count: int, importance):
        self.scene = scene
        self.matt = MattTable(scene)
        self.bands = Bands(scene.mean_light)
        wanted = set(self.matt.shapes)
        parts = [part for _, part, _ in scene.parts() if part.number in wanted]
        triangles = {part.number: scene.triangles(part) for part in parts}
        # By place, so that the order of ids decides nothing.
        parts.sort(key=lambda part: tuple(triangles[part.number][0].ravel().tolist()))
        areas = np.array([float(_areas(triangles[part.number]).sum()) for part in parts])
        shares = np.asarray(importance([part.number for part in parts]), dtype=np.float64)
        # A share of the cells for every part by its area, so that nothing is coarse beyond all measure.
        shares = EVEN_SHARE * areas / max(areas.sum(), 1e-300) + (1.0 - EVEN_SHARE) * shares
        sizes = np.sqrt(2.0 * areas / np.maximum(count * shares, 1e-9))
        sizes = np.maximum(sizes, 1e-9)
        offsets = np.zeros(scene.shape_count, dtype=np.uint32)
        start, made, cells = 0, [], 0
        sizes *= _growth(triangles, parts, sizes, 4 * max(count, 1))
        near = np.zeros(scene.shape_count)
        for part, size in zip(parts, sizes, strict=True):
            offsets[part.number], near[part.number] = start, size
            start += len(triangles[part.number])
            made.append(divide(triangles[part.number], part.number, float(size), cells))
            cells += len(made[-1].area)
        self.count = cells
        self.area = np.concatenate([m.area for m in made]) if made else np.zeros(0)
        self._offsets = upload(mi.UInt32, offsets)
        self._first = upload(mi.UInt32, _join([m.first for m in made]))
        self._grid = upload(mi.UInt32, _join([m.grid for m in made]))
        self._shape = upload(mi.UInt32, _join([m.shape for m in made]))
        self._prim = upload(mi.UInt32, _join([m.prim for m in made]))
        self._uv = upload(mi.Float, _join([m.uv for m in made]))
        self.whole = np.concatenate([m.whole for m in made]) if made else np.zeros(0)
        self.sides = np.flatnonzero(np.repeat(self.area > 0.0, 2)).astype(np.uint32)
        self.values = dr.zeros(mi.Float, max(2 * cells * self.bands.count, 1))
        self.uneven = dr.zeros(mi.Bool, max(2 * cells, 1))
        self._near = upload(mi.Float, near)
        # By cell: whether the next one is its neighbour, and how far on the one above is (0: there is none).
        self.has_next = _join([m.has_next for m in made]).astype(bool)
        self.to_above = _join([m.to_above for m in made]).astype(np.int64)
        # Light traced from the lights, see `put_traced`.
        self.traced = None
        self._host_table = (
            offsets,
            _join([m.first for m in made]).astype(np.int64),
            _join([m.grid for m in made]).astype(np.int64),
        )
        dr.eval(
            self._offsets, self._first, self._grid, self._shape, self._prim, self._uv, self.values
        )
        dr.eval(self.uneven, self._near)

    def __bool__(self) -> bool:
        """Whether there is anything to read."""
        return self.count > 0

    def put_traced(self, deposits) -> None:
        """Take the light that traced paths brought, as irradiance that passes the coat (`light_paths.Deposits`)."""
        offsets, first, grid = self._host_table
        shape = deposits.shape.astype(np.int64)
        passing = self.matt.passing(shape, deposits.cosine)
        triangle = np.where(passing > 0.0, offsets[shape] + deposits.prim.astype(np.int64), 0)
        across, up = grid[triangle] & 0xFFFF, grid[triangle] >> 16
        i = np.minimum((deposits.uv[:, 0] * across).astype(np.int64), across - 1)
        j = np.minimum((deposits.uv[:, 1] * up).astype(np.int64), up - 1)
        side = 2 * (first[triangle] + j * across + i) + deposits.back
        flux = np.bincount(side, deposits.flux * passing, 2 * self.count)
        area = np.repeat(self.area, 2)
        light = np.where(area > 0.0, flux / np.where(area > 0.0, area, 1.0), 0.0)
        # One number for all wavelengths: as if its spectrum were the mean light's.
        self.traced = upload(mi.Float, light / self.bands.illuminance())
        dr.eval(self.traced)

    # ---- inside kernels ----

    def side(self, shape, prim, uv, is_back, active):
        """Number of the cell's side at a hit. ``uv``: barycentric."""
        number = dr.reinterpret_array(mi.UInt32, shape)
        triangle = dr.gather(mi.UInt32, self._offsets, number, active) + prim
        grid = dr.gather(mi.UInt32, self._grid, triangle, active)
        across, up = grid & 0xFFFF, grid >> 16
        i = dr.minimum(mi.UInt32(uv.x * mi.Float(across)), across - 1)
        j = dr.minimum(mi.UInt32(uv.y * mi.Float(up)), up - 1)
        cell = dr.gather(mi.UInt32, self._first, triangle, active) + j * across + i
        return 2 * cell + dr.select(is_back, mi.UInt32(BACK), mi.UInt32(FRONT))

    def near(self, shape, active):
        """Size of the cells of a shape. [m]"""
        return dr.gather(mi.Float, self._near, dr.reinterpret_array(mi.UInt32, shape), active)

    def value(self, side, wavelengths, active):
        """Spectral irradiance that passes the coat."""
        return self.bands.read(self.values, side, wavelengths, active)

    def traced_value(self, side, wavelengths, active):
        """Spectral irradiance that traced paths bring and that passes the coat."""
        return self.bands.grey(dr.gather(mi.Float, self.traced, side, active), wavelengths)

    def point(self, side, sample):
        """Surface at a point of a cell of a grid, seen from that side; its row; and whether it lies in the triangle.

        Points are even over the whole cell of the grid. ``sample``: Point2f.
        """
        cell = side // 2
        shape = dr.gather(mi.UInt32, self._shape, cell * PLACES)
        prim = dr.gather(mi.UInt32, self._prim, cell * PLACES)
        triangle = dr.gather(mi.UInt32, self._offsets, shape) + prim
        grid = dr.gather(mi.UInt32, self._grid, triangle)
        # Lanes that are not there read zero, and must not divide by it.
        across, up = dr.maximum(grid & 0xFFFF, 1), dr.maximum(grid >> 16, 1)
        local = cell - dr.gather(mi.UInt32, self._first, triangle)
        u = (mi.Float(local % across) + sample.x) / mi.Float(across)
        v = (mi.Float(local // across) + sample.y) / mi.Float(up)
        si = self._turned(self.scene.interaction_at(shape, prim, mi.Point2f(u, v)), side)
        return si, self.matt.row(si.shape, True), u + v < 1.0

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


def _areas(triangles: np.ndarray) -> np.ndarray:
    edges = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return 0.5 * np.linalg.norm(edges.astype(np.float64), axis=1)


def divide(triangles: np.ndarray, number: int, size: float, first: int) -> _Elements:
    """Divide the triangles of a shape into cells.

    Parameters
    ----------
    triangles : (t, 3, 3) float32 array    Corners. [m]
    number : int    Of the shape.
    size : float    Side of a cell. [m]
    first : int    Number of the first cell.
    """
    areas = _areas(triangles)
    across, up = _grid(triangles, areas, size)
    large = np.flatnonzero(areas > GROUPED * size**2)
    small = np.setdiff1d(np.arange(len(triangles)), large, assume_unique=True)
    starts = np.zeros(len(triangles), dtype=np.int64)
    grid = np.full(len(triangles), 1 + (1 << 16), dtype=np.int64)
    grid[large] = across[large] + (up[large] << 16)
    counts = across[large] * up[large]
    starts[large] = np.cumsum(counts) - counts
    divided = _divide_large(large, across[large], up[large], areas)
    groups, group_of = _group_small(triangles, small, size)
    starts[small] = counts.sum() + group_of
    grouped = _points_of_groups(small, group_of, groups, areas)
    prim, uv, area = (np.concatenate(pair) for pair in zip(divided, grouped, strict=True))
    which = np.repeat(large, counts)
    local = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    alone = np.zeros(groups, dtype=np.int64)
    has_next = local % across[which] < across[which] - 1
    to_above = np.where(local // across[which] < up[which] - 1, across[which], 0)
    return _Elements(
        (starts + first).astype(np.uint32),
        grid.astype(np.uint32),
        np.full(prim.shape, number, dtype=np.uint32),
        prim.astype(np.uint32),
        uv.astype(np.float32),
        area,
        np.concatenate([has_next, alone > 0]),
        np.concatenate([to_above, alone]),
        np.concatenate([np.repeat(2.0 * areas[large] / counts, counts), alone.astype(np.float64)]),
    )


def _growth(triangles: dict, parts, sizes: np.ndarray, most: int) -> float:
    """Factor on all sizes by which there are not more cells than ``most`` besides one for each large triangle."""
    factor = 1.0
    for _ in range(24):
        total = 0
        for part, size in zip(parts, sizes * factor, strict=True):
            across, up = _grid(triangles[part.number], _areas(triangles[part.number]), float(size))
            total += int((across * up - 1).sum())
        if total <= most:
            break
        factor *= 1.5
    return factor


def _grid(triangles: np.ndarray, areas: np.ndarray, size: float):
    """Cells along the first and the second edge of every triangle: their number follows the area, also of slivers."""
    lengths = [np.linalg.norm(triangles[:, k] - triangles[:, 0], axis=1) for k in (1, 2)]
    longest = np.maximum(np.maximum(*lengths), 1e-30)
    heights = 2.0 * areas / longest
    is_first = lengths[0] >= lengths[1]
    counts = [
        np.where(is_first == (k == 0), longest, np.minimum(heights, lengths[k])) / size
        for k in (0, 1)
    ]
    return tuple(np.clip(np.ceil(each - 1e-3), 1, LARGEST_GRID).astype(np.int64) for each in counts)


def _divide_large(large, across, up, areas):
    """Points (c, PLACES, 2) and areas of the cells of large triangles, triangle after triangle, row after row."""
    counts = across * up
    total = int(counts.sum())
    which = np.repeat(np.arange(len(large)), counts)
    local = np.arange(total) - np.repeat(np.cumsum(counts) - counts, counts)
    nu, nv = across[which].astype(np.float64), up[which].astype(np.float64)
    low_u, low_v = (local % across[which]) / nu, (local // across[which]) / nv
    # A regular pattern, quarter by quarter, in each cell; points beyond the third edge take one that is inside.
    steps = (np.arange(4) + 0.5) / 4.0
    x, y = (m.ravel() for m in np.meshgrid(steps, steps))
    order = np.lexsort((x, y, x > 0.5, y > 0.5))
    x, y = x[order], y[order]
    u = low_u[:, None] + x / nu[:, None]
    v = low_v[:, None] + y / nv[:, None]
    inside = u + v < 1.0
    share = inside.mean(axis=1)
    # Slivers of cells whose points are all outside get one near the corner, if that is inside.
    corner = low_u + low_v < 1.0 - 1e-9
    lost = corner & (share == 0.0)
    rest = np.clip(1.0 - low_u - low_v, 0.0, None)
    u[lost], v[lost] = (low_u + rest / 3.0)[lost, None], (low_v + rest / 3.0)[lost, None]
    inside[lost] = True
    share[lost] = (0.5 * rest**2 * nu * nv)[lost]
    slots = np.argsort(~inside, axis=1, kind="stable")
    filled = np.take_along_axis(slots, np.arange(PLACES) % np.maximum(inside.sum(axis=1), 1)[:, None], axis=1)  # fmt: skip
    # Points that are inside stay in their quarter.
    chosen = np.where(inside, np.arange(PLACES), filled)
    u, v = np.take_along_axis(u, chosen, axis=1), np.take_along_axis(v, chosen, axis=1)
    uv = np.clip(np.stack([u, v], axis=2), 0.0, 1.0)
    area = np.where(corner, share * 2.0 * areas[large][which] / (nu * nv), 0.0)
    return np.repeat(large[which][:, None], PLACES, axis=1), uv, area


def _group_small(triangles, small, size):
    """Number of groups, and the group of every small triangle: together in space, facing the same way."""
    if len(small) == 0:
        return 0, np.zeros(0, dtype=np.int64)
    corners = triangles[small].astype(np.float64)
    centre = corners.mean(axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(axis=1)
    facing = 2 * axis + (np.take_along_axis(normal, axis[:, None], axis=1)[:, 0] < 0.0)
    cell = np.floor((centre - centre.min(axis=0)) / size).astype(np.int64)
    reach = cell.max(axis=0) + 1
    key = ((cell[:, 0] * reach[1] + cell[:, 1]) * reach[2] + cell[:, 2]) * 6 + facing
    found, group = np.unique(key, return_inverse=True)
    return len(found), group.reshape(-1)


def _points_of_groups(small, group, count, areas):
    """Points and areas of grouped cells: points fall on the triangles by their areas."""
    own = areas[small]
    order = np.argsort(group, kind="stable")
    ends = np.cumsum(own[order])
    total = np.bincount(group, weights=own, minlength=count)
    begin = np.cumsum(total) - total
    wanted = (np.arange(PLACES) + 0.5) / PLACES
    target = begin[:, None] + wanted * total[:, None]
    members = np.bincount(group, minlength=count)
    low = np.cumsum(members) - members
    place = np.searchsorted(ends, target.ravel()).reshape(count, PLACES)
    place = np.clip(place, low[:, None], (low + members - 1)[:, None])
    prim = small[order][place] if len(small) else np.zeros((0, PLACES), dtype=np.int64)
    # Points of the plastic sequence, folded into the triangle.
    step = np.arange(1, PLACES + 1)
    u, v = (0.7548776662466927 * step) % 1.0, (0.5698402909980532 * step) % 1.0
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    uv = np.broadcast_to(np.stack([u, v], axis=1), (count, PLACES, 2))
    return prim, uv, total
