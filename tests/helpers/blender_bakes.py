"""Bakes in Blender by its operator: lamps for them, and what they leave."""

import time

import bpy


def add_lamp(name, group="", value=1000.0):
    """Add a lamp of a luminous flux [lm] to a group of lights."""
    light = bpy.data.lights.new(name, "POINT")
    light.lumenray.use_physical = True
    light.lumenray.value = value
    light.lumenray.light_group = group
    item = bpy.data.objects.new(name, light)
    item.location.z = 2.0
    bpy.context.scene.collection.objects.link(item)
    return item


def bake_all(folder="", **options):
    """Bake all meshes of the scene."""
    names = ",".join(item.name for item in bpy.context.scene.objects if item.type == "MESH")
    assert bpy.ops.lumenray.bake_illuminance(objects=names, folder=str(folder), **options) == {
        "FINISHED"
    }


def baked():
    """Return the tables of the last bake, as they stand now."""
    bpy.context.view_layer.update()
    return bpy.context.scene.lumenray.baked


def wait_for(running):
    """Wait until a bake in the background has ended."""
    end = time.monotonic() + 120.0
    while running.is_alive:
        assert time.monotonic() < end
        time.sleep(0.01)
