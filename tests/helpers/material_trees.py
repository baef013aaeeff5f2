"""Node trees of materials, and what Cycles shows of them."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from blender_objects import pixels_of

from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.nodes import fields
from lumenray.blender_addon.sync.nodes.evaluation import Context, evaluate_field

PIXELS = 16
"""Side of what Cycles renders, and of pictures in trees. [pixel]"""

EFFICACY = 177.83
"""Of Blender's white light. [lm/W]"""


@dataclass
class Tree:
    """A material's node tree under construction."""

    material: bpy.types.Material

    @property
    def nodes(self):
        return self.material.node_tree.nodes

    def add(self, kind, outputs=0, /, tree=None, attributes=None, **values):
        """Add a node; `values` are set, or linked if they are sockets, by input identifier."""
        tree = tree or self.material.node_tree
        node = tree.nodes.new(f"ShaderNode{kind}" if not kind.startswith("Node") else kind)
        for name, value in (attributes or {}).items():
            setattr(node, name, value)
        for name, value in values.items():
            self.set(node, name.replace("_", " "), value)
        return node

    def set(self, node, name, value):
        """Set or link an input by its identifier."""
        socket = next(s for s in node.inputs if s.identifier.replace("_", " ") == name)
        if isinstance(value, bpy.types.NodeSocket):
            socket.id_data.links.new(value, socket)
        elif socket.type == "RGBA" and len(value) == 3:
            socket.default_value = (*value, 1.0)
        else:
            socket.default_value = value

    def surface(self, shader):
        """Link a shader node to the material's output."""
        output = self.material.node_tree.get_output_node("CYCLES") or self.add("OutputMaterial")
        self.material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
        return self.material


def new_tree():
    """Return an empty node tree of a new material."""
    material = bpy.data.materials.new("Paint")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    material.node_tree.nodes.clear()
    return Tree(material)


def render_colour(tree, socket, path, size=PIXELS):
    """Let Cycles show a socket over the UV square and return the colours, bottom row first."""
    tree.surface(tree.add("Emission", Color=socket, Strength=1.0))
    _stage(tree.material)
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    return pixels_of(image)[..., :3]


def _stage(material):
    """Put a unit square with the material in front of an orthographic camera."""
    mesh = bpy.data.meshes.new("Square")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    uv = mesh.uv_layers.new(name="UVMap")
    uv.data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    mesh.materials.append(material)
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", 1.0
    eye = bpy.data.objects.new("Camera", camera)
    eye.location = (0.5, 0.5, 1.0)
    scene = bpy.context.scene
    for thing in (bpy.data.objects.new("Square", mesh), eye):
        scene.collection.objects.link(thing)
    scene.camera = eye
    scene.render.engine = "CYCLES"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    scene.cycles.samples = 1
    scene.cycles.use_denoising = False
    scene.cycles.filter_width = 0.01
    scene.cycles.use_adaptive_sampling = False


def add_image(name, pixels, space="Non-Color", is_float=True):
    """Make a Blender image of (height, width, 1, 3 or 4) values, bottom row first."""
    pixels = np.asarray(pixels, np.float32)
    height, width, channels = pixels.shape
    image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=is_float)
    image.colorspace_settings.name = space
    full = np.ones((height, width, 4), np.float32)
    full[..., : max(channels, 3)] = pixels
    image.pixels.foreach_set(full.ravel())
    image.pack()
    return image


def output_of(node, identifier):
    """Return an output socket by its identifier."""
    return next(socket for socket in node.outputs if socket.identifier == identifier)


def noise_image(seed, low=0.0, high=1.0, shape=(PIXELS, PIXELS, 3)):
    """Make an image of random values."""
    values = np.random.default_rng(seed).uniform(low, high, shape)
    return add_image(f"Noise {seed}", values)


def add_texture(tree, image, interpolation="Closest", **inputs):
    """Add a node that shows an image."""
    attributes = {"image": image, "interpolation": interpolation}
    return tree.add("TexImage", attributes=attributes, **inputs)


def evaluate(tree, output, size=PIXELS):
    """Evaluate an output socket with our code; return pixels over the UV square and the report."""
    probe = tree.add("Emission", Color=output)
    report = ConversionReport()
    field = evaluate_field(probe.inputs["Color"], Context("Paint", report)).settled()
    tree.nodes.remove(probe)
    if field.is_constant:
        return np.broadcast_to(field.values, (size, size, 3)), report
    places = (np.arange(size) + 0.5) / size
    u, v = np.meshgrid(places, places)
    at = np.stack([u, v, np.ones_like(u)], -1) @ field.layout.transform.T
    values = fields.look_up(field, at[..., 0], at[..., 1])
    return np.broadcast_to(values, (size, size, 3)), report
