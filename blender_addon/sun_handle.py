"""The sun that is dragged in a 3D view: a photo's Sun light, or the sun of the world's picture, which turns with it."""

import json
import math
from dataclasses import dataclass

import numpy as np

from ..engine.sky.cie import sun_direction
from .shadow_sun import find_free_sun, turn_sun
from .sun_direction import angles

LOWEST = math.radians(1.0)
"""Height below which no sun is dragged. [rad]"""


@dataclass(frozen=True, eq=False)
class SunHandle:
    """Where a sun is taken hold of.

    Parameters
    ----------
    middle : (3,) array    Of the sphere that it is dragged on. [Blender unit]
    radius : float    Of that. [Blender unit]
    towards : (3,) array    Unit vector to the sun.
    lamp : bpy.types.Object or None    The Sun light; None: the sun of the world's picture.
    """

    middle: np.ndarray
    radius: float
    towards: np.ndarray
    lamp: object | None


def find_handle(scene, chosen, middle=(0.0, 0.0, 0.0)) -> SunHandle | None:
    """Return the sun that can be dragged: a free Sun light over a photo's ground, else that of the world's picture; or None.

    Parameters
    ----------
    scene : bpy.types.Scene
    chosen : bpy.types.Object or None    The active object.
    middle : (3,) sequence    Of the ground. [Blender unit]
    """
    world = scene.world
    if world is None or world.lumenray.source != "NODES":
        return None
    place, radius = np.array(middle, dtype=np.float64), world.lumenray.arc.radius
    ground = world.lumenray.ground
    lamp = find_free_sun(scene, chosen) if ground.use_ground or ground.photo == "CAMERA" else None
    if lamp is not None:
        towards = np.array(lamp.matrix_world.col[2][:3], dtype=np.float64)
        return SunHandle(place, radius, towards / np.linalg.norm(towards), lamp)
    towards = sun_of_picture(world)
    return None if towards is None else SunHandle(place, radius, towards, None)


def drag_handle(scene, handle: SunHandle, towards: np.ndarray) -> None:
    """Turn the light, or the world's picture about the vertical so that its sun stands at this azimuth."""
    if handle.lamp is not None:
        turn_sun(handle.lamp, towards)
        return
    shown = sun_of_picture(scene.world)
    if shown is None:
        return
    change = angles(towards)[1] - angles(shown)[1]
    set_turn(scene.world, find_turn(scene.world) + change)


def find_towards(handle: SunHandle, origin, ray, is_front: bool) -> np.ndarray:
    """Return the direction from a handle's middle to where a ray meets its sphere, above the horizon. (3,)

    Parameters
    ----------
    handle : SunHandle
    origin, ray : (3,) array    Of the ray; its direction has the length 1.
    is_front : bool    Whether the nearer of two places is meant. Past the sphere it is where the ray comes nearest to it.
    """
    away = np.asarray(origin, dtype=np.float64) - handle.middle
    ray = np.asarray(ray, dtype=np.float64)
    along = -float(ray @ away)
    square = along**2 - float(away @ away) + handle.radius**2
    if square > 0.0:
        root = math.sqrt(square)
        along = along - root if is_front and along > root else along + root
    found = away + along * ray
    found = found / max(float(np.linalg.norm(found)), 1e-12)
    height, azimuth = angles(found)
    return sun_direction(max(height, LOWEST), azimuth)


def is_in_front(handle: SunHandle, origin) -> bool:
    """Tell whether a handle is on the near side of its sphere, seen from a place. ``origin``: (3,)"""
    return float(handle.towards @ (np.asarray(origin) - handle.middle)) > handle.radius


# ---- the world's picture ----


def keep_sun(world, sun) -> dict | None:
    """Return what is kept of a picture's sun, to show its handle. ``sun``: `SourceRow` or None."""
    turn = find_turn(world)
    if sun is None or turn is None:
        return None
    return {"elevation": sun.elevation, "azimuth": sun.azimuth, "turn": turn}


def sun_of_picture(world) -> np.ndarray | None:
    """Return where the sun of an analysed picture stands as the world is turned now; None where that is not known. (3,)"""
    kept = json.loads(world.lumenray.environment.found or "{}").get("sun")
    turn = find_turn(world)
    if kept is None or turn is None:
        return None
    azimuth = math.radians(kept["azimuth"]) + turn - kept["turn"]
    return sun_direction(math.radians(kept["elevation"]), azimuth)


def find_turn(world) -> float | None:
    """Return by what a world's picture is turned, clockwise from above; None where it is laid in another way. [rad]"""
    texture = _texture(world)
    if texture is None:
        return None
    mapping = _mapping(texture)
    if mapping is None:
        return None if texture.inputs["Vector"].is_linked else 0.0
    x, y, z = mapping.inputs["Rotation"].default_value
    if abs(x) > 1e-6 or abs(y) > 1e-6 or mapping.vector_type not in {"POINT", "TEXTURE"}:
        return None
    return z if mapping.vector_type == "POINT" else -z


def set_turn(world, turn: float) -> None:
    """Turn a world's picture, by a Mapping before it that is made where there is none. [rad]"""
    texture, tree = _texture(world), world.node_tree
    mapping = _mapping(texture)
    if mapping is None:
        mapping, where = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Mapping", "TexCoord"))
        x, y = texture.location
        mapping.location, where.location = (x - 200.0, y), (x - 400.0, y)
        tree.links.new(where.outputs["Generated"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    turn = math.remainder(turn, math.tau)
    mapping.inputs["Rotation"].default_value[2] = turn if mapping.vector_type == "POINT" else -turn


def _texture(world):
    """The one Environment Texture of a world, None where there are none or several."""
    tree = world.node_tree
    nodes = [] if tree is None else [n for n in tree.nodes if n.type == "TEX_ENVIRONMENT"]
    return nodes[0] if len(nodes) == 1 else None


def _mapping(texture):
    links = texture.inputs["Vector"].links
    node = links[0].from_node if links else None
    return node if node is not None and node.type == "MAPPING" else None
