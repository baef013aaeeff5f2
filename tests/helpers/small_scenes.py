"""Small scenes shared by the engine's tests."""

import numpy as np

from lumenray.engine.scene.material import Diffuse, Material
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.session import Session


def box(width, depth, height, material="paint", inwards=True):
    """Axis-aligned box with one corner at the origin; its faces look inwards or outwards."""
    vertices = np.array(
        [[x, y, z] for x in (0, width) for y in (0, depth) for z in (0, height)], float
    )
    quads = [(0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)
    # The quads above look outwards.
    if inwards:
        triangles = triangles[:, ::-1]
    return Mesh(
        "box", "box", vertices, np.ascontiguousarray(triangles), (material,), np.zeros(12, np.int32)
    )


def quad(name, corner, edge_u, edge_v, material):
    """Parallelogram facing edge_u x edge_v."""
    corner, u, v = (np.asarray(x, float) for x in (corner, edge_u, edge_v))
    vertices = np.stack([corner, corner + u, corner + u + v, corner + v])
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    uv = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], np.float32)
    return Mesh(
        name, name, vertices, triangles, (material,), np.zeros(2, np.int32), uv_maps={"UV": uv}
    )


def paint(reflectance, name="paint", **more):
    """Neutral diffuse material."""
    return Material(name, name, Diffuse(Constant(reflectance)), **more)


def session_of(*items):
    """Session that holds the items."""
    session = Session(witness=False)
    session.apply(SceneDelta(changed=tuple(items)))
    return session
