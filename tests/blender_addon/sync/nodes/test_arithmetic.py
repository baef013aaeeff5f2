"""Arithmetic, colours and patterns in graphs: Cycles renders the same on a UV square and both pictures must agree."""

import bpy
import pytest
from material_trees import add_texture, evaluate, noise_image, output_of

pytestmark = pytest.mark.blender

BLENDS = list(bpy.types.ShaderNodeMix.bl_rna.properties["blend_type"].enum_items.keys())

OPERATIONS = list(bpy.types.ShaderNodeMath.bl_rna.properties["operation"].enum_items.keys())


@pytest.mark.parametrize("mode", BLENDS)
def test_colours_blend_as_in_cycles(tree, agree, mode):
    node = tree.add("Mix", attributes={"data_type": "RGBA", "blend_type": mode})
    tree.set(node, "Factor Float", 0.35)
    tree.set(node, "A Color", add_texture(tree, noise_image(1)).outputs["Color"])
    tree.set(node, "B Color", add_texture(tree, noise_image(2)).outputs["Color"])
    agree(tree, output_of(node, "Result_Color"))


def test_blend_by_hand(tree):
    node = tree.add("MixRGB", attributes={"blend_type": "MULTIPLY"}, Fac=0.5)
    tree.set(node, "Color1", (0.8, 0.4, 0.2))
    tree.set(node, "Color2", (0.5, 1.0, 0.0))
    ours, _ = evaluate(tree, node.outputs[0])
    assert ours[0, 0] == pytest.approx([0.6, 0.4, 0.1])


def test_legacy_mix_clamps_its_result_when_asked(tree):
    attributes = {"blend_type": "ADD", "use_clamp": True}
    node = tree.add("MixRGB", attributes=attributes, Fac=1.0)
    tree.set(node, "Color1", (0.8, 0.4, 0.2))
    tree.set(node, "Color2", (0.8, 0.4, 0.2))
    ours, _ = evaluate(tree, node.outputs[0])
    assert ours[0, 0] == pytest.approx([1.0, 0.8, 0.4])


@pytest.mark.parametrize("data_type", ["FLOAT", "VECTOR"])
def test_numbers_and_vectors_mix_as_in_cycles(tree, agree, data_type):
    kind = data_type.capitalize()
    node = tree.add("Mix", attributes={"data_type": data_type, "clamp_factor": False})
    tree.set(node, "Factor Float", 1.5)
    tree.set(node, f"A {kind}", add_texture(tree, noise_image(1)).outputs["Color"])
    tree.set(node, f"B {kind}", 0.5 if kind == "Float" else (0.5, 0.2, 0.1))
    agree(tree, output_of(node, f"Result_{kind}"))


@pytest.mark.parametrize("first", range(0, len(OPERATIONS), 3))
def test_math_calculates_as_in_cycles(tree, agree, first):
    images = [add_texture(tree, noise_image(i, -2.0, 2.0)).outputs["Color"] for i in (1, 2)]
    parts = [tree.add("SeparateXYZ", Vector=image) for image in images]
    joined = tree.add("CombineXYZ")
    for axis, operation in zip("XYZ", OPERATIONS[first : first + 3], strict=False):
        node = tree.add("Math", attributes={"operation": operation})
        for index, output in enumerate([*parts[0].outputs[:2], parts[1].outputs[0]]):
            tree.material.node_tree.links.new(output, node.inputs[index])
        tree.set(joined, axis, node.outputs[0])
    # Cycles clips emission below zero nowhere, but tangents near a pole lose digits.
    agree(tree, joined.outputs[0], tolerance=5e-3)


@pytest.mark.parametrize(
    "operation",
    ["ADD", "SCALE", "DOT_PRODUCT", "DISTANCE", "LENGTH", "NORMALIZE", "FRACTION", "SNAP", "WRAP"],
)
def test_vector_math_calculates_as_in_cycles(tree, agree, operation):
    node = tree.add("VectorMath", attributes={"operation": operation}, Scale=0.7)
    links = tree.material.node_tree.links
    for index in (0, 1):
        links.new(add_texture(tree, noise_image(index)).outputs["Color"], node.inputs[index])
    node.inputs[2].default_value = (0.1, 0.2, 0.3)
    is_number = operation in {"DOT_PRODUCT", "DISTANCE", "LENGTH"}
    agree(tree, node.outputs["Value" if is_number else "Vector"])


@pytest.mark.parametrize("interpolation", ["LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"])
@pytest.mark.parametrize("is_clamped", [False, True])
def test_map_range_as_in_cycles(tree, agree, interpolation, is_clamped):
    node = tree.add(
        "MapRange",
        attributes={"interpolation_type": interpolation, "clamp": is_clamped},
        Value=add_texture(tree, noise_image(1)).outputs["Color"],
        From_Min=0.2,
        From_Max=0.7,
        To_Min=1.5,
        To_Max=0.5,
    )
    agree(tree, node.outputs["Result"])


@pytest.mark.parametrize("kind", ["MINMAX", "RANGE"])
def test_clamp_as_in_cycles(tree, agree, kind):
    value = add_texture(tree, noise_image(1)).outputs["Color"]
    node = tree.add("Clamp", attributes={"clamp_type": kind}, Value=value, Min=0.6, Max=0.4)
    agree(tree, node.outputs[0])


