"""Colour graphs: Cycles renders the same graph on a UV square and both pictures must agree."""

import bpy
import numpy as np
import pytest
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.nodes import fields
from lumenray.blender_addon.sync.nodes.evaluation import (
    Context,
    evaluate_colour,
    evaluate_field,
    evaluate_scalar,
)
from lumenray.engine.scene.spectrum import Constant, Rgb
from lumenray.engine.scene.texture import ImageTexture

pytestmark = pytest.mark.blender

SIZE = 16


def add_image(name, pixels, space="Non-Color", is_float=True):
    """Make a Blender image of (height, width, 3 or 4) values, bottom row first."""
    pixels = np.asarray(pixels, np.float32)
    height, width, channels = pixels.shape
    image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=is_float)
    image.colorspace_settings.name = space
    full = np.ones((height, width, 4), np.float32)
    full[..., :channels] = pixels
    image.pixels.foreach_set(full.ravel())
    image.pack()
    return image


def output(node, identifier):
    return next(socket for socket in node.outputs if socket.identifier == identifier)


def noise_image(seed, low=0.0, high=1.0, shape=(SIZE, SIZE, 3)):
    values = np.random.default_rng(seed).uniform(low, high, shape)
    return add_image(f"Noise {seed}", values)


def add_texture(tree, image, interpolation="Closest", **inputs):
    attributes = {"image": image, "interpolation": interpolation}
    return tree.add("TexImage", attributes=attributes, **inputs)


def evaluate(tree, output, size=SIZE):
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


@pytest.fixture
def agree(cycles_colour):
    """Return a function that compares our evaluation of a socket with Cycles'."""

    def compare(tree, output, tolerance=2e-3, rows=0, wrong_share=0.0):
        ours, report = evaluate(tree, output)
        theirs = cycles_colour(tree, output)
        is_wrong = np.abs(ours - theirs).max(-1) > tolerance * np.maximum(1, abs(theirs).max(-1))
        assert is_wrong.mean() <= wrong_share, (
            f"{is_wrong.sum()} pixels differ, first ours {ours[is_wrong][0]}, "
            f"Cycles {theirs[is_wrong][0]}"
        )
        assert len(report.rows) == rows, report.to_dicts()
        return ours

    return compare


# ------------------------------------------------------------------ images


def test_byte_image_in_srgb_is_linearised(tree):
    image = add_image("Grey", np.full((2, 2, 3), 128 / 255), "sRGB", is_float=False)
    ours, _ = evaluate(tree, add_texture(tree, image).outputs["Color"])
    assert ours[0, 0] == pytest.approx(0.2158605, abs=1e-5)


def test_byte_image_of_data_is_not_linearised(tree):
    image = add_image("Grey", np.full((2, 2, 3), 128 / 255), "Non-Color", is_float=False)
    ours, _ = evaluate(tree, add_texture(tree, image).outputs["Color"])
    assert ours[0, 0] == pytest.approx(128 / 255, abs=1e-5)


def test_first_row_of_a_picture_is_the_bottom(tree):
    pixels = np.zeros((2, 2, 3))
    pixels[0] = 1.0
    probe = tree.add(
        "Emission", Color=add_texture(tree, add_image("Half", pixels)).outputs["Color"]
    )
    texture = evaluate_colour(probe.inputs["Color"], Context("Paint", ConversionReport()))
    assert isinstance(texture, ImageTexture)
    assert texture.pixels[0].min() == 1.0
    assert texture.pixels[1].max() == 0.0
    assert texture.interpolation == "closest"
    assert texture.name == "Half"


@pytest.mark.parametrize("is_alpha_used", [False, True])
@pytest.mark.parametrize("space", ["sRGB", "Non-Color"])
def test_transparent_pixels_look_as_in_cycles(tree, agree, is_alpha_used, space):
    pixels = np.random.default_rng(4).uniform(0.1, 0.9, (SIZE, SIZE, 4))
    pixels[..., 3] = np.round(pixels[..., 3])
    texture = add_texture(tree, add_image("Leaf", pixels, space, is_float=False))
    output = texture.outputs["Color"]
    if is_alpha_used:
        output = tree.add(
            "MixRGB",
            attributes={"blend_type": "MIX"},
            Fac=0.25,
            Color1=output,
            Color2=texture.outputs["Alpha"],
        ).outputs[0]
    agree(tree, output, tolerance=5e-3)


