"""Worlds with a sky of the CIE, and the lamps that stand for their sun."""

import math

import bpy
import numpy as np
from conversion import converted_scene

from lumenray.engine.accuracy.stopping import StopRule


def new_sky():
    """Return the scene's new world, which has a sky of the CIE."""
    world = bpy.data.worlds.new("Outside")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    bpy.context.scene.world = world
    world.lumenray.source = "CIE"
    return world


def add_sun(name="Sun", rotation=(0.0, 0.0, 0.0), power=1.0):
    """Add a sun light."""
    data = bpy.data.lights.new(name, "SUN")
    data.energy = power
    item = bpy.data.objects.new(name, data)
    item.rotation_euler = rotation
    bpy.context.scene.collection.objects.link(item)
    return item


def compass(elevation, azimuth):
    """Unit vector by angles in degrees: azimuth from north, +y, over east, +x."""
    height, turn = math.radians(elevation), math.radians(azimuth)
    east, north = math.sin(turn), math.cos(turn)
    return np.array([math.cos(height) * east, math.cos(height) * north, math.sin(height)])


def rotation_of(elevation, azimuth):
    """Euler angles [rad] of a lamp that shines from there: tipped about x, then turned about z."""
    return (-math.radians(90 - elevation), 0.0, -math.radians(azimuth))


def measure_sky(session, normals, samples=1 << 13):
    """Measure what comes to sensors at the origin: illuminance and standard error. [lx]"""
    session.apply(converted_scene().delta)
    normals = np.array(normals, dtype=float)
    made = session.measure(np.zeros((len(normals), 3)), normals, StopRule(samples=samples))
    return made.illuminance, made.standard_error


def add_portal(location=(0, 0, 1), size=0.5):
    """An area light that is a portal of Cycles; what a script sets there is no change to Blender."""
    data = bpy.data.lights.new("Portal", "AREA")
    data.energy, data.size = 100.0, size
    data.cycles.is_portal = True
    item = bpy.data.objects.new("Portal", data)
    item.location = location
    bpy.context.scene.collection.objects.link(item)
    return item
