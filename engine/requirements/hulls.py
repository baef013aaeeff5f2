"""Closed surfaces, and what lies on which side of them."""

import numpy as np

from ..scene.mesh import Mesh

MOST_TRIANGLES = 20_000
"""Triangles of an object up to which it is looked at: what closes rooms off has few."""

MOST_PAIRS = 4_000_000
"""Boxes times triangles up to which their sides are found."""

CHUNK = 1 << 20
"""Points times triangles that are looked at together."""

DIRECTIONS = np.array([[0.36, 0.48, 0.8], [-0.557, 0.743, -0.371], [0.113, -0.904, 0.412]])
"""Ways out of a place; no edge of what people build is likely to lie on them."""

OUTSIDE, INSIDE, UNKNOWN = 0, 1, 2
"""Sides of a closed surface; unknown: a box touches it, or comes too near to tell."""


def closed_parts(mesh: Mesh) -> list[np.ndarray]:
    """Corners of the connected parts of a mesh that have no edge: each divides space into two sides. (t, 3, 3) [m]"""
    if not 4 <= len(mesh.triangles) <= MOST_TRIANGLES or not _is_sound(mesh):
        return []
    # Corners at one place are one, so that seams of normals and pictures do not count as edges.
    places, corner = np.unique(mesh.vertices, axis=0, return_inverse=True)
    triangles = corner.reshape(-1)[mesh.triangles]
    first, second, third = triangles.T
    triangles = triangles[(first != second) & (second != third) & (third != first)]
    if not len(triangles):
        return []
    ends = np.sort(np.concatenate([np.roll(triangles, k, axis=1)[:, :2] for k in range(3)]), axis=1)
    owner = np.tile(np.arange(len(triangles)), 3)
    _, edge, count = np.unique(
        ends[:, 0] * np.int64(len(places)) + ends[:, 1], return_inverse=True, return_counts=True
    )
    part = _connect(len(triangles), len(count), owner, edge.reshape(-1))
    is_open = np.zeros(len(triangles), bool)
    np.logical_or.at(is_open, part[owner], count[edge.reshape(-1)] != 2)
    corners = places[triangles]
    return [corners[part == each] for each in np.unique(part) if not is_open[each]]


def _is_sound(mesh: Mesh) -> bool:
    """Whether its triangles have all their corners; what has not is refused when it is compiled."""
    return mesh.triangles.min() >= 0 and mesh.triangles.max() < len(mesh.vertices)


def _connect(triangles: int, edges: int, owner: np.ndarray, edge: np.ndarray) -> np.ndarray:
    """Number of a triangle of the same connected part, the same for all of it. (triangles,)"""
    part = np.arange(triangles)
    while True:
        least = np.full(edges, triangles)
        np.minimum.at(least, edge, part[owner])
        new = part.copy()
        np.minimum.at(new, owner, least[edge])
        new = new[new]
        if np.array_equal(new, part):
            return part
        part = new


def sides(corners: np.ndarray, lows: np.ndarray, highs: np.ndarray) -> np.ndarray:
    """On which side of a closed surface boxes lie as a whole.

    Parameters
    ----------
    corners : (t, 3, 3) array    Of its triangles. [m]
    lows, highs : (n, 3) array    Corners of the boxes. [m]

    Returns
    -------
    (n,) int array    `OUTSIDE`, `INSIDE` or `UNKNOWN`.
    """
    found = np.full(len(lows), OUTSIDE)
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    near = np.flatnonzero(((lows <= high) & (highs >= low)).all(axis=1))
    if len(near) * len(corners) > MOST_PAIRS:
        found[near] = UNKNOWN
        return found
    for row in near:
        middle, half = 0.5 * (lows[row] + highs[row]), 0.5 * (highs[row] - lows[row])
        found[row] = UNKNOWN if _touches(corners - middle, half) else OUTSIDE
    apart = near[found[near] != UNKNOWN]
    middles = 0.5 * (lows[apart] + highs[apart])
    for rows in np.array_split(np.arange(len(apart)), len(apart) * len(corners) // CHUNK + 1):
        found[apart[rows]] = _side(corners - low, middles[rows] - low)
    return found


def _touches(corners: np.ndarray, half: np.ndarray) -> bool:
    """Whether a triangle meets the box about the origin, by the axes that could part them (Akenine-Moeller, 2001)."""
    near = ((corners.min(axis=1) <= half) & (corners.max(axis=1) >= -half)).all(axis=1)
    corners = corners[near]
    if not len(corners):
        return False
    edges = np.roll(corners, -1, axis=1) - corners
    crossed = np.cross(edges[:, :, None], np.eye(3)[None, None]).reshape(-1, 9, 3)
    normal = np.cross(edges[:, 0], edges[:, 1])[:, None]
    axes = np.concatenate([crossed, normal], axis=1)
    along = np.einsum("tak,tck->tac", axes, corners)
    reach = np.abs(axes) @ half
    is_apart = (along.min(axis=2) > reach) | (along.max(axis=2) < -reach)
    return bool((~is_apart.any(axis=1)).any())


def _side(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """On which side of a closed surface points lie: how often ways out of them cross it. (t, 3, 3), (n, 3) -> (n,)"""
    odd = np.stack([_crossings(corners, points, way) % 2 for way in DIRECTIONS])
    return np.where((odd == odd[0]).all(axis=0), odd[0], UNKNOWN)


def _crossings(corners: np.ndarray, points: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Triangles that rays from points meet, by the volumes that rays span with their edges. (n,)"""
    a, b, c = (corners[:, k] for k in range(3))
    # (p - x) x (q - x) . way, for all points x at once.
    volumes = [
        np.cross(p, q) @ way - points @ np.cross(q - p, way).T for p, q in ((a, b), (b, c), (c, a))
    ]
    is_met = np.logical_and.reduce([volume > 0.0 for volume in volumes])
    is_met |= np.logical_and.reduce([volume < 0.0 for volume in volumes])
    normal = np.cross(b - a, c - a)
    ahead = ((normal * a).sum(axis=1) - points @ normal.T) * (normal @ way) > 0.0
    return (is_met & ahead).sum(axis=1)
