"""The bundled office with other paints: pictures by UV maps, or graphs of procedural textures in coordinates of objects."""

import bpy
import numpy as np

from ...libraries import scenes
from ..common.both_renders import OURS

COUNT = 39
"""Materials that are painted anew: all that are not seen through."""

PICTURE = 512
"""Sides of the pictures. [pixel]"""

KEPT = ("Glass", "Window Pane", "Facade Glass", "Opal Diffuser")
"""Materials that stay as they are: they are seen through."""

KNOB = "Knob"
"""Name of the node whose value is edited, in every material."""


def dress(kind: str) -> list:
    """Open the office and paint it; returns the materials. ``kind``: ``pictures`` or ``graphs``."""
    bpy.ops.wm.open_mainfile(filepath=str(scenes.scene_path("office")), load_ui=False)
    bpy.context.scene.render.engine = OURS
    slots = (
        slot.material
        for item in bpy.data.objects
        if item.type == "MESH"
        for slot in item.material_slots
    )
    painted = {each.name: each for each in slots if each is not None and each.name not in KEPT}
    chosen = [painted[name] for name in sorted(painted)][:COUNT]
    for number, material in enumerate(chosen):
        material.lumenray.use_override = False
        if bpy.app.version < (5, 0, 0):
            material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        colour = (_picture if kind == "pictures" else _graph)(tree, number)
        # The same last step for both, whose value is edited.
        knob = tree.nodes.new("ShaderNodeHueSaturation")
        knob.name = KNOB
        tree.links.new(colour, knob.inputs["Color"])
        surface = tree.nodes.new("ShaderNodeBsdfPrincipled")
        surface.inputs["Roughness"].default_value = 0.5
        tree.links.new(knob.outputs[0], surface.inputs["Base Color"])
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(surface.outputs[0], output.inputs["Surface"])
    bpy.context.view_layer.update()
    return chosen


def turn(material, step: int) -> None:
    """Edit the value of a node."""
    knob = material.node_tree.nodes[KNOB]
    knob.inputs["Value"].default_value = 0.8 + 0.02 * step
    bpy.context.view_layer.update()


def _picture(tree, number: int):
    """Add a picture of soft noise and return its colour."""
    random = np.random.default_rng(number)
    pixels = np.ones((PICTURE, PICTURE, 4), np.float32)
    coarse = 0.2 + 0.5 * random.random((PICTURE // 16, PICTURE // 16, 3))
    pixels[..., :3] = coarse.repeat(16, axis=0).repeat(16, axis=1)
    image = bpy.data.images.new(f"Paint {number}", PICTURE, PICTURE)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    return node.outputs["Color"]


def _graph(tree, number: int):
    """Add noise and a second texture, each through a ramp, mixed; return the colour."""
    place = tree.nodes.new("ShaderNodeTexCoord").outputs["Object"]
    ramps = []
    for kind in ("Noise", ("Voronoi", "Wave", "Magic", "Checker")[number % 4]):
        texture = tree.nodes.new(f"ShaderNodeTex{kind}")
        texture.inputs["Scale"].default_value = 3.0 + number % 7
        tree.links.new(place, texture.inputs["Vector"])
        ramp = tree.nodes.new("ShaderNodeValToRGB")
        ramp.color_ramp.elements[0].color = (0.2, 0.25, 0.3, 1.0)
        ramp.color_ramp.elements[1].color = (0.7, 0.6 - 0.01 * number, 0.5, 1.0)
        tree.links.new(texture.outputs[0], ramp.inputs["Fac"])
        ramps.append(ramp.outputs["Color"])
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    first, second = (each for each in mix.inputs if each.name in "AB" and each.type == "RGBA")
    tree.links.new(ramps[0], first)
    tree.links.new(ramps[1], second)
    return next(each for each in mix.outputs if each.type == "RGBA")
