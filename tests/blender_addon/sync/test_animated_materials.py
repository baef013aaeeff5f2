"""Keyframes and drivers of materials, at every frame of a render: only the evaluated material has them there."""

import bpy
import pytest
from rendered_frames import note_frames

from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.scene.scene import Scene

pytestmark = pytest.mark.blender

FRAMES = (1, 21, 10)


@pytest.fixture
def paint():
    mesh = bpy.data.meshes.new("Floor")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    item = bpy.data.objects.new("Floor", mesh)
    bpy.context.scene.collection.objects.link(item)
    material = bpy.data.materials.new("Paint")
    material.use_nodes = True
    mesh.materials.append(material)
    return material


def materials_of_frames(tmp_path):
    """The material at each frame, as a sync that lives through the animation has it."""
    sync, scene = SceneSync(final=True), Scene()

    def note(depsgraph):
        sync.tag_scene()
        sync.tag(depsgraph.updates)
        scene.apply(sync.walk(depsgraph).delta)
        (made,) = scene.materials.values()
        return made

    return note_frames(note, FRAMES, tmp_path)


def test_keyframed_values_of_nodes_are_those_of_the_frame(paint, tmp_path):
    principled = paint.node_tree.nodes["Principled BSDF"].inputs
    principled["Specular IOR Level"].default_value = 0.0
    colour, strength = principled["Base Color"], principled["Emission Strength"]
    principled["Emission Color"].default_value = (1, 1, 1, 1)
    for frame, value in ((1, 0.2), (21, 0.6)):
        colour.default_value = (value, value, value, 1)
        strength.default_value = 10.0 * value
        for socket in (colour, strength):
            socket.keyframe_insert("default_value", frame=frame)
    made = materials_of_frames(tmp_path)
    assert [each.surface.reflectance.value for each in made] == pytest.approx([0.2, 0.4, 0.6])
    light = [each.emission.luminance for each in made]
    assert [one / light[0] for one in light] == pytest.approx([1.0, 2.0, 3.0], rel=1e-4)


def test_values_inside_groups_and_drivers_are_those_of_the_frame(paint, tmp_path):
    inner = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
    inner.interface.new_socket("Colour", in_out="OUTPUT", socket_type="NodeSocketColor")
    value, end = inner.nodes.new("ShaderNodeValue"), inner.nodes.new("NodeGroupOutput")
    inner.links.new(value.outputs[0], end.inputs[0])
    driver = value.outputs[0].driver_add("default_value").driver
    driver.expression = "frame / 100"
    tree = paint.node_tree
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = inner
    principled = tree.nodes["Principled BSDF"]
    principled.inputs["Specular IOR Level"].default_value = 0.0
    tree.links.new(group.outputs[0], principled.inputs["Base Color"])
    made = materials_of_frames(tmp_path)
    assert [each.surface.reflectance.value for each in made] == pytest.approx([0.01, 0.11, 0.21])


def test_stated_values_are_those_of_the_frame(paint, tmp_path):
    settings = paint.lumenray
    settings.use_override = True
    for frame, value in ((1, 0.3), (21, 0.7)):
        settings.reflectance = value
        settings.keyframe_insert("reflectance", frame=frame)
    made = materials_of_frames(tmp_path)
    assert [each.surface.reflectance.value for each in made] == pytest.approx([0.3, 0.5, 0.7])
