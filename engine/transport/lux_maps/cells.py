"""Cells: coarse elements of all matt surfaces that hold the light which falls on them, for gathering to read.

A triangle larger than a cell is divided along two of its edges; smaller ones that lie together and face the same way share a
cell. Front and back are apart. What is held is the irradiance that passes the surface's coat (see `diffuse`).

The light is found by sweeps: every cell gathers from the cells of the sweep before, so each adds one interreflection more,
until the rest is negligible. Before every pass of a job one more sweep, with points of its own, takes the place of the old
values.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ..compiled.diffuse import MattTable
from .bands import Bands

PLACES = 16
"""Points of every cell from which it gathers, four for each quarter of it."""

GROUPED = 0.02
"""Triangles of less than this share of a cell's area join others. [-]"""

REACH, SAME_WAY = 1.5, 0.9
"""Cells are neighbours whose middles are nearer than this, in sizes, and whose normals have this cosine at least. [-]"""

_HALF = [
    (x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) >= (0, 0, 0)
]
"""Half of the cubes round a cube, and itself, so that every pair is found once."""

EVEN_SHARE = 0.1
"""Share of the cells that is spread over all surfaces by area."""

FEWEST_DEPOSITS, LEAST_BOX, MOST_BOX = 16, 1.0 / 256.0, 0.5
"""Traced paths in a cell from which on they tell where in it their light lies; least side of that box, and the share of the
cell from which on it is the whole cell. [-]"""

LARGEST_GRID = 2048
"""Most cells along an edge of a triangle."""

EDGE = 1e-3
"""Distance from a triangle's third edge at which no points of cells lie, in sides of a cell. [-]"""

CURVE = 6
"""Halvings of a group's cube by which its triangles are put in order."""

FRONT, BACK = 0, 1


@dataclass(frozen=True)
class _Elements:
    """Cells of all shapes on the host. See `divide`.

    Parameters
    ----------
    first : (t,) uint32    First cell of every triangle.
    grid : (t,) uint32    Cells along two of its edges and the corner from which these go, see `pack_grid`.
    shape, prim : (c, PLACES) uint32; uv : (c, PLACES, 2) float32    Points of every cell.
    area : (c,) float64    0 for cells outside their triangle. [m2]
    centre, normal : (c, 3) float32    Mean of the points [m], and the direction of the front.
    whole : (c,) float64    Area over which points are chosen: that of a cell of the grid, the part outside the triangle
        included; of grouped triangles their own. [m2]
    members, ends : (m,) uint32, (m,) float32    Grouped triangles, group after group, and the share of their group's area up
        to the end of each.
    first_member : (c,) uint32    Of every cell; as many as up to that of the next belong to it, none to cells of a grid.
    """

    first: np.ndarray
    grid: np.ndarray
    shape: np.ndarray
    prim: np.ndarray
    uv: np.ndarray
    area: np.ndarray
    centre: np.ndarray
    normal: np.ndarray
    whole: np.ndarray
    members: np.ndarray
    ends: np.ndarray
    first_member: np.ndarray