@pytest.mark.parametrize(
    ("kind", "inputs"),
    [
        ("HueSaturation", {"Hue": 0.63, "Saturation": 1.4, "Value": 0.8, "Fac": 0.7}),
        ("Gamma", {"Gamma": 2.2}),
        ("BrightContrast", {"Bright": 0.1, "Contrast": 0.4}),
        ("Invert", {"Fac": 0.6}),
        ("RGBToBW", {}),
    ],
)
def test_colour_adjustment_as_in_cycles(tree, agree, kind, inputs):
    node = tree.add(kind, Color=add_texture(tree, noise_image(1)).outputs["Color"], **inputs)
    agree(tree, node.outputs[0])


@pytest.mark.parametrize("mode", ["RGB", "HSV", "HSL"])
def test_channels_come_apart_and_together_as_in_cycles(tree, agree, mode):
    apart = tree.add("SeparateColor", attributes={"mode": mode})
    tree.set(apart, "Color", add_texture(tree, noise_image(1)).outputs["Color"])
    halved = tree.add("Math", attributes={"operation": "MULTIPLY"})
    tree.material.node_tree.links.new(apart.outputs[0], halved.inputs[0])
    together = tree.add("CombineColor", attributes={"mode": mode}, Red=halved.outputs[0])
    tree.set(together, "Green", apart.outputs[1])
    tree.set(together, "Blue", apart.outputs[2])
    agree(tree, together.outputs[0])


@pytest.mark.parametrize("interpolation", ["LINEAR", "CONSTANT", "EASE", "B_SPLINE", "CARDINAL"])
def test_ramp_as_in_cycles(tree, agree, interpolation):
    ramp = tree.add("ValToRGB", Fac=add_texture(tree, noise_image(1)).outputs["Color"])
    ramp.color_ramp.interpolation = interpolation
    ramp.color_ramp.elements[0].color = (0.9, 0.1, 0.2, 1.0)
    ramp.color_ramp.elements[1].color = (0.0, 0.4, 0.8, 0.5)
    ramp.color_ramp.elements.new(0.4).color = (0.3, 1.0, 0.1, 0.2)
    agree(tree, ramp.outputs["Color"], wrong_share=0.02)


def test_alpha_of_a_ramp_is_its_own_output(tree, agree):
    ramp = tree.add("ValToRGB", Fac=0.25)
    ramp.color_ramp.elements[1].color = (1.0, 1.0, 1.0, 0.0)
    ours = agree(tree, ramp.outputs["Alpha"])
    assert ours[0, 0] == pytest.approx(0.75, abs=1e-3)


def test_rgb_curves_as_in_cycles(tree, agree):
    node = tree.add("RGBCurve", Fac=0.8)
    tree.set(node, "Color", add_texture(tree, noise_image(1, -0.2, 1.3)).outputs["Color"])
    node.mapping.curves[3].points.new(0.4, 0.7)
    node.mapping.curves[0].points.new(0.6, 0.2)
    node.mapping.update()
    agree(tree, node.outputs[0], tolerance=0.01)


def test_float_curve_as_in_cycles(tree, agree):
    node = tree.add("FloatCurve", Value=add_texture(tree, noise_image(1)).outputs["Color"])
    node.mapping.curves[0].points.new(0.4, 0.9)
    node.mapping.update()
    agree(tree, node.outputs[0], tolerance=0.01)


@pytest.mark.parametrize("temperature", [1900.0, 2856.0, 4000.0, 6504.0, 10000.0])
def test_blackbody_has_cycles_colour(tree, agree, temperature):
    # Cycles uses a rational fit with an error of a few per cent in blue.
    agree(tree, tree.add("Blackbody", Temperature=temperature).outputs[0], tolerance=0.02)


def test_wavelength_has_cycles_colour(tree, agree):
    agree(tree, tree.add("Wavelength", Wavelength=600.0).outputs[0], tolerance=0.02)


def test_checker_on_a_uv_map_as_in_cycles(tree, agree):
    moved = tree.add("Mapping", Vector=tree.add("UVMap").outputs[0], Location=(0.03, 0.07, 0))
    node = tree.add("TexChecker", Vector=moved.outputs[0], Scale=5.0)
    tree.set(node, "Color1", (0.9, 0.2, 0.1))
    agree(tree, node.outputs["Color"], wrong_share=0.02)


def test_checker_without_a_uv_map_is_its_mean(tree):
    node = tree.add("TexChecker", Scale=5.0)
    tree.set(node, "Color1", (0.8, 0.6, 0.4))
    tree.set(node, "Color2", (0.2, 0.2, 0.2))
    ours, report = evaluate(tree, node.outputs["Color"])
    assert ours[0, 0] == pytest.approx([0.5, 0.4, 0.3])
    assert len(report.rows) == 1


def test_bricks_on_a_uv_map_as_in_cycles(tree, agree):
    node = tree.add("TexBrick", Vector=tree.add("UVMap").outputs[0], Scale=3.0)
    node.offset_frequency, node.squash, node.squash_frequency = 3, 1.4, 2
    tree.set(node, "Color1", (0.7, 0.2, 0.1))
    tree.set(node, "Color2", (0.4, 0.1, 0.1))
    agree(tree, node.outputs["Color"], rows=1, wrong_share=0.05)
