"""Meshes with layouts of one chart or few, and where their lumels' places lie."""

import numpy as np

from lumenray.engine.atlas.layout import Atlas, SurfaceLayout
from lumenray.engine.scene.mesh import Mesh


def mesh_of(vertices, triangles, **more):
    triangles = np.asarray(triangles, np.int32)
    return Mesh(
        "m", "m", np.asarray(vertices, float), triangles, ("paint",),
        np.zeros(len(triangles), np.int32), **more,
    )  # fmt: skip


def atlas_of(uv, density, size=64, chart=None, page=None, is_back=False):
    count = len(uv)
    layout = SurfaceLayout(
        np.asarray(uv, float),
        np.zeros(count, np.int32) if page is None else page,
        np.zeros(count, np.int32) if chart is None else chart,
        density,
        density,
        is_back,
    )
    pages = int(layout.page.max()) + 1
    return Atlas(np.full((pages, 2), size), (layout,), int(layout.chart.max()) + 1, 1.0)


def flat_atlas(mesh, density, size=64, offset=(2.0, 2.0), drop=2, **more):
    """Layout of a plane mesh by its own coordinates but one."""
    kept = [axis for axis in range(3) if axis != drop]
    corners = mesh.vertices[mesh.triangles][..., kept]
    corners = corners - corners.reshape(-1, 2).min(axis=0)
    return atlas_of(corners * density + np.asarray(offset), density, size, **more)


def square_of_random_triangles(seed, count=60, side=3.0):
    """Square cut into triangles by inserting random points, some close together and some on edges. (v, 3), (t, 3)"""
    rng = np.random.default_rng(seed)
    points = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)]
    triangles = [(0, 1, 2), (0, 2, 3)]
    for _ in range(count):
        number = rng.integers(len(triangles))
        a, b, c = triangles.pop(number)
        weight = rng.dirichlet(np.full(3, rng.choice([0.05, 1.0])))
        points.append(tuple(weight @ np.array([points[a], points[b], points[c]])))
        new = len(points) - 1
        triangles += [(a, b, new), (b, c, new), (c, a, new)]
    return np.column_stack([points, np.zeros(len(points))]), np.array(triangles)


def place_uv(mesh, atlas, block):
    """Places on the page, from their positions in the world and the triangles that they are said to lie in."""
    points = mesh.vertices[mesh.triangles[block.triangle]]
    a, b, c = points[:, 0], points[:, 1], points[:, 2]
    normal = np.cross(b - a, c - a)
    square = np.maximum(np.einsum("kx,kx->k", normal, normal), 1e-300)
    away = block.receivers.positions - a
    v = np.einsum("kx,kx->k", np.cross(away, c - a), normal) / square
    w = np.einsum("kx,kx->k", np.cross(b - a, away), normal) / square
    bary = np.stack([1.0 - v - w, v, w], axis=1)
    uv = atlas.layouts[block.layout].uv[block.triangle]
    return bary, np.einsum("kc,kcx->kx", bary, uv)


def same_blocks(a, b):
    names = ("index", "chart", "area", "valid", "triangle")
    held = ("positions", "normals", "geometric_normals", "start", "count", "weights")
    return all(np.array_equal(getattr(a, n), getattr(b, n)) for n in names) and all(
        np.array_equal(getattr(a.receivers, n), getattr(b.receivers, n)) for n in held
    )