class CellSet:
    """Cells of a compiled scene, with their values on the device.

    Parameters
    ----------
    scene : CompiledScene
    count : int    About how many cells there may be.
    importance : callable
        Says how often a job looks at each shape: numbers of shapes (n,) to shares (n,). The more often, the finer.
    refine : callable or None    Gives a factor on ``count``, from the sizes of cells by shape that it would make. [m]
    """

    def __init__(self, scene, count: int, importance, refine=None):
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
        near = np.zeros(scene.shape_count)
        numbers = [part.number for part in parts]

        def find_sizes(count: float) -> np.ndarray:
            sizes = np.sqrt(2.0 * areas / np.maximum(count * shares, 1e-9))
            sizes = np.maximum(sizes, 1e-9)
            return sizes * _growth(triangles, parts, sizes, 4 * max(int(count), 1))

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
        self.values = dr.zeros(mi.Float, max(2 * cells * self.bands.count, 1))
        self.uneven = dr.zeros(mi.Bool, max(2 * cells, 1))
        self._put_members(made)
        self._near = upload(mi.Float, near)
        self.neighbours = _find_neighbours(made, sizes)
        # Light traced from the lights, see `put_traced`.
        self.traced = None
        self._boxes = None
        # Guide to that light for points that paths come to, see `guide.choose_spots`.
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

    def _put_members(self, made: list[_Elements]) -> None:
        """Upload which triangles share cells."""
        counts = np.array([len(m.members) for m in made], dtype=np.int64)
        begins = np.cumsum(counts) - counts
        firsts = [m.first_member + begin for m, begin in zip(made, begins, strict=True)]
        firsts = np.concatenate([*firsts, [counts.sum()]]).astype(np.uint32)
        # Halvings that find one of them; 0: no cell is shared.
        self._halvings = int(np.diff(firsts.astype(np.int64)).max(initial=0)).bit_length()
        self._shared = np.diff(firsts.astype(np.int64)) > 0
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
        is_small &= ~self._shared[found // 2]
        found, low, high, width = (each[is_small] for each in (found, low, high, width))
        cell = found // 2
        across, up, begin = self._corner[cell].T
        place = (found // 2 - begin) % across, (found // 2 - begin) // across
        u, v = (place[0] + low[:, 0]) / across, (place[1] + low[:, 1]) / up
        part = _share_inside(u, v, across / width[:, 0], up / width[:, 1])
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


def _find_neighbours(made: list[_Elements], sizes) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of cells of one shape that lie next to each other and face the same way, by their numbers. (m,), (m,)"""
    first, second, start = [], [], 0
    for elements, size in zip(made, sizes, strict=True):
        count = len(elements.area)
        place = np.floor(elements.centre / size).astype(np.int64)
        place -= place.min(axis=0, initial=0) - 1
        reach = place.max(axis=0, initial=0) + 2
        key = (place[:, 0] * reach[1] + place[:, 1]) * reach[2] + place[:, 2]
        order = np.argsort(key, kind="stable")
        ordered = key[order]
        for offset in _HALF:
            wanted = key + (offset[0] * reach[1] + offset[1]) * reach[2] + offset[2]
            low = np.searchsorted(ordered, wanted, side="left")
            here = np.flatnonzero(np.searchsorted(ordered, wanted, side="right") - low)
            found = np.searchsorted(ordered, wanted[here], side="right") - low[here]
            a = np.repeat(here, found)
            b = np.repeat(low[here] - (np.cumsum(found) - found), found) + np.arange(found.sum())
            b = order[b]
            apart = np.linalg.norm(elements.centre[a] - elements.centre[b], axis=1)
            alike = np.einsum("mx,mx->m", elements.normal[a], elements.normal[b]) > SAME_WAY
            near = (a != b) & (apart < REACH * size) & alike
            near &= (elements.area[a] > 0.0) & (elements.area[b] > 0.0)
            first.append(a[near] + start)
            second.append(b[near] + start)
        start += count
    if not first:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    return np.concatenate(first), np.concatenate(second)


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
    corner, turned = _turn_corners(triangles)
    across, up = _grid(turned, areas, size)
    large = np.flatnonzero(areas > GROUPED * size**2)
    small = np.setdiff1d(np.arange(len(triangles)), large, assume_unique=True)
    starts = np.zeros(len(triangles), dtype=np.int64)
    one = np.ones(len(triangles), dtype=np.int64)
    grid = pack_grid(one, one, 0 * one)
    grid[large] = pack_grid(across[large], up[large], corner[large])
    counts = across[large] * up[large]
    starts[large] = np.cumsum(counts) - counts
    divided = _divide_large(large, across[large], up[large], areas, corner[large])
    groups, group_of, place_of = _group_small(triangles, small, size)
    starts[small] = counts.sum() + group_of
    *grouped, members = _points_of_groups(small, group_of, place_of, groups, areas)
    prim, uv, area = (np.concatenate(pair) for pair in zip(divided, grouped, strict=True))
    corners = triangles[prim]
    weights = np.stack([1.0 - uv.sum(axis=2), uv[..., 0], uv[..., 1]], axis=2)
    centre = np.einsum("cpk,cpkx->cx", weights, corners) / PLACES
    edges = corners[:, 0, 1:] - corners[:, 0, :1]
    normal = np.cross(edges[:, 0], edges[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    none = np.zeros(int(counts.sum()), dtype=np.int64)
    return _Elements(
        (starts + first).astype(np.uint32),
        grid.astype(np.uint32),
        np.full(prim.shape, number, dtype=np.uint32),
        prim.astype(np.uint32),
        uv.astype(np.float32),
        area,
        centre.astype(np.float32),
        normal.astype(np.float32),
        np.concatenate([np.repeat(2.0 * areas[large] / counts, counts), grouped[2]]),
        members[0].astype(np.uint32),
        members[1].astype(np.float32),
        np.concatenate([none, members[2]]).astype(np.uint32),
    )


def pack_grid(across, up, corner):
    """Numbers of cells along the first and the second edge from a corner, and which corner it is, in one number."""
    return across | up << 16 | corner << 30


def unpack_grid(grid):
    """Undo `pack_grid`, of arrays on the host or the device."""
    return grid & 0xFFFF, (grid >> 16) & 0x3FFF, grid >> 30


def turn(u, v, corner):
    """Barycentric coordinates of the second and third corner, counted from another corner on. Arrays of one shape."""
    w = 1.0 - u - v
    return (
        np.where(corner == 0, u, np.where(corner == 1, v, w)),
        np.where(corner == 0, v, np.where(corner == 1, w, u)),
    )


def _turn_corners(triangles: np.ndarray):
    """Corner with the widest angle, from which edges make cells that are least askew; triangles beginning there."""
    edges = [((triangles[:, k - 2] - triangles[:, k - 1]) ** 2).sum(axis=1) for k in range(3)]
    corner = np.argmax(edges, axis=0)
    order = (corner[:, None] + np.arange(3)) % 3
    return corner, np.take_along_axis(triangles, order[..., None], axis=1)


def _growth(triangles: dict, parts, sizes: np.ndarray, most: int) -> float:
    """Factor on all sizes by which there are not more cells than ``most`` besides one for each large triangle."""
    factor = 1.0
    for _ in range(24):
        total = 0
        for part, size in zip(parts, sizes * factor, strict=True):
            own = triangles[part.number]
            across, up = _grid(_turn_corners(own)[1], _areas(own), float(size))
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


def _divide_large(large, across, up, areas, begin):
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
    # Points on the third edge are outside: from there rays pass the surfaces that meet it.
    inside = u + v < 1.0 - EDGE / np.maximum(nu, nv)[:, None]
    # Slivers of cells whose points are all outside get one near the corner, if that is inside.
    rest = np.clip(1.0 - low_u - low_v, 0.0, None)
    corner = rest * np.maximum(nu, nv) > EDGE
    lost = corner & ~inside.any(axis=1)
    u[lost], v[lost] = (low_u + rest / 3.0)[lost, None], (low_v + rest / 3.0)[lost, None]
    inside[lost] = True
    share = _share_inside(low_u, low_v, nu, nv)
    slots = np.argsort(~inside, axis=1, kind="stable")
    filled = np.take_along_axis(slots, np.arange(PLACES) % np.maximum(inside.sum(axis=1), 1)[:, None], axis=1)  # fmt: skip
    # Points that are inside stay in their quarter.
    chosen = np.where(inside, np.arange(PLACES), filled)
    u, v = np.take_along_axis(u, chosen, axis=1), np.take_along_axis(v, chosen, axis=1)
    # Back to the triangle's own corners: turning twice more makes a whole turn.
    begin = begin[which][:, None]
    u, v = turn(*turn(u, v, begin), begin)
    uv = np.clip(np.stack([u, v], axis=2), 0.0, 1.0)
    area = np.where(corner, share * 2.0 * areas[large][which] / (nu * nv), 0.0)
    return np.repeat(large[which][:, None], PLACES, axis=1), uv, area


def _share_inside(u, v, nu, nv):
    """Shares of cells, by their low corners and the cells along both edges, that lie within the third edge u + v = 1."""

    def beyond(a, b):
        return 0.5 * np.clip(1.0 - a - b, 0.0, None) ** 2

    cut = beyond(u, v) - beyond(u + 1.0 / nu, v) - beyond(u, v + 1.0 / nv)
    return np.maximum(cut + beyond(u + 1.0 / nu, v + 1.0 / nv), 0.0) * nu * nv


def _group_small(triangles, small, size):
    """Number of groups, and of every small triangle its group and its place there.

    A group lies together in space and faces the same way. Places are numbers along a curve that fills the group's cube
    octant by octant, so that a quarter of them lies together too, whatever the order of the triangles.
    """
    if len(small) == 0:
        return 0, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    corners = triangles[small].astype(np.float64)
    centre = corners.mean(axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(axis=1)
    facing = 2 * axis + (np.take_along_axis(normal, axis[:, None], axis=1)[:, 0] < 0.0)
    within = (centre - centre.min(axis=0)) / size
    cell = np.floor(within).astype(np.int64)
    fine = np.minimum(((within - cell) * (1 << CURVE)).astype(np.int64), (1 << CURVE) - 1)
    place = np.zeros(len(small), dtype=np.int64)
    for bit in range(CURVE - 1, -1, -1):
        place = place << 3 | (fine >> bit & 1) @ np.array([4, 2, 1])
    reach = cell.max(axis=0) + 1
    key = ((cell[:, 0] * reach[1] + cell[:, 1]) * reach[2] + cell[:, 2]) * 6 + facing
    found, group = np.unique(key, return_inverse=True)
    return len(found), group.reshape(-1), place


def _points_of_groups(small, group, place_of, count, areas):
    """Points and areas of grouped cells: points fall on the triangles by their areas.

    Last, the triangles of the groups in order, the share of their group's area up to each, and the first of every group.
    """
    own = areas[small]
    order = np.lexsort((place_of, group))
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
    shares = (ends - begin[group[order]]) / np.maximum(total, 1e-300)[group[order]]
    return prim, uv, total, (small[order], shares, low)
