"""What meets what on a mesh: corners in one place, triangles at a common edge, connected parts."""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..scene.checks import is_finite
from ..scene.mesh import Mesh

WELD = 1e-6
"""Corners nearer than this share of the mesh's size count as one, for adjacency only."""

FLATTEST = 1e-9
"""A triangle has no area when its height is below this share of its longest edge."""

THIN = 1e-2
"""Height over longest edge below which a triangle is a sliver, if it is also low for the mesh."""

LOW = 1e-4
"""Height over the mesh's size below which a thin triangle's own normal is noise."""


@dataclass(frozen=True)
class Topology:
    """A mesh's triangles as they hang together.

    Parameters
    ----------
    corners : (t, 3, 3) float64 array    Corners from the centre of the mesh. [m]
    vertex : (t, 3) int64 array    Places: corners in one place have one number, whatever the mesh's own indices are.
    area : (t,) float64 array    0 for triangles without area. [m2]
    normal : (t, 3) float64 array    Unit; slivers have that of the neighbour at their longest edge.
    is_reliable : (t,) bool array    Whether the triangle is no sliver.
    unit : (t,) int64 array    Number of the polygon, or of the triangle where there are no polygons.
    unit_count : int
    pairs : (p, 2) int64 array    Triangles with area that meet at an edge which no third one shares.
    pair_length : (p,) float64 array    Of those edges. [m]
    """

    corners: np.ndarray
    vertex: np.ndarray
    area: np.ndarray
    normal: np.ndarray
    is_reliable: np.ndarray
    unit: np.ndarray
    unit_count: int
    pairs: np.ndarray
    pair_length: np.ndarray


def find_topology(mesh: Mesh) -> Topology:
    """Find out how a mesh hangs together.

    Raises
    ------
    SceneError    A triangle names a vertex that is not there, or a vertex lies nowhere.
    """
    triangles = np.asarray(mesh.triangles, dtype=np.int64).reshape(-1, 3)
    if len(triangles) and (triangles.min() < 0 or triangles.max() >= len(mesh.vertices)):
        raise SceneError(
            f"object '{mesh.name}' has triangles that name vertices which it does not hold; repair the mesh"
        )
    used, local = np.unique(triangles, return_inverse=True)
    local = local.reshape(-1, 3)
    points = np.asarray(mesh.vertices, dtype=np.float64)[used]
    if not is_finite(points):
        raise SceneError(
            f"object '{mesh.name}' has a vertex that is not at a finite place; repair the mesh"
        )
    if len(points):
        points = points - 0.5 * (points.min(axis=0) + points.max(axis=0))
    corners = points[local]
    edges = np.roll(corners, -1, axis=1) - corners
    length = np.linalg.norm(edges, axis=2)
    longest = length.max(axis=1, initial=0.0)
    cross = np.cross(edges[:, 0], edges[:, 1])
    double = np.linalg.norm(cross, axis=1)
    has_area = double > FLATTEST * longest**2
    area = np.where(has_area, 0.5 * double, 0.0)
    normal = cross / np.where(has_area, double, 1.0)[:, None]
    normal[~has_area] = 0.0

    size = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
    typical = float(np.median(length[has_area])) if has_area.any() else 0.0
    # One stray vertex far away must not make everything else one place.
    vertex = weld(points, min(WELD * size, 1e-2 * typical))[local]

    if mesh.polygon is None:
        unit, unit_count = np.arange(len(triangles)), len(triangles)
    else:
        numbers, unit = np.unique(mesh.polygon, return_inverse=True)
        unit, unit_count = unit.reshape(-1), len(numbers)

    pairs, pair_length = _pair_edges(vertex, length, has_area)
    height = double / np.maximum(longest, 1e-300)
    is_sliver = has_area & (height < THIN * longest) & (height < LOW * size)
    normal = _lend_normals(normal, is_sliver, pairs, pair_length)
    return Topology(
        corners,
        vertex,
        area,
        normal,
        has_area & ~is_sliver,
        unit,
        unit_count,
        pairs,
        pair_length,
    )


def weld(points: np.ndarray, distance: float) -> np.ndarray:
    """Number places: points that lie nearer than a distance, along every axis, get the same number.

    Parameters
    ----------
    points : (n, k) float64 array
    distance : float    In the points' unit.

    Returns
    -------
    (n,) int64 array
    """
    label = np.zeros(len(points), dtype=np.int64)
    count = min(len(points), 1)
    # A sort along one axis alone would chain points that lie apart along another; after all axes the groups are sparse,
    # and a second round parts what the first had chained.
    for _ in range(4):
        before = count
        for axis in range(points.shape[1]):
            order = np.lexsort((points[:, axis], label))
            step = np.diff(points[order, axis]) > distance
            starts = step | (np.diff(label[order]) != 0)
            label[order[1:]] = np.cumsum(starts)
            label[order[:1]] = 0
            count = int(label[order[-1]]) + 1 if len(order) else 0
        if count == before:
            break
    return label


