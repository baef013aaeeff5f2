"""Blender's worlds that show an equirectangular picture."""

import bpy
import numpy as np


def image_of(pixels, name="Sky"):
    """Return an image with float pixels (height, width, 3)."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(name, width, height, float_buffer=True)
    full = np.ones((height, width, 4), np.float32)
    full[..., :3] = pixels
    image.pixels.foreach_set(full.ravel())
    image.update()
    return image


def show(image, turn=(0.0, 0.0, 0.0)):
    """Make a world that shows an image; returns it with the texture's node."""
    world = bpy.context.scene.world = bpy.data.worlds.new("Outside")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    tree = world.node_tree
    background = next(n for n in tree.nodes if n.type == "BACKGROUND")
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    place = tree.nodes.new("ShaderNodeMapping")
    place.inputs["Rotation"].default_value = turn
    where = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(where.outputs["Generated"], place.inputs["Vector"])
    tree.links.new(place.outputs["Vector"], node.inputs["Vector"])
    tree.links.new(node.outputs["Color"], background.inputs["Color"])
    return world, node
