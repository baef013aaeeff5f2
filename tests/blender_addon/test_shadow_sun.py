"""The Sun light of a photo: turned by a shadow in the camera's view, with the light of a clear day."""

import math

import bpy
import numpy as np
import pytest
from blender_objects import new_world
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

from lumenray.blender_addon import shadow_sun

pytestmark = pytest.mark.usefixtures("extension")


def eye(scale=1.0):
    data = bpy.data.cameras.new("Eye")
    data.lens, data.shift_x = 40.0, 0.06
    item = bpy.data.objects.new("Eye", data)
    item.location, item.rotation_euler = (1.0, -7.0, 1.7), (math.radians(80), 0, math.radians(8))
    scene = bpy.context.scene
    scene.collection.objects.link(item)
    scene.camera = item
    scene.render.resolution_x, scene.render.resolution_y = 300, 200
    scene.unit_settings.scale_length = scale
    bpy.context.view_layer.update()
    return item


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_a_shadow_in_blenders_own_view_of_the_camera_gives_the_sun(scale):
    """Places are those of Blender's own projection."""
    item, scene = eye(scale), bpy.context.scene
    sun = np.array([0.4, 0.5, 0.6]) / np.linalg.norm([0.4, 0.5, 0.6])
    foot, top = np.array([0.2, 0.5, 0.1]), np.array([0.2, 0.5, 1.1])
    end = top - sun / sun[2]
    places = [
        np.array(world_to_camera_view(scene, item, Vector(each)))[:2] for each in (foot, top, end)
    ]
    found = shadow_sun.sun_of_shadow(bpy.context.evaluated_depsgraph_get(), 0.1, *places)
    assert np.degrees(np.arccos(min(found @ sun, 1.0))) < 0.01


def test_places_in_the_film_are_shares_of_its_sides():
    corners = [(100.0, 50.0), (500.0, 250.0)]
    assert shadow_sun.film_place(corners, (300.0, 100.0)) == pytest.approx((0.5, 0.25))


def test_a_sun_is_turned_or_made_but_none_that_follows_the_time():
    world, _ = new_world((1, 1, 1), 1.0)
    scene = bpy.context.scene
    scene.world = world
    made = shadow_sun.sun_for(scene, None)
    assert shadow_sun.sun_for(scene, None) is made
    own = bpy.data.objects.new("Own", bpy.data.lights.new("Own", "SUN"))
    scene.collection.objects.link(own)
    assert shadow_sun.sun_for(scene, own) is own
    world.lumenray.sun.lamp = own
    assert shadow_sun.sun_for(scene, own) is made
    towards = np.array([0.6, 0.0, 0.8])
    shadow_sun.turn_sun(made, towards)
    bpy.context.view_layer.update()
    assert np.array(made.matrix_world.col[2])[:3] == pytest.approx(towards, abs=1e-6)
    # On level ground four fifths of what makes white matt ground white.
    white = scene.lumenray.white_luminance
    shadow_sun.light_sun(made, scene, towards)
    assert made.data.lumenray.use_physical and made.data.lumenray.quantity == "ILLUMINANCE"
    level = made.data.lumenray.value * towards[2]
    assert level / math.pi == pytest.approx(0.8 * white, rel=1e-6)
