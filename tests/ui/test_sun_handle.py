"""Handles of suns in the 3D view: where they stand, and what dragging them turns."""

import math

import bpy
import numpy as np
import pytest
from picture_worlds import image_of, show

from lumenray.benchmarks.environment.drawn_maps import Spot, make_map
from lumenray.blender_addon.environment.found import analyse_world
from lumenray.blender_addon.sun_handle import (
    SunHandle,
    drag_handle,
    find_handle,
    find_towards,
    find_turn,
    is_in_front,
)
from lumenray.engine.sky.cie import sun_direction


@pytest.fixture
def world():
    pixels = make_map(128, [Spot(40.0, 120.0, 3.0, 1.0)], sky=1.0, ground=0.2)
    return show(image_of(pixels), (0.0, 0.0, 0.3))[0]


def degrees_between(first, second):
    return math.degrees(math.acos(min(float(np.dot(first, second)), 1.0)))


def test_a_ray_to_a_handle_leads_back_to_its_direction():
    towards = sun_direction(0.6, 2.0)
    handle = SunHandle(np.array([1.0, 2.0, 0.5]), 5.0, towards, None)
    place = handle.middle + 5.0 * towards
    for eye in (np.array([30.0, -4.0, 9.0]), np.array([-20.0, 15.0, 6.0]), handle.middle + 0.1):
        ray = (place - eye) / np.linalg.norm(place - eye)
        found = find_towards(handle, eye, ray, is_in_front(handle, eye))
        assert degrees_between(found, towards) < 1e-3
    # Past the sphere, and below the horizon.
    aside = find_towards(handle, [0.0, -50.0, 0.5], [0.0, 0.6, 0.8], True)
    assert np.isfinite(aside).all() and aside[2] > 0.0
    below = find_towards(handle, [1.0, -50.0, -3.0], [0.0, 1.0, 0.0], True)
    assert math.degrees(math.asin(below[2])) == pytest.approx(1.0)


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE"])
def test_a_pictures_sun_is_where_the_handle_is_dragged_to(world, kind):
    """By an analysis of the picture as it is laid after the drag."""
    mapping = next(n for n in world.node_tree.nodes if n.type == "MAPPING")
    mapping.vector_type = kind
    scene = bpy.context.scene
    assert find_handle(scene, None) is None
    assert bpy.ops.lumenray.analyse_environment(use_picture=False) == {"FINISHED"}
    before = analyse_world(world, 177.83).analysis.sun
    handle = find_handle(scene, None)
    assert (
        degrees_between(
            handle.towards,
            sun_direction(math.radians(before.elevation), math.radians(before.azimuth)),
        )
        < 1e-3
    )
    drag_handle(scene, handle, sun_direction(0.2, math.radians(250.0)))
    after = analyse_world(world, 177.83).analysis.sun
    assert after.azimuth == pytest.approx(250.0, abs=0.1)
    assert after.elevation == pytest.approx(before.elevation, abs=0.01)
    shown = sun_direction(math.radians(after.elevation), math.radians(250.0))
    assert degrees_between(find_handle(scene, None).towards, shown) < 0.01
    # Let go with Esc it is where it was.
    drag_handle(scene, handle, handle.towards)
    assert analyse_world(world, 177.83).analysis.sun.azimuth == pytest.approx(
        before.azimuth, abs=0.1
    )


def test_a_picture_without_a_mapping_gets_one(world):
    tree = world.node_tree
    for node in [n for n in tree.nodes if n.type in {"MAPPING", "TEX_COORD"}]:
        tree.nodes.remove(node)
    assert find_turn(world) == 0.0
    bpy.ops.lumenray.analyse_environment(use_picture=False)
    scene = bpy.context.scene
    drag_handle(scene, find_handle(scene, None), sun_direction(0.5, math.radians(10.0)))
    assert analyse_world(world, 177.83).analysis.sun.azimuth == pytest.approx(10.0, abs=0.1)


def test_a_photos_sun_light_comes_before_the_pictures(world):
    scene = bpy.context.scene
    lamp = bpy.data.objects.new("Photo Sun", bpy.data.lights.new("Photo Sun", "SUN"))
    scene.collection.objects.link(lamp)
    assert find_handle(scene, None) is None
    world.lumenray.ground.use_ground = True
    bpy.context.view_layer.update()
    handle = find_handle(scene, None, (1.0, 0.0, 0.0))
    assert handle.lamp is lamp and tuple(handle.middle) == (1.0, 0.0, 0.0)
    towards = sun_direction(0.7, 4.0)
    drag_handle(scene, handle, towards)
    bpy.context.view_layer.update()
    assert degrees_between(find_handle(scene, None).towards, towards) < 0.01
