"""Boxes, balls and rectangles of triangles."""

from dataclasses import replace

import numpy as np

from ...engine.scene.mesh import Mesh


def make_box(size, hole: float = 0.0) -> Mesh:
    """Room of a size (3,) whose faces look inwards; its ceiling may have a square hole in the middle. [m]"""
    x, y, z = size = np.asarray(size, float)
    vertices = [[a, b, c] for a in (0.0, x) for b in (0.0, y) for c in (0.0, z)]
    quads = [(0, 2, 6, 4), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5)]
    if not hole:
        quads.append((1, 5, 7, 3))
    triangles = [t[::-1] for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    if hole:
        low, high = 0.5 * (size[:2] - hole), 0.5 * (size[:2] + hole)
        strips = [(0, 0, x, low[1]), (0, high[1], x, y),
                  (0, low[1], low[0], high[1]), (high[0], low[1], x, high[1])]  # fmt: skip
        for a, b, c, d in strips:
            first = len(vertices)
            vertices += [[a, b, z], [c, b, z], [c, d, z], [a, d, z]]
            triangles += [(first, first + 2, first + 1), (first, first + 3, first + 2)]
    return make_mesh("room", np.array(vertices, float), triangles, "paint")


def make_ball(
    name: str, radius: float, centre, material: str, rings: int, inwards=False, smooth=True
) -> Mesh:
    """Sphere of triangles that look outwards or inwards; ``smooth``: with the true sphere's normals. [m]"""
    theta = np.linspace(0.0, np.pi, rings + 1)
    phi = np.linspace(0.0, 2.0 * np.pi, 2 * rings, endpoint=False)
    unit = np.stack(
        [np.outer(np.sin(theta), np.cos(phi)), np.outer(np.sin(theta), np.sin(phi)),
         np.outer(np.cos(theta), np.ones_like(phi))], axis=-1,
    ).reshape(-1, 3)  # fmt: skip
    row, column = (each.ravel() for each in np.mgrid[0:rings, 0 : 2 * rings])
    a, b = row * 2 * rings + column, row * 2 * rings + (column + 1) % (2 * rings)
    c, d = a + 2 * rings, b + 2 * rings
    upper = np.stack([a, c, d], axis=1)[row < rings - 1]
    triangles = np.concatenate([upper, np.stack([a, d, b], axis=1)[row > 0]])
    if inwards:
        triangles = triangles[:, ::-1]
    made = make_mesh(name, radius * unit + np.asarray(centre, float), triangles, material)
    if not smooth:
        return made
    normals = (-unit if inwards else unit)[made.triangles].astype(np.float32)
    return replace(made, corner_normals=normals)


def make_rectangle(name: str, corner, edge_u, edge_v, material: str) -> Mesh:
    """Parallelogram that looks along edge_u x edge_v. [m]"""
    corner, u, v = (np.asarray(each, float) for each in (corner, edge_u, edge_v))
    corners = np.array([corner, corner + u, corner + u + v, corner + v])
    return make_mesh(name, corners, [[0, 1, 2], [0, 2, 3]], material)


def make_mesh(name: str, vertices, triangles, material: str) -> Mesh:
    """Triangles of one material."""
    faces = np.ascontiguousarray(triangles, dtype=np.int32)
    return Mesh(name, name, vertices, faces, (material,), np.zeros(len(faces), np.int32))
