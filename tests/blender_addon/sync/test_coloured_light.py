"""Coloured light on coloured paint is told, and only that."""

import bpy
import pytest
from conversion import converted_scene

pytestmark = pytest.mark.blender

TOLD = "coloured light of"


@pytest.fixture
def paint():
    """Diffuse colour of a plane under a lamp."""
    bpy.ops.mesh.primitive_plane_add()
    material = bpy.data.materials.new("Paint")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    bpy.context.object.data.materials.append(material)
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs[0])
    return shader.inputs["Color"]


@pytest.fixture
def lamp():
    data = bpy.data.lights.new("Warm", "POINT")
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Warm", data))
    return data


def told():
    return [row.text() for row, _ in converted_scene().report.rows if TOLD in row.message]


RED, GREY, WARM = (0.7, 0.3, 0.2, 1.0), (0.5, 0.5, 0.5, 1.0), (1.0, 0.53, 0.2)


def test_only_light_and_paint_of_a_colour_are_told(paint, lamp):
    for colour, light, count in (
        (RED, (1.0, 1.0, 1.0), 0),
        (GREY, WARM, 0),
        (RED, WARM, 1),
        ((0.5, 0.5, 0.49, 1.0), WARM, 0),
    ):
        paint.default_value, lamp.color = colour, light
        assert len(told()) == count
    paint.default_value = RED
    (text,) = told()
    assert text.startswith("info: ")
    assert "'Warm' falls on coloured 'Paint'" in text
    assert "4.8 % darker" in text


def test_less_counts_where_all_light_has_the_colour(paint, lamp):
    """A pair of 1.3 % is told alone, and not beside a white lamp."""
    paint.default_value, lamp.color = (0.6, 0.4, 0.3, 1.0), (1.0, 0.7, 0.5)
    (text,) = told()
    assert "1.3 % darker" in text
    white = bpy.data.lights.new("White", "POINT")
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("White", white))
    assert told() == []
    lamp.color = WARM
    paint.default_value = RED
    assert len(told()) == 1


def test_lights_that_give_none_or_state_a_spectrum_are_passed_over(paint, lamp):
    paint.default_value, lamp.color = RED, WARM
    lamp.energy = 0.0
    assert told() == []
    lamp.energy = 10.0
    settings = lamp.lumenray
    settings.use_physical, settings.spectrum = True, "BLACKBODY"
    assert told() == []


def test_even_worlds_and_glowing_surfaces_count_too(paint):
    world = bpy.data.worlds.new("Sky")
    bpy.context.scene.world = world
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    node = next(n for n in world.node_tree.nodes if n.bl_idname == "ShaderNodeBackground")
    node.inputs["Color"].default_value = (0.2, 0.4, 1.0, 1.0)
    paint.default_value = RED
    assert "the world" in told()[0]
