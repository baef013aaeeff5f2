"""Portals of Cycles: openings, and no lights."""

import math

import bpy
import numpy as np
from blender_objects import needs_cycles
from blender_skies import add_portal, measure_sky
from conversion import converted_scene
from kept_scenes import KeptScene

from lumenray.engine.scene.material import Transparent
from lumenray.engine.scene.scene import Scene


@needs_cycles
def test_a_portal_is_an_opening_and_no_light(world):
    portal = add_portal((1, 2, 3))
    portal.data.shape, portal.data.size_y = "RECTANGLE", 2.0
    portal.rotation_euler.x = math.radians(90)
    made = converted_scene()
    scene = Scene()
    scene.apply(made.delta)
    assert not scene.lights
    assert not made.objects
    mesh = scene.mesh(f"object:{portal.lumenray.uid}")
    assert not mesh.visible_to_camera
    assert isinstance(scene.materials[mesh.materials[0]].surface, Transparent)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    # The beam's direction, local -z, is now +y.
    np.testing.assert_allclose((low + high) / 2, (1, 2, 3), atol=2e-3)
    np.testing.assert_allclose(high - low, (0.5, 0, 2), atol=1e-6)
    corner, u, v = mesh.vertices[mesh.triangles[0]]
    assert np.cross(u - corner, v - corner)[1] > 0


@needs_cycles
def test_portals_are_kept_current(world):
    portal = add_portal()
    kept = KeptScene.started()
    portal.location.x = 1.0
    assert kept.sent() == (["Placement"], 0)
    portal.data.size = 2.0
    assert kept.sent() == (["Placement"], 0)
    portal.data.energy = 50.0
    assert kept.sent() == ([], 0)
    portal.data.cycles.is_portal = False
    portal.data.update_tag()
    kinds, removed = kept.sent()
    assert (kinds, removed) == (["AreaLight"], 3)
    portal.data.cycles.is_portal = True
    portal.data.update_tag()
    assert sorted(kept.sent()[0]) == ["Geometry", "Material", "Placement"]
    bpy.data.objects.remove(portal)
    assert kept.sent() == ([], 3)


@needs_cycles
def test_a_portal_changes_the_noise_and_nothing_else(world, session):
    """Below a square hole in a black box, by the configuration factor of a rectangle."""
    settings = world.lumenray.sky
    settings.type, settings.illuminance, settings.ground_reflectance = "5", 1000.0 * math.pi, 0.0
    half = 0.1
    rings = [(half, 1), (2, 1), (2, -1)]
    corners = [(x, y, z) for r, z in rings for x, y in ((-r, -r), (r, -r), (r, r), (-r, r))]
    faces = [(i, (i + 1) % 4 + i // 4 * 4, (i + 1) % 4 + i // 4 * 4 + 4, i + 4) for i in range(8)]
    box = bpy.data.meshes.new("Box")
    box.from_pydata(corners, [], [*faces, (8, 9, 10, 11)])
    black = bpy.data.materials.new("Black")
    black.lumenray.use_override = True
    black.lumenray.reflectance = 0.0
    box.materials.append(black)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Box", box))
    root = math.sqrt(1 + half**2)
    expected = 1000.0 * 4 * half / root * math.atan(half / root)
    readings = []
    for _ in range(2):
        value, error = measure_sky(session, [(0, 0, 1)])
        assert abs(value[0] - expected) < 4 * error[0]
        readings.append(error[0])
        add_portal(size=2 * half)
    assert readings[1] < 0.2 * readings[0]
