"""Images in colour graphs: pixels, places and several at once, as Cycles renders them on a UV square."""

import re

import bpy
import numpy as np
import pytest
from material_trees import PIXELS, add_image, add_texture, evaluate, noise_image

from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.images.pixels import decode_srgb
from lumenray.blender_addon.sync.nodes import fields
from lumenray.blender_addon.sync.nodes.evaluation import Context, evaluate_field
from lumenray.engine.scene.texture import ImageTexture

pytestmark = pytest.mark.blender


def test_byte_image_in_srgb_is_linearised(tree):
    image = add_image("Grey", np.full((2, 2, 3), 128 / 255), "sRGB", is_float=False)
    ours, _ = evaluate(tree, add_texture(tree, image).outputs["Color"])
    assert ours[0, 0] == pytest.approx(0.2158605, abs=1e-5)


def test_byte_image_of_data_is_not_linearised(tree):
    image = add_image("Grey", np.full((2, 2, 3), 128 / 255), "Non-Color", is_float=False)
    ours, _ = evaluate(tree, add_texture(tree, image).outputs["Color"])
    assert ours[0, 0] == pytest.approx(128 / 255, abs=1e-5)


def test_pictures_that_cycles_shows_darker_keep_the_mean_of_their_pixels(tree, cycles_colour):
    pixels = np.random.default_rng(2).random((4, 4, 3))
    texture = add_texture(tree, add_image("Noise", pixels, "sRGB", is_float=False))
    ours, report = evaluate(tree, texture.outputs["Color"])
    assert report.rows == []
    mean = decode_srgb(np.round(255.0 * pixels) / 255.0).mean()
    assert ours.mean() == pytest.approx(mean, rel=1e-5)
    texture.interpolation = "Linear"
    evaluate_field(
        tree.add("Emission", Color=texture.outputs["Color"]).inputs["Color"],
        Context("Paint", report),
    )
    ((row, _),) = report.rows
    theirs = cycles_colour(tree, texture.outputs["Color"])
    told = float(re.search(r"it (\S+) % darker", row.message).group(1))
    assert told == pytest.approx(100.0 * (1.0 - theirs.mean() / mean), abs=1.0)


def test_first_row_of_a_picture_is_the_bottom(tree):
    pixels = np.zeros((2, 2, 3))
    pixels[0] = 1.0
    probe = tree.add(
        "Emission", Color=add_texture(tree, add_image("Half", pixels)).outputs["Color"]
    )
    texture = fields.as_colour(
        evaluate_field(probe.inputs["Color"], Context("Paint", ConversionReport()))
    )
    assert isinstance(texture, ImageTexture)
    assert texture.pixels[0].min() == 1.0
    assert texture.pixels[1].max() == 0.0
    assert texture.interpolation == "closest"
    assert texture.name == "Half"


@pytest.mark.parametrize("is_alpha_used", [False, True])
@pytest.mark.parametrize("space", ["sRGB", "Non-Color"])
def test_transparent_pixels_look_as_in_cycles(tree, agree, is_alpha_used, space):
    pixels = np.random.default_rng(4).uniform(0.1, 0.9, (PIXELS, PIXELS, 4))
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
    texture = fields.as_scalar(
        evaluate_field(probe.inputs[0], Context("Paint", ConversionReport()))
    )
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
    colour = fields.as_colour(
        evaluate_field(probe.inputs["Color"], Context("Paint", ConversionReport()))
    )
    assert colour.uv_map == "Detail"


def test_generated_coordinates_give_the_mean_and_a_row(tree):
    image = noise_image(1)
    texture = add_texture(tree, image, Vector=tree.add("TexCoord").outputs["Generated"])
    ours, report = evaluate(tree, texture.outputs["Color"])
    expected = np.array(image.pixels).reshape(-1, 4)[:, :3].mean(0)
    assert ours[3, 3] == pytest.approx(expected, abs=1e-5)
    assert report.to_dicts()[0]["instead"] == "the picture's mean is used"


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


def test_bytes_are_decoded_as_any_other_values():
    from lumenray.blender_addon.sync.images.pixels import _decode_bytes

    codes = np.arange(256, dtype=np.float32) / np.float32(255.0)
    np.testing.assert_allclose(_decode_bytes(codes), decode_srgb(codes.astype(float)), rtol=1e-6)
    between = codes * np.float32(0.7)
    np.testing.assert_allclose(_decode_bytes(between), decode_srgb(between), rtol=1e-6)
