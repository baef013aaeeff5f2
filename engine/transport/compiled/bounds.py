"""Where a scene lies, and the frame that it is computed in."""

import numpy as np

from ...errors import SceneError
from ...scene.checks import FARTHEST, check_reach
from ...scene.light import PlacedLight
from ...scene.mesh import Mesh
from ...scene.scene import Scene
from .bodies import extent


def frame_of(scene_low: np.ndarray, scene_high: np.ndarray) -> tuple[np.ndarray, float]:
    """Origin of the compiled frame and radius of everything around it. [m]

    The origin lies on a grid about as coarse as the scene is large, so that positions are small numbers and yet hardly any
    edit moves it.
    """
    if not np.all(scene_low <= scene_high):
        return np.zeros(3), 1.0
    half = 0.5 * float((scene_high - scene_low).max())
    grid = 2.0 ** max(np.floor(np.log2(max(half, 1.0))) - 1.0, 0.0)
    origin = np.round(0.5 * (scene_low + scene_high) / grid) * grid
    return origin, float(np.linalg.norm(np.maximum(scene_high - origin, origin - scene_low)))


def find_bounds(scene: Scene, bodies=None) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of everything, objects by their boxes. ``bodies``: known extents. (3,), (3,) [m]"""
    low, high = [np.full(3, np.inf)], [np.full(3, -np.inf)]
    if bodies is None:
        for item in scene.meshes.values():
            geometry = None if isinstance(item, Mesh) else scene.geometries.get(item.geometry)
            lowest, highest = extent(item, geometry)
            if np.all(lowest <= highest):
                check_reach(f"object '{item.name}'", lowest, highest)
            low.append(lowest)
            high.append(highest)
    else:
        for body in bodies:
            # Boxes of nothing are endless the wrong way round.
            if not np.abs(body.high).max() <= FARTHEST and np.all(body.low <= body.high):
                check_reach(f"object '{body.item.name}'", body.low, body.high)
            low.append(body.low)
            high.append(body.high)
    for light in scene.lights.values():
        if isinstance(light, PlacedLight) and light.output.value > 0.0:
            low.append(light.place - light.reach)
            high.append(light.place + light.reach)
    low, high = np.min(low, axis=0), np.max(high, axis=0)
    is_empty = np.isposinf(low).all() and np.isneginf(high).all()
    if not is_empty and not (np.isfinite(low) & np.isfinite(high)).all():
        raise SceneError("a mesh or light has a position that is not a finite number")
    return low, high
