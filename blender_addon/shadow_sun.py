"""The Sun light of a photo, turned to where the shadows in it come from."""

import math

import bpy
import numpy as np
from mathutils import Vector

from ..engine.sky.shadow_sun import find_sun
from .foundation.exposure import white_luminance
from .foundation.units import metres_per_unit
from .sync.grounds import WHITE, camera_of

SUN_ANGLE = math.radians(0.533)
"""Angular diameter of the sun. [rad]"""

SUN_SHARE = 0.8
"""What the sun of a clear day gives a level plane, over what it and the sky give: four times the sky's. [-]"""

NAME = "Photo Sun"


def sun_of_shadow(depsgraph, level: float, foot, top, end) -> np.ndarray:
    """Return the direction to the sun by places in the film of the scene's camera; as of `engine.sky.shadow_sun.find_sun`.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
    level : float    Height of the ground. [Blender unit]

    Raises
    ------
    SceneError    They cannot be a thing and its shadow.
    """
    scale = metres_per_unit(depsgraph.scene)
    return find_sun(camera_of(depsgraph), level * scale, foot, top, end)


def film_place(corners: np.ndarray, mouse) -> np.ndarray:
    """Return a place in the film as shares of its sides. (2,)

    Parameters
    ----------
    corners : (2, 2) array    Where the film's lower left and upper right corner are in the region. [pixel]
    mouse : (2,) array    [pixel]
    """
    low, high = np.asarray(corners, dtype=np.float64)
    return (np.asarray(mouse, dtype=np.float64) - low) / (high - low)


def find_free_sun(scene, chosen):
    """Return the Sun light that may be turned: the chosen object if it follows no time, or that of `NAME`, or None."""
    follower = None if scene.world is None else scene.world.lumenray.sun.lamp
    known = scene.objects.get(NAME)
    for each in (chosen, known):
        is_sun = each is not None and each.type == "LIGHT" and each.data.type == "SUN"
        if is_sun and each is not follower:
            return each
    return None


def sun_for(scene, chosen):
    """Return the Sun light that is turned: as `find_free_sun`, made where there is none."""
    found = find_free_sun(scene, chosen)
    if found is not None:
        return found
    made = bpy.data.objects.new(NAME, bpy.data.lights.new(NAME, "SUN"))
    made.data.angle = SUN_ANGLE
    scene.collection.objects.link(made)
    own = made.data.lumenray
    own.use_physical, own.quantity = True, "ILLUMINANCE"
    return made


def turn_sun(lamp, towards: np.ndarray) -> None:
    """Turn a Sun light so that it shines from a direction."""
    turned = Vector([float(x) for x in towards]).to_track_quat("Z", "Y")
    lamp.rotation_mode = "XYZ"
    lamp.rotation_euler = turned.to_euler()


def light_sun(lamp, scene, towards: np.ndarray) -> None:
    """Give a new Sun light the illuminance of `illuminance_for`."""
    lamp.data.lumenray.value = illuminance_for(scene, towards)


def illuminance_for(scene, towards: np.ndarray) -> float:
    """Return what faces a new sun gets, if white matt ground in it and in a clear sky is to show as white. [lx]"""
    white = white_luminance(scene.lumenray) or WHITE
    return SUN_SHARE * math.pi * white / max(float(towards[2]), 0.05)
