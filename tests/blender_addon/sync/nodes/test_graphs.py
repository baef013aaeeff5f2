"""Graphs with groups, muted nodes, reroutes, circles, and what no texture can hold."""

import bpy
import numpy as np
import pytest
from material_trees import PIXELS, add_texture, evaluate, noise_image

from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.nodes import fields
from lumenray.blender_addon.sync.nodes.evaluation import Context, evaluate_field
from lumenray.engine.scene.spectrum import Constant, Rgb

pytestmark = pytest.mark.blender


def make_group(name="Darken"):
    """Make a group that multiplies its colour by its factor."""
    group = bpy.data.node_groups.new(name, "ShaderNodeTree")
    group.interface.new_socket("Colour", in_out="INPUT", socket_type="NodeSocketColor")
    amount = group.interface.new_socket("Amount", in_out="INPUT", socket_type="NodeSocketFloat")
    amount.default_value = 0.5
    group.interface.new_socket("Colour", in_out="OUTPUT", socket_type="NodeSocketColor")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    multiply = group.nodes.new("ShaderNodeMixRGB")
    multiply.blend_type = "MULTIPLY"
    multiply.inputs["Fac"].default_value = 1.0
    group.links.new(start.outputs[0], multiply.inputs["Color1"])
    group.links.new(start.outputs[1], multiply.inputs["Color2"])
    group.links.new(multiply.outputs[0], end.inputs[0])
    return group


def test_group_is_entered_with_its_own_inputs_each_time(tree, agree):
    links = tree.material.node_tree.links
    group = make_group()
    nodes = [tree.add("Group", attributes={"node_tree": group}) for _ in range(2)]
    links.new(add_texture(tree, noise_image(1)).outputs["Color"], nodes[0].inputs[0])
    links.new(nodes[0].outputs[0], nodes[1].inputs[0])
    nodes[1].inputs[1].default_value = 0.25
    ours = agree(tree, nodes[1].outputs[0])
    source = np.array(bpy.data.images["Noise 1"].pixels).reshape(PIXELS, PIXELS, 4)[..., :3]
    assert ours == pytest.approx(source / 8, abs=1e-5)


def test_group_inside_a_group_gets_the_outer_inputs(tree, agree):
    inner, outer = make_group("Inner"), make_group("Outer")
    node = outer.nodes.new("ShaderNodeGroup")
    node.node_tree = inner
    start = next(n for n in outer.nodes if n.bl_idname == "NodeGroupInput")
    multiply = next(n for n in outer.nodes if n.bl_idname == "ShaderNodeMixRGB")
    outer.links.new(start.outputs[0], node.inputs[0])
    outer.links.new(node.outputs[0], multiply.inputs["Color1"])
    shell = tree.add("Group", attributes={"node_tree": outer})
    shell.inputs[0].default_value = (0.8, 0.4, 0.2, 1.0)
    ours = agree(tree, shell.outputs[0])
    assert ours[0, 0] == pytest.approx([0.2, 0.1, 0.05])


def test_colour_into_a_groups_number_is_what_this_blender_makes_of_it(tree, agree):
    node = tree.add("Group", attributes={"node_tree": make_group()})
    node.inputs[0].default_value = (1.0, 1.0, 1.0, 1.0)
    colour = tree.add("RGB")
    colour.outputs[0].default_value = (0.0, 1.0, 0.0, 1.0)
    tree.material.node_tree.links.new(colour.outputs[0], node.inputs[1])
    agree(tree, node.outputs[0])


def test_default_colour_of_a_groups_input_becomes_luminance_in_a_number(tree, agree):
    group = make_group()
    amount = next(i for i in group.interface.items_tree if i.name == "Amount")
    amount.socket_type = "NodeSocketColor"
    math = group.nodes.new("ShaderNodeMath")
    math.operation, math.inputs[1].default_value = "ADD", 0.0
    start = next(n for n in group.nodes if n.bl_idname == "NodeGroupInput")
    multiply = next(n for n in group.nodes if n.bl_idname == "ShaderNodeMixRGB")
    group.links.new(start.outputs[1], math.inputs[0])
    group.links.new(math.outputs[0], multiply.inputs["Color2"])
    node = tree.add("Group", attributes={"node_tree": group})
    node.inputs[0].default_value = (1.0, 1.0, 1.0, 1.0)
    node.inputs[1].default_value = (0.0, 1.0, 0.0, 1.0)
    ours = agree(tree, node.outputs[0])
    assert ours[0, 0] == pytest.approx(0.7152, abs=1e-3)


def test_colour_into_a_number_becomes_luminance(tree, agree):
    colour = tree.add("RGB")
    colour.outputs[0].default_value = (0.0, 1.0, 0.0, 1.0)
    node = tree.add("Math", attributes={"operation": "ADD"}, Value=colour.outputs[0])
    node.inputs[1].default_value = 0.0
    ours = agree(tree, node.outputs[0])
    assert ours[0, 0] == pytest.approx(0.7152, abs=1e-3)


def test_vector_into_a_number_becomes_its_mean(tree, agree):
    vector = tree.add("CombineXYZ", X=0.9, Y=0.3, Z=0.0)
    node = tree.add("Math", attributes={"operation": "ADD"})
    tree.material.node_tree.links.new(vector.outputs[0], node.inputs[0])
    node.inputs[1].default_value = 0.0
    ours = agree(tree, node.outputs[0])
    assert ours[0, 0, 0] == pytest.approx(0.4)


