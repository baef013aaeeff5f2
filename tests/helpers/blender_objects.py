"""Objects, lights, materials, worlds and pictures of Blender."""

import bpy
import numpy as np
import pytest

needs_cycles = pytest.mark.skipif(
    not hasattr(bpy.types.Scene, "cycles"), reason="this Blender has no Cycles"
)


def add_quad(name, x=0.0, material=None, mesh=None):
    """Add a unit square that faces up, with its lower left corner at x."""
    if mesh is None:
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
        if material is not None:
            mesh.materials.append(material)
    item = bpy.data.objects.new(name, mesh)
    item.location.x = x
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.update()
    return item


def new_material(name, *shaders):
    """Return a material of one shader, or of two mixed half and half."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    made = [tree.nodes.new(kind) for kind in shaders]
    if len(made) == 2:
        mix = tree.nodes.new("ShaderNodeMixShader")
        for socket, shader in zip(mix.inputs[1:], made, strict=True):
            tree.links.new(shader.outputs[0], socket)
        made = [mix]
    tree.links.new(made[0].outputs[0], output.inputs["Surface"])
    return material


def pixels_of(image):
    """Return the pixels of an image, bottom row first. (h, w, 4)"""
    width, height = image.size
    values = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(height, width, 4)


def new_paint():
    """Return a matt material whose channels all differ."""
    material = new_material("Paint", "ShaderNodeBsdfDiffuse")
    material.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0.6, 0.3, 0.1, 1.0)
    return material


def add_light(kind="POINT", location=(0, 0, 1), name="Light", **settings):
    """Add one of Blender's own lights; its properties are set as told."""
    data = bpy.data.lights.new(name, kind)
    for key, value in settings.items():
        setattr(data, key, value)
    item = bpy.data.objects.new(name, data)
    item.location = location
    bpy.context.scene.collection.objects.link(item)
    return item


def add_cube(location=(0, 0, 0), scale=(1, 1, 1)):
    """Add a cube of two units."""
    mesh = bpy.data.meshes.new("Cube")
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh.from_pydata(corners, [], faces)
    item = bpy.data.objects.new("Cube", mesh)
    item.location, item.scale = location, scale
    bpy.context.scene.collection.objects.link(item)
    return item


def new_world(colour, strength=1.0, name="World"):
    """Give the scene a world of one colour; returns it with its background node."""
    world = bpy.data.worlds.new(name)
    bpy.context.scene.world = world
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    node = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    node.inputs["Color"].default_value = (*colour, 1.0)
    node.inputs["Strength"].default_value = strength
    return world, node


def add_camera(location, rotation, **settings):
    """Add the scene's camera; its properties are set as told."""
    data = bpy.data.cameras.new("Camera")
    for key, value in settings.items():
        setattr(data, key, value)
    item = bpy.data.objects.new("Camera", data)
    item.location, item.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(item)
    bpy.context.scene.camera = item
    return item