def test_alpha_of_a_picture_is_a_scalar(tree):
    pixels = np.ones((2, 2, 4))
    pixels[0, 0, 3] = 0.25
    probe = tree.add("Math")
    tree.set(probe, "Value", add_texture(tree, add_image("Leaf", pixels)).outputs["Alpha"])
    texture = evaluate_scalar(probe.inputs[0], Context("Paint", ConversionReport()))
    assert texture.pixels.shape == (2, 2, 1)
    assert texture.pixels[0, 0, 0] == 0.25


def test_missing_image_is_grey_and_reported_with_its_path(tree):
    image = bpy.data.images.new("Lost", 4, 4)
    image.source, image.filepath = "FILE", "//nowhere.png"
    ours, report = evaluate(tree, add_texture(tree, image).outputs["Color"])
    assert np.all(ours == 0.5)
    (row,) = report.to_dicts()
    assert row["severity"] == "error"
    assert "nowhere.png" in row["message"]
    assert "0.5" in row["instead"]


def test_other_colour_space_is_reported(tree):
    image = add_image("Wide", np.full((2, 2, 3), 0.5), "Filmic sRGB", is_float=False)
    _, report = evaluate(tree, add_texture(tree, image).outputs["Color"])
    assert "Filmic sRGB" in report.to_dicts()[0]["message"]


# ------------------------------------------------------------- coordinates


@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "CLIP", "MIRROR"])
@pytest.mark.parametrize("interpolation", ["Closest", "Linear"])
def test_places_outside_the_picture_look_as_in_cycles(tree, agree, extension, interpolation):
    moved = tree.add("Mapping", Vector=tree.add("UVMap").outputs[0], Scale=(3, 3, 1))
    tree.set(moved, "Location", (-1.01, -1.02, 0))
    image = noise_image(1, shape=(3, 5, 3))
    texture = add_texture(tree, image, interpolation, Vector=moved.outputs[0])
    texture.extension = extension
    agree(tree, texture.outputs["Color"], wrong_share=0.02, tolerance=0.02)


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR"])
def test_mapping_moves_turns_and_scales_as_in_cycles(tree, agree, kind):
    coordinates = tree.add("TexCoord").outputs["UV"]
    moved = tree.add("Mapping", attributes={"vector_type": kind}, Vector=coordinates)
    tree.set(moved, "Location", (0.13, -0.31, 0.2))
    tree.set(moved, "Rotation", (0.4, -0.3, 0.7))
    tree.set(moved, "Scale", (1.7, 0.6, 1.2))
    texture = add_texture(tree, noise_image(2, shape=(4, 4, 3)), Vector=moved.outputs[0])
    agree(tree, texture.outputs["Color"], wrong_share=0.02)


def test_two_mappings_in_a_row_add_up(tree, agree):
    first = tree.add("Mapping", Vector=tree.add("UVMap").outputs[0], Scale=(2, 1, 1))
    second = tree.add("Mapping", Vector=first.outputs[0], Location=(0.25, 0.1, 0))
    shift = tree.add("VectorMath", attributes={"operation": "SUBTRACT"}, Vector=second.outputs[0])
    shift.inputs[1].default_value = (0.5, 0.0, 0.0)
    texture = add_texture(tree, noise_image(3, shape=(4, 4, 3)), Vector=shift.outputs[0])
    agree(tree, texture.outputs["Color"], wrong_share=0.02)


def test_mapping_without_coordinates_shows_one_place(tree, agree):
    moved = tree.add("Mapping", Location=(0.6, 0.3, 0))
    texture = add_texture(tree, noise_image(3, shape=(4, 4, 3)), Vector=moved.outputs[0])
    ours = agree(tree, texture.outputs["Color"])
    assert np.ptp(ours[..., 0]) == 0


def test_uv_map_is_taken_by_its_name(tree):
    coordinates = tree.add("UVMap", attributes={"uv_map": "Detail"})
    texture = add_texture(tree, noise_image(1), Vector=coordinates.outputs[0])
    probe = tree.add("Emission", Color=texture.outputs["Color"])
    colour = evaluate_colour(probe.inputs["Color"], Context("Paint", ConversionReport()))
    assert colour.uv_map == "Detail"


def test_generated_coordinates_give_the_mean_and_a_row(tree):
    image = noise_image(1)
    texture = add_texture(tree, image, Vector=tree.add("TexCoord").outputs["Generated"])
    ours, report = evaluate(tree, texture.outputs["Color"])
    expected = np.array(image.pixels).reshape(-1, 4)[:, :3].mean(0)
    assert ours[3, 3] == pytest.approx(expected, abs=1e-5)
    assert report.to_dicts()[0]["instead"] == "the picture's mean is used"


