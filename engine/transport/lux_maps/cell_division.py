"""How the triangles of matt surfaces are divided into cells, on the host."""

from dataclasses import dataclass

import numpy as np

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

LARGEST_GRID = 2048
"""Most cells along an edge of a triangle."""

EDGE = 1e-3
"""Distance from a triangle's third edge at which no points of cells lie, in sides of a cell. [-]"""

CURVE = 6
"""Halvings of a group's cube by which its triangles are put in order."""


@dataclass(frozen=True)
class Elements:
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


def areas_of(triangles: np.ndarray) -> np.ndarray:
    """Areas of triangles (t, 3, 3) [m]. (t,) float64 [m2]"""
    edges = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return 0.5 * np.linalg.norm(edges.astype(np.float64), axis=1)


def divide(triangles: np.ndarray, number: int, size: float, first: int) -> Elements:
    """Divide the triangles of a shape into cells.

    Parameters
    ----------
    triangles : (t, 3, 3) float32 array    Corners. [m]
    number : int    Of the shape.
    size : float    Side of a cell. [m]
    first : int    Number of the first cell.
    """
    areas = areas_of(triangles)
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
    return Elements(
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


def growth(triangles: dict, parts, sizes: np.ndarray, most: int) -> float:
    """Factor on all sizes by which there are not more cells than ``most`` besides one for each large triangle."""
    factor = 1.0
    for _ in range(24):
        total = 0
        for part, size in zip(parts, sizes * factor, strict=True):
            own = triangles[part.number]
            across, up = _grid(_turn_corners(own)[1], areas_of(own), float(size))
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
    share = share_inside(low_u, low_v, nu, nv)
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


def share_inside(u, v, nu, nv):
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


def find_neighbours(made: list[Elements], sizes) -> tuple[np.ndarray, np.ndarray]:
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
