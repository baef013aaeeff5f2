"""Lumels: where on the surface each pixel of a lux map lies, with several places in each for anti-aliasing."""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..scene.mesh import Mesh
from ..transport.illuminance import Receivers
from .unwrap import AtlasChart

MAXIMUM_PLACES = 1 << 22
"""Most places of one map; beyond, lumels hold fewer places each."""

CHUNK = 1 << 21
"""Candidates looked at in one go."""


@dataclass(frozen=True)
class Lumels:
    """Covered lumels of a map.

    Parameters
    ----------
    index : (n,) int array    Flat pixel index, row 0 at the bottom.
    area : (n,) float64 array    Surface in each lumel. [m2]
    receivers : Receivers    One per covered lumel.
    """

    index: np.ndarray
    area: np.ndarray
    receivers: Receivers


def rasterise(mesh: Mesh, charts: AtlasChart) -> Lumels:
    """Find the places of all lumels of a mesh.

    A lumel is covered when at least one of its regular sub-positions lies inside a triangle.

    Raises
    ------
    SceneError    No lumel is covered: the density is too low for the mesh.
    """
    pixels = charts.width * charts.height
    fine = int(np.clip(np.floor(np.sqrt(MAXIMUM_PLACES / pixels)), 1, 4))
    corners = charts.uv * np.array([charts.width * fine, charts.height * fine])
    triangle, cell, bary = _cover(corners, charts.width * fine, charts.height * fine)
    if len(triangle) == 0:
        raise SceneError(
            f"object '{mesh.name}': no lumel lies on the surface; raise the lumels per metre"
        )
    y, x = np.divmod(cell, charts.width * fine)
    lumel = (y // fine) * charts.width + x // fine
    order = np.argsort(lumel, kind="stable")
    lumel, triangle, bary = lumel[order], triangle[order], bary[order]
    index, start, count = np.unique(lumel, return_index=True, return_counts=True)

    points = mesh.vertices[mesh.triangles[triangle]]
    positions = np.einsum("kc,kcx->kx", bary, points)
    geometric = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    geometric /= np.maximum(np.linalg.norm(geometric, axis=1, keepdims=True), 1e-300)
    normals = geometric
    if mesh.corner_normals is not None:
        normals = np.einsum("kc,kcx->kx", bary, mesh.corner_normals[triangle].astype(np.float64))
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.where(length > 1e-6, normals / np.maximum(length, 1e-6), geometric)
    edge = corners[:, 1:] - corners[:, :1]
    flat_area = 0.5 * np.abs(edge[:, 0, 0] * edge[:, 1, 1] - edge[:, 0, 1] * edge[:, 1, 0])
    scale = np.where(flat_area > 0.0, mesh.areas() / np.maximum(flat_area, 1e-300), 0.0)
    area = np.add.reduceat(scale[triangle], start)
    return Lumels(index, area, Receivers(positions, normals, geometric, start, count, area))


def _cover(corners: np.ndarray, width: int, height: int):
    """Cells whose centre lies in a triangle.

    Parameters
    ----------
    corners : (t, 3, 2) float64 array    In cells.

    Returns
    -------
    triangle (k,), flat cell (k,), barycentric coordinates (k, 3); every cell at most once.
    """
    low = np.clip(np.ceil(corners.min(axis=1) - 0.5), 0, [width, height]).astype(np.int64)
    high = np.clip(np.floor(corners.max(axis=1) - 0.5) + 1, 0, [width, height]).astype(np.int64)
    size = np.maximum(high - low, 0)
    counts = size[:, 0] * size[:, 1]
    ends = np.cumsum(counts)
    found = []
    for begin in range(0, int(ends[-1]), CHUNK):
        number = np.arange(begin, min(begin + CHUNK, int(ends[-1])))
        triangle = np.searchsorted(ends, number, side="right")
        local = number - (ends[triangle] - counts[triangle])
        dy, dx = np.divmod(local, size[triangle, 0])
        x, y = low[triangle, 0] + dx, low[triangle, 1] + dy
        bary = _barycentric(corners[triangle], np.stack([x + 0.5, y + 0.5], axis=1))
        inside = (bary >= -1e-9).all(axis=1)
        found.append((triangle[inside], (y * width + x)[inside], bary[inside]))
    if not found:
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int), np.zeros((0, 3))
    triangle, cell, bary = (np.concatenate(parts) for parts in zip(*found, strict=True))
    cell, first = np.unique(cell, return_index=True)
    return triangle[first], cell, np.clip(bary[first], 0.0, 1.0)


def _barycentric(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]

    def cross(p, q):
        return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]

    whole = cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        v = cross(points - a, c - a) / whole
        w = cross(b - a, points - a) / whole
    bary = np.stack([1.0 - v - w, v, w], axis=1)
    return np.where(np.isfinite(bary), bary, -1.0)