# ------------------------------------------------- several pictures in one


def test_pictures_of_different_size_are_combined_on_the_finer_grid(tree, agree):
    coarse = add_texture(tree, noise_image(1, shape=(4, 8, 3))).outputs["Color"]
    fine = add_texture(tree, noise_image(2)).outputs["Color"]
    mixed = tree.add("MixRGB", attributes={"blend_type": "MULTIPLY"}, Fac=1.0, Color1=coarse)
    tree.set(mixed, "Color2", fine)
    agree(tree, mixed.outputs[0])


def test_whole_repeats_of_a_detail_picture_are_exact(tree, agree):
    moved = tree.add("Mapping", Vector=tree.add("UVMap").outputs[0], Scale=(4, 2, 1))
    detail = add_texture(tree, noise_image(1, shape=(2, 4, 3)), Vector=moved.outputs[0])
    base = add_texture(tree, noise_image(2)).outputs["Color"]
    mixed = tree.add("MixRGB", attributes={"blend_type": "MULTIPLY"}, Fac=1.0, Color1=base)
    tree.set(mixed, "Color2", detail.outputs["Color"])
    agree(tree, mixed.outputs[0])


def test_repeats_that_do_not_fit_are_reported(tree):
    moved = tree.add("Mapping", Vector=tree.add("UVMap").outputs[0], Scale=(1.5, 1, 1))
    detail = add_texture(tree, noise_image(1), Vector=moved.outputs[0])
    base = add_texture(tree, noise_image(2)).outputs["Color"]
    mixed = tree.add("MixRGB", Fac=0.5, Color1=base, Color2=detail.outputs["Color"])
    _, report = evaluate(tree, mixed.outputs[0])
    assert "resampled" in report.to_dicts()[0]["instead"]


def test_second_uv_map_becomes_its_mean_and_is_reported(tree):
    other = tree.add("UVMap", attributes={"uv_map": "Other"})
    first = add_texture(tree, noise_image(1)).outputs["Color"]
    image = noise_image(2)
    second = add_texture(tree, image, Vector=other.outputs[0]).outputs["Color"]
    mixed = tree.add("MixRGB", attributes={"blend_type": "ADD"}, Fac=1.0, Color1=first)
    tree.set(mixed, "Color2", second)
    ours, report = evaluate(tree, mixed.outputs[0])
    means = [np.array(bpy.data.images[f"Noise {i}"].pixels).reshape(-1, 4)[:, :3] for i in (1, 2)]
    assert ours.mean((0, 1)) == pytest.approx(means[0].mean(0) + means[1].mean(0), abs=1e-4)
    assert "UV maps" in report.to_dicts()[0]["message"]


# ------------------------------------------------------------- arithmetic

BLENDS = list(bpy.types.ShaderNodeMix.bl_rna.properties["blend_type"].enum_items.keys())
OPERATIONS = list(bpy.types.ShaderNodeMath.bl_rna.properties["operation"].enum_items.keys())


@pytest.mark.parametrize("mode", BLENDS)
def test_colours_blend_as_in_cycles(tree, agree, mode):
    node = tree.add("Mix", attributes={"data_type": "RGBA", "blend_type": mode})
    tree.set(node, "Factor Float", 0.35)
    tree.set(node, "A Color", add_texture(tree, noise_image(1)).outputs["Color"])
    tree.set(node, "B Color", add_texture(tree, noise_image(2)).outputs["Color"])
    agree(tree, output(node, "Result_Color"))


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
    agree(tree, output(node, f"Result_{kind}"))


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


# ----------------------------------------------------------------- patterns


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


# ---------------------------------------------- groups, muting, odd graphs


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
    source = np.array(bpy.data.images["Noise 1"].pixels).reshape(SIZE, SIZE, 4)[..., :3]
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
        ("TexNoise", "Fac", 0.5),
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
    assert evaluate_colour(probe.inputs["Color"], context) == Constant(pytest.approx(0.4))
    tree.set(probe, "Color", (0.4, 0.3, 0.2))
    colour = evaluate_colour(probe.inputs["Color"], context)
    assert isinstance(colour, Rgb)
    assert (colour.red, colour.green, colour.blue) == pytest.approx((0.4, 0.3, 0.2))
