"""Lights and empties that shine by photometric files."""

import bpy
import numpy as np

from lumenray.blender_addon.luminaires import places as luminaire_places
from lumenray.blender_addon.luminaires.files import photometric_files
from lumenray.blender_addon.luminaires.settings import settings_of
from lumenray.engine.luminaires.distribution import flux, intensity


def add_luminaire(kind="POINT", path="", name="Lamp"):
    """Return an object: a light of a kind, or an empty."""
    data = None if kind == "EMPTY" else bpy.data.lights.new(name, kind)
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    if path:
        photometric_files.load(settings_of(made), path)
    return made


def candelas(light, direction):
    """Intensity towards directions of the world."""
    share = light.output.value / flux(light.distribution)
    return share * intensity(light.distribution, np.asarray(direction) @ light.frame[:3, :3])


def activate(thing):
    """Make an object the active one."""
    bpy.context.view_layer.objects.active = thing


def body_of(empty):
    """Return the mesh that stands for a luminaire's body."""
    return empty.instance_collection.objects[0].data


def extent_of(empty):
    """Return the least and the largest x of a luminaire's body."""
    x = [(empty.matrix_world @ vertex.co).x for vertex in body_of(empty).vertices]
    return min(x), max(x)


def farthest(solid):
    """Return the vertex of a polar solid that lies farthest out."""
    return solid.vertices[np.argmax(np.linalg.norm(solid.vertices, axis=1))]


def shown_places(scale=1.0):
    """Return the places of the polar solids that the view shows."""
    bpy.context.view_layer.update()
    return luminaire_places.collect(bpy.context.view_layer, None, scale)
