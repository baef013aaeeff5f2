"""Normals at places of surfaces, and steps from lumel to lumel."""

import numpy as np

from ..scene.mesh import Mesh
from .layout import SurfaceLayout


def find_facings(points: np.ndarray):
    """Unit normals of triangles (t, 3, 3) in single precision, and their areas. (t, 3), (t,)"""
    normal = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    length = np.linalg.norm(normal, axis=1)
    return (normal / np.maximum(length, 1e-300)[:, None]).astype(np.float32), 0.5 * length


def find_normals(mesh: Mesh, triangle, bary, geometric) -> np.ndarray:
    """Shading normals of places; the true ones themselves where the mesh is flat. (k, 3) float32"""
    if mesh.corner_normals is None:
        return geometric
    corners = mesh.corner_normals[triangle].astype(np.float32, copy=False)
    normals = np.einsum("kc,kcx->kx", bary.astype(np.float32), corners)
    length = np.sqrt(np.einsum("kx,kx->k", normals, normals))
    # Normals that look into the surface would receive nothing.
    usable = (length > 1e-6) & (np.einsum("kx,kx->k", normals, geometric) > 0.0)
    normals /= np.maximum(length, np.float32(1e-6))[:, None]
    return np.where(usable[:, None], normals, geometric)


def find_lumel_axes(mesh: Mesh, layout: SurfaceLayout, triangle: np.ndarray):
    """Steps on the surface for one lumel to the right and one upwards, by the triangles there.

    Returns
    -------
    (n, 3), (n, 3), (n,) bool    Both [m], and whether they are the layout's: of slivers they are made up.
    """
    points = mesh.vertices[mesh.triangles[triangle]]
    corners = layout.uv[triangle].astype(np.float64)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    whole = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    along, across = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    side = 1.0 / layout.density
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        u = (along * second[:, 1:] - across * first[:, 1:]) / whole[:, None]
        v = (across * first[:, :1] - along * second[:, :1]) / whole[:, None]
        lengths = np.stack([np.linalg.norm(u, axis=1), np.linalg.norm(v, axis=1)])
        usable = ((lengths > 0.25 * side) & (lengths < 4.0 * side)).all(axis=0)
    # Slivers do not tell their own slope; any frame in their plane will do.
    normal = np.cross(along, across)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.where(length > 0.0, normal / np.maximum(length, 1e-300), [0.0, 0.0, 1.0])
    helper = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    other = np.cross(helper, normal)
    other *= side / np.linalg.norm(other, axis=1, keepdims=True)
    u = np.where(usable[:, None], u, other)
    v = np.where(usable[:, None], v, np.cross(normal, other))
    return u, v, usable
