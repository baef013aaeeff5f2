"""What moves in live scenes: blocks, a lamp and a camera."""

import numpy as np
from small_scenes import box

from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import AreaLight, Output, Quantity
from lumenray.engine.scene.mesh import Geometry
from lumenray.engine.scene.spectrum import Blackbody


def frame_at(x, y, z, turn=0.0, size=1.0):
    """Placement turned about z."""
    frame = np.eye(4)
    c, s = np.cos(turn) * size, np.sin(turn) * size
    frame[:3, :3] = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, size]]
    frame[:3, 3] = [x, y, z]
    return frame


def block(key, seed=0, fine=3):
    """Lumpy closed body about the origin, smooth or flat, with coordinates."""
    rng = np.random.default_rng(seed)
    outside = box(1, 1, 1, inwards=False)
    vertices = outside.vertices - 0.5 + 0.1 * rng.random((8, 3))
    triangles = outside.triangles
    normals = None
    if seed % 2:
        normals = vertices[triangles] / np.linalg.norm(vertices[triangles], axis=2, keepdims=True)
    uv = rng.random((len(triangles), 3, 2)).astype(np.float32)
    slots = (np.arange(len(triangles)) % 2).astype(np.int32)
    normals = None if normals is None else normals.astype(np.float32)
    return Geometry(key, vertices.astype(np.float32), triangles, slots, normals, {"UV": uv})


def camera_at(x, y, z, width=48, height=36, wide=1.2):
    """Camera that looks down."""
    return Camera(
        frame_at(x, y, z), Projection.PERSPECTIVE, width, height, wide, wide * height / width
    )


def lamp(key, x, y, z, lumens=1000.0, kelvin=3000.0, size=0.4):
    return AreaLight(
        key,
        key,
        Output(Quantity.LUMINOUS_FLUX, lumens, Blackbody(kelvin)),
        frame_at(x, y, z),
        size,
        size,
    )
