"""How near objects come to a point."""

import numpy as np

from .mesh import Mesh

CHUNK = 1 << 18
"""Triangles that are looked at together."""


def box_distance(point: np.ndarray, mesh: Mesh) -> float:
    """Distance of a point to the box around an object, along the axes: at most that to the object. [m]"""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    return float(np.linalg.norm(np.maximum(np.maximum(low - point, point - high), 0.0)))


def mesh_distance(point: np.ndarray, mesh: Mesh) -> float:
    """Distance of a point to the nearest place of an object's triangles. [m]"""
    return triangle_distance(point, mesh.vertices[mesh.triangles])


def triangle_distance(point: np.ndarray, corners: np.ndarray) -> float:
    """Distance of a point to the nearest place of triangles (n, 3, 3). [m]"""
    nearest = np.inf
    for first in range(0, len(corners), CHUNK):
        part = corners[first : first + CHUNK].astype(np.float64) - point
        nearest = min(nearest, float(_distances(part).min()))
    return nearest


def _distances(corners: np.ndarray) -> np.ndarray:
    """Distances of triangles from the origin: to their planes where the foot lies within, else to their edges. (n, 3, 3)"""
    edges = [(corners[:, i], corners[:, (i + 1) % 3]) for i in range(3)]
    found = np.min([_segment_distances(a, b) for a, b in edges], axis=0)
    a, b, c = (corners[:, i] for i in range(3))
    normal = np.cross(b - a, c - a)
    square = (normal**2).sum(axis=1)
    height = (a * normal).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        foot = normal * (height / square)[:, None]
        inside = square > 0.0
        for first, second in edges:
            inside &= (np.cross(second - first, foot - first) * normal).sum(axis=1) >= 0.0
        return np.where(inside, np.abs(height) / np.sqrt(square), found)


def _segment_distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances of segments from the origin. (n, 3), (n, 3) -> (n,)"""
    along = b - a
    square = (along**2).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(square > 0.0, -(a * along).sum(axis=1) / square, 0.0)
    return np.linalg.norm(a + np.clip(share, 0.0, 1.0)[:, None] * along, axis=1)
