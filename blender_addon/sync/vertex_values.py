"""Values of vertices that Cycles works out from a mesh: a random number of each connected part, and pointiness.

References
----------
Blender source, ``intern/cycles/blender/mesh.cpp`` and ``intern/cycles/util/disjoint_set.h``.
"""

import numpy as np

from .nodes.procedural.hashing import hash_integers

SAME_PLACE = np.finfo(np.float32).eps
"""Squared distance up to which vertices are one. [Blender unit²]"""


def find_islands(count: int, edges: np.ndarray) -> np.ndarray:
    """Return a random number for every vertex, the same for all that edges connect. (v,) float32

    It follows from the vertex by which Cycles names the part, which depends on the order of the edges.
    """
    parents, ranks = list(range(count)), [0] * count

    def root_of(vertex):
        root = vertex
        while parents[root] != root:
            root = parents[root]
        while parents[vertex] != root:
            parents[vertex], vertex = root, parents[vertex]
        return root

    for first, second in edges.tolist():
        one, other = root_of(first), root_of(second)
        if one == other:
            continue
        if ranks[one] < ranks[other]:
            one, other = other, one
        parents[other] = one
        ranks[one] += ranks[one] == ranks[other]
    roots = np.array([root_of(vertex) for vertex in range(count)], np.uint32)
    return hash_integers(roots).astype(np.float32) * np.float32(1.0 / np.float32(0xFFFFFFFF))


def measure_pointiness(positions: np.ndarray, normals: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return how far vertices stick out, 0.5 where the surface is flat, more on ridges. (v,) float32

    Parameters
    ----------
    positions, normals : (v, 3) float32 arrays
    edges : (e, 2) int32 array
    """
    same = _find_doubles(positions)
    count = len(positions)
    direction = np.zeros((count, 3))
    np.add.at(direction, same, normals.astype(np.float64))
    direction = _unit(direction)
    ends = np.sort(same[edges], axis=1)
    ends = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0)
    along = _unit((positions[ends[:, 1]] - positions[ends[:, 0]]).astype(np.float64))
    total, neighbours = np.zeros((count, 3)), np.zeros(count)
    for start, sign in ((0, 1.0), (1, -1.0)):
        np.add.at(total, ends[:, start], sign * along)
        np.add.at(neighbours, ends[:, start], 1.0)
    has_any = neighbours > 0.0
    mean = total / np.maximum(neighbours, 1.0)[:, None]
    cosine = np.clip((direction * mean).sum(axis=1), -1.0, 1.0)
    raw = np.where(has_any, np.arccos(cosine) / np.pi, 0.0)
    spread = raw.copy()
    for start in (0, 1):
        np.add.at(spread, ends[:, start], raw[ends[:, 1 - start]])
    return (spread / (neighbours + 1.0))[same].astype(np.float32)


def _find_doubles(positions: np.ndarray) -> np.ndarray:
    """Return for every vertex the one that stands for all in its place. (v,)"""
    order = np.lexsort((-np.arange(len(positions)), positions.sum(axis=1)))
    sums, same = positions.sum(axis=1)[order], np.arange(len(positions))
    ahead = np.searchsorted(sums, sums + 3.0 * SAME_PLACE, side="right")
    for place in np.flatnonzero(ahead > np.arange(len(order)) + 1):
        vertex, others = order[place], order[place + 1 : ahead[place]]
        near = ((positions[others] - positions[vertex]) ** 2).sum(axis=1) < SAME_PLACE
        if near.any():
            # The chain ends at the last of them in this order, as there.
            same[vertex] = others[np.flatnonzero(near)[0]]
    for place in range(len(order) - 1, -1, -1):
        vertex = order[place]
        same[vertex] = same[same[vertex]]
    return same


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)
