"""Fixtures for tests inside Blender's Python module."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass

import numpy as np
import pytest

HAS_BLENDER = importlib.util.find_spec("bpy") is not None

if HAS_BLENDER:
    import bpy
else:
    collect_ignore_glob = ["test_*.py"]

PIXELS = 16


def pytest_report_header():
    """Say why the whole folder is missing from a run."""
    return None if HAS_BLENDER else "bpy is not installed: tests/blender is left out"


@pytest.fixture(scope="session")
def registered():
    """Register the extension's property groups once."""
    from lumenray.blender_addon import registry

    registry.register()


@pytest.fixture(autouse=True)
def _empty_file(registered):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    yield
    bpy.ops.wm.read_factory_settings(use_empty=True)


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


@pytest.fixture
def tree():
    """Return an empty node tree of a new material."""
    material = bpy.data.materials.new("Paint")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    material.node_tree.nodes.clear()
    return Tree(material)


@pytest.fixture
def cycles_colour(tmp_path):
    """Return a function that lets Cycles show a socket over the UV square, bottom row first."""

    def render(tree, socket, size=PIXELS):
        tree.surface(tree.add("Emission", Color=socket, Strength=1.0))
        _stage(tree.material)
        scene = bpy.context.scene
        scene.render.resolution_x = scene.render.resolution_y = size
        path = tmp_path / "cycles.exr"
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(str(path))
        pixels = np.empty(size * size * 4, np.float32)
        image.pixels.foreach_get(pixels)
        return pixels.reshape(size, size, 4)[..., :3]

    return render


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
