"""Bent and knotted meshes, and whether their charts keep the rules."""

import numpy as np

from lumenray.engine.atlas.charts import ChartLimits
from lumenray.engine.scene.mesh import Mesh

NO_SEARCH = ChartLimits(faces=0)
"""Everything is cut by its normals."""


def mesh_of(vertices, triangles, polygon=None):
    triangles = np.array(triangles, np.int32).reshape(-1, 3)
    return Mesh(
        "m", "m", np.array(vertices, float), triangles, ("p",), np.zeros(len(triangles), np.int32),
        polygon=None if polygon is None else np.asarray(polygon, np.int32),
    )  # fmt: skip


def sheet(columns, rows, place, closed=(False, False)):
    """Quads over the unit square, laid out in space by a function of (u, v); polygons are the quads."""
    u = np.arange(columns + (not closed[0])) / columns
    v = np.arange(rows + (not closed[1])) / rows
    points = np.stack(place(*np.meshgrid(u, v, indexing="ij")), axis=-1).reshape(-1, 3)
    i, j = (
        each.ravel() for each in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    )
    right, up = (i + 1) % len(u), (j + 1) % len(v)
    a, b, c, d = i * len(v) + j, right * len(v) + j, right * len(v) + up, i * len(v) + up
    triangles = np.stack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)], axis=1)
    return mesh_of(points, triangles, np.repeat(np.arange(len(i)), 2))


def torus(columns=32, rows=16):
    def place(u, v):
        ring = 3.0 + np.cos(2 * np.pi * v)
        return ring * np.cos(2 * np.pi * u), ring * np.sin(2 * np.pi * u), np.sin(2 * np.pi * v)

    return sheet(columns, rows, place, (True, True))


def rough_ground(size=20, height=1.0):
    heights = np.random.default_rng(5).normal(size=(size + 1, size + 1)) * height
    return sheet(size, size, lambda u, v: (size * u, size * v, heights))


def knot():
    """A bumpy closed surface with bent quads, which neither projection nor xatlas finds easy."""
    rng = np.random.default_rng(8)
    whole = torus(40, 20)
    return mesh_of(
        whole.vertices + rng.normal(size=whole.vertices.shape) * 0.06,
        whole.triangles,
        whole.polygon,
    )


def signed_areas(uv):
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    return 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def normals(mesh):
    corners = mesh.vertices[mesh.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-300)


def count_sheets(uv, rng, points=6):
    """Most triangles over any of some places inside the triangles of one chart, their very edges apart."""
    weight = rng.dirichlet((1.0, 1.0, 1.0), (len(uv), points))
    places = np.einsum("tkc,tcx->tkx", weight, uv).reshape(-1, 2)
    area = signed_areas(uv)
    most = 0
    for part in np.array_split(places, max(len(places) // 500, 1)):
        over = np.ones((len(part), len(uv)), bool)
        for i in range(3):
            start, edge = uv[:, i], uv[:, (i + 1) % 3] - uv[:, i]
            away = part[:, None] - start
            side = edge[:, 0] * away[..., 1] - edge[:, 1] * away[..., 0]
            over &= side > 1e-4 * np.maximum(area, 1e-12)
        most = max(most, over.sum(axis=1).max())
    return most


def check(mesh, charts, cone=None):
    """Rules that hold for every mesh."""
    assert np.isfinite(charts.uv).all()
    assert np.isfinite(charts.size).all()
    shown = charts.chart >= 0
    area = mesh.areas()
    assert np.array_equal(np.unique(charts.chart[shown]), np.arange(len(charts.size)))
    if not shown.any():
        return
    # Area is kept, of every chart and of all.
    flat = signed_areas(charts.uv)
    assert (flat[shown] >= -1e-4 * area[shown].max()).all()
    both = [
        np.bincount(charts.chart[shown], each[shown], minlength=len(charts.size))
        for each in (area, flat)
    ]
    assert np.allclose(both[0], both[1], rtol=1e-4, atol=1e-9 * area.sum())
    # Charts begin at 0 and are as large as said, long side first.
    for corner, size in ((charts.uv.min(axis=1), None), (charts.uv.max(axis=1), charts.size)):
        for k in range(2):
            limit = np.full(len(charts.size), np.inf if size is None else -np.inf)
            reduce = np.minimum if size is None else np.maximum
            reduce.at(limit, charts.chart[shown], corner[shown, k])
            assert np.allclose(
                limit, 0.0 if size is None else size[:, k], atol=1e-9 + 1e-9 * charts.size.max()
            )
    assert (charts.size[:, 0] >= charts.size[:, 1] * (1 - 1e-6)).all()
    rng = np.random.default_rng(0)
    direction = normals(mesh)
    for number in range(min(len(charts.size), 200)):
        rows = np.flatnonzero(charts.chart == number)
        assert count_sheets(charts.uv[rows], rng) <= 1
        if cone is not None:
            mean = (direction[rows] * area[rows][:, None]).sum(axis=0)
            angle = np.arccos(np.clip(direction[rows] @ mean / np.linalg.norm(mean), -1, 1))
            one_polygon = mesh.polygon is not None and len(np.unique(mesh.polygon[rows])) == 1
            assert angle.max() <= cone + 1e-6 or one_polygon


def check_polygons(mesh, charts):
    """All triangles of a polygon lie in one chart, and each of its vertices in one place."""
    shown = charts.chart >= 0
    chart = np.full(mesh.polygon.max() + 1, -1)
    chart[mesh.polygon[shown]] = charts.chart[shown]
    assert (charts.chart[shown] == chart[mesh.polygon[shown]]).all()
    placed = np.repeat(chart[mesh.polygon] >= 0, 3)
    key = (mesh.polygon[:, None].astype(int) * len(mesh.vertices) + mesh.triangles).ravel()
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    flat = charts.uv.reshape(-1, 2)
    apart = np.abs(flat - flat[first[inverse.reshape(-1)]]).max(axis=1)
    assert apart[placed].max() < 1e-6 * charts.size.max()
