"""What a picture tells of the first surfaces, at the pixels' centres."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ..compiled.compile import CompiledScene
from .film import sees
from .visibility import first_seen

FAR = 1e10
"""Depth where nothing is seen, Blender's own value. [m]"""


def first_layers(scene: CompiledScene, film) -> dict:
    """Depth, normal and indices at the centres of the pixels."""
    camera = film.camera
    shape = (camera.height, camera.width)
    pixel = dr.arange(mi.UInt32, camera.width * camera.height)
    ray = film.ray(
        mi.Float(pixel % camera.width) + 0.5,
        mi.Float(pixel // camera.width) + 0.5,
        mi.Point2f(0.5, 0.5),
    )
    si = first_seen(scene, ray, sees(ray), coherent=True)
    valid = si.is_valid()
    if camera.projection.is_panoramic:
        depth = dr.norm(si.p - film.position)
    else:
        depth = dr.dot(si.p - film.position, film.forward())
    normal = dr.select(valid, si.sh_frame.n * dr.select(dr.dot(si.n, ray.d) < 0.0, 1.0, -1.0), 0.0)
    layers = {
        "depth": np.array(dr.select(valid, depth, FAR), dtype=np.float32).reshape(shape),
        "normal": np.stack([np.array(c, dtype=np.float32) for c in normal], axis=-1).reshape(
            *shape, 3
        ),
    }
    ids = dr.reinterpret_array(mi.UInt32, si.shape)
    for name in ("object", "material"):
        table = scene.indices.get(name)
        values = mi.Float(0.0)
        if table is not None:
            values = dr.gather(mi.Float, table, ids, valid)
        layers[f"{name}_index"] = np.broadcast_to(
            np.array(values, dtype=np.float32), (shape[0] * shape[1],)
        ).reshape(shape)
    return layers
