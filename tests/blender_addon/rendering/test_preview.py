"""Previews of materials, worlds and lights: what they show, that they end at once, and that nothing else learns of them."""

import time
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from lumenray.blender_addon.foundation import engine_process, identity
from lumenray.blender_addon.rendering import preview
from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.errors import Cancelled

pytestmark = pytest.mark.usefixtures("extension")


@pytest.fixture(autouse=True)
def shown_as_it_is():
    """Let previews show linear values in sRGB."""
    scene = bpy.context.scene
    scene.render.engine = "LUMENRAY"
    scene.view_settings.view_transform = "Standard"
    yield
    preview.close()


def taken(block):
    """Linear colour and alpha of a data-block's preview, row 0 at the bottom. (h, w, 4)"""
    block.asset_generate_preview()
    width, height = block.preview.image_size
    pixels = np.empty(4 * width * height, np.float32)
    block.preview.image_pixels_float.foreach_get(pixels)
    pixels = pixels.reshape(height, width, 4)
    encoded = pixels[..., :3]
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return np.concatenate([linear, pixels[..., 3:]], axis=-1)


def middle(pixels, part=8):
    """Mean of the middle. (4,)"""
    height, width = pixels.shape[:2]
    y, x = height // 2, width // 2
    return pixels[y - part : y + part, x - part : x + part].mean(axis=(0, 1))


def glowing(colour):
    """Return a material that glows evenly, and the socket of its colour."""
    material = bpy.data.materials.new("Glow")
    material.use_nodes = True
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeEmission")
    node.inputs["Color"].default_value = (*colour, 1.0)
    tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return material, node.inputs["Color"]


def test_a_material_is_shown_as_blender_means_it_and_follows_edits():
    material, socket = glowing((0.5, 0.25, 0.1))
    pixels = taken(material)
    np.testing.assert_allclose(middle(pixels), (0.5, 0.25, 0.1, 1.0), atol=0.01)
    assert pixels[2, 2, 3] == 0.0
    socket.default_value = (0.1, 0.3, 0.7, 1.0)
    np.testing.assert_allclose(middle(taken(material)), (0.1, 0.3, 0.7, 1.0), atol=0.01)


@pytest.mark.slow
def test_worlds_in_their_units_and_lights_in_lumens():
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.2, 0.4, 0.6, 1.0)
    np.testing.assert_allclose(middle(taken(world))[:3], (0.2, 0.4, 0.6), atol=0.01)
    # A sky of 10000 lx would be white everywhere at the exposure of Blender's units.
    world.lumenray.source = "CIE"
    world.lumenray.sky.illuminance = 1e4
    assert 0.05 < middle(taken(world))[1] < 0.95
    lamp = bpy.data.lights.new("Lamp", "POINT")
    lamp.lumenray.use_physical = True
    lamp.lumenray.quantity = "LUMINOUS_FLUX"
    shown = []
    for lumens in (500.0, 5e5):
        lamp.lumenray.value = lumens
        shown.append(middle(taken(lamp))[1])
    # Its exposure follows the light, so that what it gives is seen at any amount.
    assert 0.02 < shown[0] < 0.98
    assert shown[1] == pytest.approx(shown[0], rel=0.1)


def test_nothing_of_the_file_learns_of_previews():
    material, socket = glowing((0.5, 0.5, 0.5))
    mesh = bpy.data.meshes.new("Face")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Face", mesh))
    identity.ensure_ids()
    sync = SceneSync()
    graph = bpy.context.evaluated_depsgraph_get()
    assert sync.walk(graph).delta
    known, uid = dict(identity._memory.uids), material.lumenray.uid
    for level in (0.2, 0.4):
        socket.default_value = (level, level, level, 1.0)
        graph.update()
        taken(material)
        # The edit itself, and no copy of the material beside it.
        delta = sync.walk(graph).delta
        assert [item.id for item in delta.changed] == [f"material:{uid}"]
        assert not delta.copies
        assert not delta.removed
    assert identity._memory.uids == known
    assert material.lumenray.uid == uid


class Abandoned:
    """A render engine whose preview Blender no longer wants."""

    is_preview = True

    def __init__(self, after):
        self.end, self.ends = time.monotonic() + after, []

    def test_break(self):
        return time.monotonic() > self.end

    def begin_result(self, *_):
        rect = SimpleNamespace(foreach_set=lambda _: None)
        combined = {"Combined": SimpleNamespace(rect=rect)}
        return SimpleNamespace(layers=[SimpleNamespace(passes=combined)])

    def end_result(self, _, cancel=False):
        self.ends.append(cancel)

    def update_result(self, _):
        pass

    def update_progress(self, _):
        pass


def test_an_unwanted_preview_ends_at_once_and_leaves_the_engine_as_it_is(monkeypatch):
    for name in ("SAMPLES", "UNFILTERED_SAMPLES"):
        monkeypatch.setattr(preview, name, 1 << 20)
    bpy.ops.mesh.primitive_plane_add()
    bpy.ops.object.light_add(type="POINT", location=(0, 0, 2))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location.z = 5.0
    scene = bpy.context.scene
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = 64
    graph = bpy.context.evaluated_depsgraph_get()
    engine = Abandoned(1.0)
    with pytest.raises(Cancelled):
        preview.render_preview(engine, graph)
    assert time.monotonic() - engine.end < 1.0
    assert engine.ends == [True]
    assert engine_process.is_running()
    # The next one does not wait for what is left of it.
    for name in ("SAMPLES", "UNFILTERED_SAMPLES"):
        monkeypatch.setattr(preview, name, 4)
    engine = Abandoned(1000.0)
    preview.render_preview(engine, graph)
    assert engine.ends == [False]


def test_a_scene_without_a_camera_gives_no_preview():
    engine = Abandoned(1000.0)
    preview.render_preview(engine, bpy.context.evaluated_depsgraph_get())
    assert engine.ends == []