def _pair_edges(vertex: np.ndarray, length: np.ndarray, has_area: np.ndarray):
    """Pairs of triangles at common edges, and the edges' lengths.

    They must run along the edge in opposite directions, as neighbours with the same outside do. Where as many run one way
    as the other, they are matched in order: doubled surfaces, the usual case, then stay two surfaces. Other edges with more
    than two triangles part their triangles.
    """
    start, end = vertex, np.roll(vertex, -1, axis=1)
    usable = ((start != end) & has_area[:, None]).ravel()
    rows = np.flatnonzero(usable)
    start, end, length = start.ravel()[rows], end.ravel()[rows], length.ravel()[rows]
    backwards = start > end
    span = int(vertex.max(initial=0)) + 1
    key = np.minimum(start, end) * span + np.maximum(start, end)
    order = np.argsort(key * 2 + backwards, kind="stable")
    if len(order) == 0:
        return np.zeros((0, 2), dtype=np.int64), np.zeros(0)
    key, backwards, rows, length = key[order], backwards[order], rows[order], length[order]
    first = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
    count = np.diff(np.append(first, len(key)))
    back = np.add.reduceat(backwards.astype(np.int64), first)
    matched = 2 * back == count
    # Of every matched edge the forward ones come first, then as many backward ones.
    half = np.repeat(np.where(matched, back, 0), count)
    rank = np.arange(len(key)) - np.repeat(first, count)
    left = np.flatnonzero(rank < half)
    right = left + half[left]
    pairs = np.stack([rows[left] // 3, rows[right] // 3], axis=1)
    apart = pairs[:, 0] != pairs[:, 1]
    return pairs[apart], np.maximum(length[left], length[right])[apart]


def _lend_normals(normal, is_sliver, pairs, pair_length) -> np.ndarray:
    """Give slivers the normal of the neighbour at their longest edge; a few rounds reach slivers beside slivers."""
    if not is_sliver.any():
        return normal
    normal = normal.copy()
    lacks = is_sliver.copy()
    order = np.argsort(pair_length, kind="stable")
    ends = pairs[order]
    ends = np.concatenate([ends, ends[:, ::-1]])
    rank = np.concatenate([order, order])
    for _ in range(4):
        lends = lacks[ends[:, 0]] & ~lacks[ends[:, 1]]
        if not lends.any():
            break
        takers, givers = ends[lends, 0], ends[lends, 1]
        last = np.lexsort((pair_length[rank[lends]], takers))
        # Of several writes to one place the last counts: the longest edge.
        normal[takers[last]] = normal[givers[last]]
        lacks[takers] = False
    return normal


def find_components(count: int, ends: np.ndarray) -> np.ndarray:
    """Number the connected parts of a graph in the order of their first nodes.

    Every round hangs the roots of parts that touch under a lower one and then shortens all ways to the roots; at least half
    of the roots that can go are gone after each, so rounds grow with the logarithm of the size.

    Parameters
    ----------
    count : int    Nodes.
    ends : (e, 2) int64 array    Nodes that are connected.

    Returns
    -------
    (count,) int64 array
    """
    root = np.arange(count)
    a, b = ends[:, 0], ends[:, 1]
    while True:
        low, high = root[a], root[b]
        apart = low != high
        if not apart.any():
            break
        a, b = a[apart], b[apart]
        low, high = low[apart], high[apart]
        root[np.maximum(low, high)] = np.minimum(low, high)
        while True:
            further = root[root]
            if np.array_equal(further, root):
                break
            root = further
    return np.unique(root, return_inverse=True)[1].reshape(-1)


def sum_by(number: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """Sum rows with the same number. (n,), (n,) or (n, k) -> (count,) or (count, k)."""
    if values.ndim == 1:
        return np.bincount(number, values, minlength=count)
    return np.stack([np.bincount(number, column, minlength=count) for column in values.T], axis=1)


def largest_by(number: np.ndarray, values: np.ndarray, count: int, least: float) -> np.ndarray:
    """Largest value of each number, ``least`` where there is none. (n,), (n,) -> (count,)."""
    found = np.full(count, least)
    np.maximum.at(found, number, values)
    return found


def compress(label: np.ndarray) -> tuple[np.ndarray, int]:
    """Renumber labels from 0 on in the order of their first appearance; negative ones stay -1. Also how many there are."""
    wanted = np.flatnonzero(label >= 0)
    made = np.full(len(label), -1, dtype=np.int64)
    _, first, inverse = np.unique(label[wanted], return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first, kind="stable")] = np.arange(len(first))
    made[wanted] = rank[inverse.reshape(-1)]
    return made, len(first)