def test_muted_node_passes_its_input_through(tree, agree):
    colour = tree.add("RGB")
    colour.outputs[0].default_value = (0.3, 0.5, 0.7, 1.0)
    node = tree.add("Gamma", Color=colour.outputs[0], Gamma=3.0)
    node.mute = True
    ours = agree(tree, node.outputs[0])
    assert ours[0, 0] == pytest.approx([0.3, 0.5, 0.7])


def test_muted_node_without_input_leaves_the_next_ones_own_value(tree, agree):
    muted = tree.add("Gamma", Color=(0.9, 0.9, 0.9))
    muted.mute = True
    node = tree.add("Gamma", Color=muted.outputs[0], Gamma=1.0)
    node.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    ours = agree(tree, node.outputs[0])
    assert ours[0, 0] == pytest.approx([0.1, 0.2, 0.3])


def test_muted_link_counts_as_unlinked(tree):
    node = tree.add("Gamma", Color=tree.add("RGB").outputs[0])
    node.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    node.inputs["Color"].links[0].is_muted = True
    ours, _ = evaluate(tree, node.outputs[0])
    assert ours[0, 0] == pytest.approx([0.1, 0.2, 0.3])


def test_reroutes_are_followed(tree):
    colour = tree.add("RGB")
    colour.outputs[0].default_value = (0.1, 0.2, 0.3, 1.0)
    output = colour.outputs[0]
    for _ in range(3):
        reroute = tree.add("NodeReroute")
        tree.material.node_tree.links.new(output, reroute.inputs[0])
        output = reroute.outputs[0]
    ours, report = evaluate(tree, output)
    assert ours[0, 0] == pytest.approx([0.1, 0.2, 0.3])
    assert not report.rows


def test_circle_of_links_ends_with_a_row(tree):
    first = tree.add("Gamma")
    second = tree.add("Gamma", Color=first.outputs[0])
    tree.set(first, "Color", second.outputs[0])
    _, report = evaluate(tree, second.outputs[0])
    assert "circle" in report.to_dicts()[0]["message"]


@pytest.mark.parametrize(
    ("kind", "output", "value"),
    [
        ("VertexColor", "Color", 0.5),
        ("LightPath", "Is Camera Ray", 0.0),
        ("NewGeometry", "Pointiness", 0.5),
        ("ObjectInfo", "Color", 1.0),
    ],
)
def test_what_no_texture_can_hold_is_replaced_and_reported(tree, kind, output, value):
    node = tree.add(kind)
    socket = next(s for s in node.outputs if s.identifier == output)
    ours, report = evaluate(tree, socket)
    assert ours == pytest.approx(np.full(ours.shape, value))
    (row,) = report.to_dicts()
    assert row["node"] == node.name
    assert row["object"] == "Paint"
    assert row["instead"]


def ramp_of(tree, factor, *stops):
    """Add a ramp of grey stops (position, value), constant between them."""
    node = tree.add("ValToRGB", Fac=factor)
    ramp = node.color_ramp
    ramp.interpolation = "CONSTANT"
    for number, (position, value) in enumerate(stops):
        stop = ramp.elements[number] if number < 2 else ramp.elements.new(position)
        stop.position, stop.color = position, (value, value, value, 1.0)
    return node.outputs["Color"]


@pytest.mark.parametrize("kind", ["alone", "with a picture", "behind a product"])
def test_a_ramp_behind_a_stand_in_counts_with_the_mean_of_what_it_shows(tree, cycles_colour, kind):
    gradient = tree.add("TexGradient").outputs["Fac"]
    # In the middle of the gradient the ramp is black.
    shown = ramp_of(tree, gradient, (0.0, 0.0), (0.7, 1.0))
    if kind == "with a picture":
        picture = add_texture(tree, noise_image(3)).outputs["Color"]
        node = tree.add("Gamma", Color=picture, Gamma=shown)
        shown = node.outputs[0]
    if kind == "behind a product":
        square = tree.add("VectorMath", attributes={"operation": "MULTIPLY"})
        for place in (0, 1):
            tree.material.node_tree.links.new(gradient, square.inputs[place])
        shown = square.outputs[0]
    ours, report = evaluate(tree, shown)
    theirs = cycles_colour(tree, shown, 64)
    assert ours.mean(axis=(0, 1)) == pytest.approx(theirs.mean(axis=(0, 1)), rel=0.02)
    assert ours.mean() > 0.1
    assert any("procedural" in row.message for row, _ in report.rows)


def test_fresnel_becomes_its_mean_for_diffuse_light(tree):
    ours, report = evaluate(tree, tree.add("Fresnel", IOR=1.5).outputs[0])
    # Diffuse reflectance of n = 1.5: 0.0918 (Walsh; Judd 1942, table I).
    assert ours[0, 0, 0] == pytest.approx(0.0918, abs=2e-4)
    assert len(report.rows) == 1


def test_neutral_constant_is_not_upsampled(tree):
    probe = tree.add("Emission", Color=(0.4, 0.4, 0.4))
    context = Context("Paint", ConversionReport())
    assert fields.as_colour(evaluate_field(probe.inputs["Color"], context)) == Constant(
        pytest.approx(0.4)
    )
    tree.set(probe, "Color", (0.4, 0.3, 0.2))
    colour = fields.as_colour(evaluate_field(probe.inputs["Color"], context))
    assert isinstance(colour, Rgb)
    assert (colour.red, colour.green, colour.blue) == pytest.approx((0.4, 0.3, 0.2))
