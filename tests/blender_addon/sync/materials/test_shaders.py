"""Shaders and their mixtures become the engine's surfaces, departures become rows."""

import bpy
import numpy as np
import pytest
from conversion import messages_of, rgb_of
from material_trees import EFFICACY, add_image

from lumenray.engine.scene.material import (
    Black,
    Blend,
    Cauchy,
    Coated,
    Dielectric,
    Diffuse,
    Glossy,
    Transparent,
)
from lumenray.engine.scene.spectrum import Blackbody, Constant, Illuminant
from lumenray.engine.scene.texture import ImageTexture

pytestmark = pytest.mark.blender


def test_simple_shaders_become_their_surfaces_without_rows(tree, convert):
    white = (1.0, 1.0, 1.0)
    for shader, surface in [
        (tree.add("BsdfDiffuse", Color=white), Diffuse(Constant(1.0))),
        (tree.add("BsdfTranslucent", Color=white), Diffuse(Constant(0.0), Constant(1.0))),
        (tree.add("BsdfTransparent", Color=white), Transparent(Constant(1.0))),
        (
            tree.add("BsdfGlass", Color=white, IOR=1.5, Roughness=0.0),
            Dielectric(Cauchy(1.5, 0.0), 0.0, Constant(1.0)),
        ),
        (
            tree.add("BsdfAnisotropic", Color=white, Roughness=0.0, Anisotropy=0.0),
            Glossy(Constant(1.0), 0.0),
        ),
    ]:
        result, rows = convert(tree.surface(shader))
        assert result.surface == surface
        assert rows == []


def test_translucent_and_diffuse_added_are_one_exact_surface(tree, convert):
    first = tree.add("BsdfDiffuse", Color=(0.5, 0.5, 0.5)).outputs[0]
    second = tree.add("BsdfTranslucent", Color=(0.3, 0.3, 0.3)).outputs[0]
    result, rows = convert(tree.surface(tree.add("AddShader", Shader=first, Shader_001=second)))
    assert result.surface.reflectance.value == pytest.approx(0.5)
    assert result.surface.transmittance.value == pytest.approx(0.3)
    assert rows == []


def test_diffuse_sum_above_one_is_reduced_in_proportion(tree, convert):
    first = tree.add("BsdfDiffuse", Color=(0.8, 0.8, 0.8)).outputs[0]
    second = tree.add("BsdfTranslucent", Color=(0.8, 0.8, 0.8)).outputs[0]
    result, rows = convert(tree.surface(tree.add("AddShader", Shader=first, Shader_001=second)))
    assert result.surface.reflectance.value == pytest.approx(0.5)
    assert result.surface.transmittance.value == pytest.approx(0.5)
    assert "more than 1" in messages_of(rows)


@pytest.mark.parametrize(("grey", "count"), [(0.4, 0), (0.8, 1)])
def test_two_unlike_shaders_are_added_and_said_where_they_are_too_much(tree, convert, grey, count):
    colour = (grey, grey, grey)
    first = tree.add("BsdfDiffuse", Color=colour).outputs[0]
    second = tree.add("BsdfAnisotropic", Color=colour, Anisotropy=0.0).outputs[0]
    result, rows = convert(tree.surface(tree.add("AddShader", Shader=first, Shader_001=second)))
    assert isinstance(result.surface, Blend)
    assert isinstance(result.surface.first, Diffuse)
    assert isinstance(result.surface.second, Glossy)
    assert (result.surface.weights == 1.0).all()
    assert len(rows) == count
    assert count == 0 or "160%" in messages_of(rows)


def test_mix_of_emission_and_diffuse_shares_the_emission(tree, convert):
    light = tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=10.0).outputs[0]
    matt = tree.add("BsdfDiffuse", Color=(0.5, 0.5, 0.5)).outputs[0]
    mixed = tree.add("MixShader", Fac=0.25, Shader=light, Shader_001=matt)
    result, _ = convert(tree.surface(mixed))
    assert result.emission.luminance == pytest.approx(EFFICACY * 7.5, rel=1e-5)
    assert result.emission.spectrum == Illuminant("D65")
    assert isinstance(result.surface.first, Black)
    assert result.surface.factor == pytest.approx(0.25)


def test_emission_added_to_a_surface_leaves_the_surface_whole(tree, convert):
    light = tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=2.0).outputs[0]
    matt = tree.add("BsdfDiffuse", Color=(0.5, 0.5, 0.5)).outputs[0]
    result, rows = convert(tree.surface(tree.add("AddShader", Shader=light, Shader_001=matt)))
    assert result.surface == Diffuse(Constant(0.5))
    assert result.emission.luminance == pytest.approx(EFFICACY * 2.0)
    assert rows == []


def test_luminous_picture_keeps_its_luminance_at_every_place(tree, convert):
    pixels = np.array([[[1.0, 0.0, 0.0], [0.5, 0.5, 0.5]], [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]])
    picture = tree.add("TexImage", attributes={"image": add_image("Picture", pixels)})
    light = tree.add("Emission", Color=picture.outputs["Color"], Strength=4.0)
    result, _ = convert(tree.surface(light))
    weights = np.array([0.2126, 0.7152, 0.0722])
    ours = result.emission.luminance * result.emission.pattern.pixels @ weights
    assert ours == pytest.approx(EFFICACY * 4.0 * pixels @ weights, rel=1e-5)


def test_blackbody_emission_keeps_plancks_spectrum(tree, convert):
    colour = tree.add("Blackbody", Temperature=2700.0).outputs[0]
    result, _ = convert(tree.surface(tree.add("Emission", Color=colour, Strength=5.0)))
    assert result.emission.spectrum == Blackbody(2700.0)
    # Blender's blackbody colours have luminance 1.
    assert result.emission.luminance == pytest.approx(EFFICACY * 5.0, rel=1e-3)


def test_constant_factor_hides_the_other_branch_and_its_rows(tree, convert):
    odd = tree.add("BsdfToon").outputs[0]
    matt = tree.add("BsdfDiffuse", Color=(0.5, 0.5, 0.5)).outputs[0]
    result, rows = convert(
        tree.surface(tree.add("MixShader", Fac=1.0, Shader=odd, Shader_001=matt))
    )
    assert result.surface == Diffuse(Constant(0.5))
    assert rows == []


def test_glass_that_hides_from_shadow_rays_stays_glass(tree, convert):
    path = tree.add("LightPath")
    glass = tree.add("BsdfGlass", Color=(1.0, 1.0, 1.0)).outputs[0]
    clear = tree.add("BsdfTransparent").outputs[0]
    mixed = tree.add("MixShader", Fac=path.outputs["Is Shadow Ray"], Shader=glass)
    tree.set(mixed, "Shader 001", clear)
    result, rows = convert(tree.surface(mixed))
    assert isinstance(result.surface, Dielectric)
    assert "Is Shadow Ray" in messages_of(rows)


def test_gloss_over_diffuse_by_fresnel_is_a_coated_base(tree, convert):
    mixed = tree.add(
        "MixShader",
        Fac=tree.add("Fresnel", IOR=1.4).outputs[0],
        Shader=tree.add("BsdfDiffuse", Color=(0.5, 0.5, 0.5)).outputs[0],
        Shader_001=tree.add("BsdfAnisotropic", Roughness=0.3, Anisotropy=0.0).outputs[0],
    )
    result, rows = convert(tree.surface(mixed))
    assert isinstance(result.surface, Coated)
    assert result.surface.ior == pytest.approx(1.4)
    assert result.surface.roughness == pytest.approx(0.3)
    assert len(rows) == 1


def test_mirror_over_transparent_by_fresnel_keeps_both_by_the_angle(tree, convert):
    mixed = tree.add(
        "MixShader",
        Fac=tree.add("Fresnel", IOR=1.5).outputs[0],
        Shader=tree.add("BsdfTransparent", Color=(0.9, 0.9, 0.9)).outputs[0],
        Shader_001=tree.add("BsdfAnisotropic", Roughness=0.0, Anisotropy=0.0).outputs[0],
    )
    result, rows = convert(tree.surface(mixed))
    surface = result.surface
    assert isinstance(surface.first, Transparent)
    assert isinstance(surface.second, Glossy)
    (through, mirrored), (_, inside) = surface.weights
    # Fresnel along the normal, at Brewster's angle (s alone, halved), and beyond the critical angle from inside.
    brewster = 0.5 * ((1.5**2 - 1.0) / (1.5**2 + 1.0)) ** 2
    at = [np.interp(np.sqrt(c), np.linspace(0, 1, 512), mirrored) for c in (1.0, 3.25**-0.5)]
    assert at == pytest.approx([0.04, brewster], rel=2e-3)
    assert np.interp(np.sqrt(0.5), np.linspace(0, 1, 512), inside) == pytest.approx(1.0)
    np.testing.assert_allclose(through + mirrored, 1.0)
    assert rows == []


def test_what_is_made_of_facing_is_followed_by_the_angle(tree, convert):
    """Blender's facing is 1 - cos at a blend of a half."""
    facing = tree.add("LayerWeight", Blend=0.5).outputs["Facing"]
    squared = tree.add("Math", attributes={"operation": "MULTIPLY"}, Value=facing)
    tree.set(squared, "Value 001", facing)
    mixed = tree.add(
        "MixShader",
        Fac=squared.outputs[0],
        Shader=tree.add("BsdfDiffuse").outputs[0],
        Shader_001=tree.add("BsdfTranslucent").outputs[0],
    )
    result, rows = convert(tree.surface(mixed))
    expected = (1.0 - np.linspace(0.0, 1.0, 512) ** 2) ** 2
    for side in range(2):
        np.testing.assert_allclose(result.surface.weights[side, 1], expected, atol=1e-5)
    assert rows == []


def test_a_colour_by_facing_is_a_blend_of_its_ends(tree, convert):
    colour = tree.add("MixRGB", Color1=(0.1, 0.2, 0.6), Color2=(0.9, 0.7, 0.5))
    tree.set(colour, "Fac", tree.add("LayerWeight", Blend=0.5).outputs["Facing"])
    shader = tree.add("BsdfDiffuse", Color=colour.outputs[0])
    result, rows = convert(tree.surface(shader))
    surface = result.surface
    ends = [rgb_of(part.reflectance) for part in (surface.first, surface.second)]
    cosine = np.linspace(0.0, 1.0, 512)[:, None] ** 2
    expected = cosine * (0.1, 0.2, 0.6) + (1.0 - cosine) * (0.9, 0.7, 0.5)
    for side in range(2):
        found = surface.weights[side].T @ np.array(ends)
        np.testing.assert_allclose(found, expected, atol=1e-4)
    assert rows == []


def test_light_by_facing_counts_by_its_mean_with_a_row(tree, convert):
    """Facing at a blend of a half is 1 - cos, a third of even light."""
    mixed = tree.add(
        "MixShader",
        Fac=tree.add("LayerWeight", Blend=0.5).outputs["Facing"],
        Shader=tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=3.0).outputs[0],
        Shader_001=tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=6.0).outputs[0],
    )
    result, rows = convert(tree.surface(mixed))
    assert isinstance(result.surface, Black)
    assert result.emission.luminance == pytest.approx(EFFICACY * 4.0, rel=2e-3)
    assert "viewing angle" in messages_of(rows)


def test_a_colour_by_facing_of_a_rough_metal_is_its_mean_with_a_row(tree, convert):
    facing = tree.add("LayerWeight").outputs["Facing"]
    shader = tree.add("BsdfAnisotropic", Color=facing, Roughness=0.8, Anisotropy=0.0)
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface, Glossy)
    assert "viewing angle" in messages_of(rows)


def test_front_and_back_may_be_different_surfaces(tree, convert):
    mixed = tree.add(
        "MixShader",
        Fac=tree.add("NewGeometry").outputs["Backfacing"],
        Shader=tree.add("BsdfDiffuse", Color=(0.2, 0.2, 0.2)).outputs[0],
        Shader_001=tree.add("BsdfDiffuse", Color=(0.7, 0.7, 0.7)).outputs[0],
    )
    result, rows = convert(tree.surface(mixed))
    assert result.surface.first == Diffuse(Constant(pytest.approx(0.2)))
    assert (result.surface.weights[:, 1] == np.array([[0.0], [1.0]])).all()
    assert rows == []


def test_coloured_glass_tints_what_it_reflects_too(tree, convert):
    shader = tree.add("BsdfGlass", Color=(0.6, 0.9, 0.7), Roughness=0.0)
    result, rows = convert(tree.surface(shader))
    assert rgb_of(result.surface.mirror_tint) == pytest.approx((0.6, 0.9, 0.7))
    assert result.surface.tint == result.surface.mirror_tint
    assert rows == []


@pytest.mark.parametrize(("component", "is_glossy"), [("DIFFUSE", False), ("GLOSSY", True)])
def test_a_toon_is_taken_over(tree, convert, component, is_glossy):
    attributes = {"component": component}
    shader = tree.add("BsdfToon", attributes=attributes, Size=0.4, Smooth=0.2)
    result, rows = convert(tree.surface(shader))
    assert (result.surface.size, result.surface.edge) == pytest.approx((0.4, 0.2))
    assert result.surface.is_glossy == is_glossy
    assert rows == []


def test_a_refraction_does_not_reflect(tree, convert):
    shader = tree.add("BsdfRefraction", attributes={"distribution": "GGX"}, IOR=1.4)
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface, Dielectric)
    assert not result.surface.reflects
    assert rows == []


def test_emission_of_the_front_alone_stays_one_sided(tree, convert):
    mixed = tree.add(
        "MixShader",
        Fac=tree.add("NewGeometry").outputs["Backfacing"],
        Shader=tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=1.0).outputs[0],
        Shader_001=tree.add("BsdfDiffuse").outputs[0],
    )
    result, rows = convert(tree.surface(mixed))
    assert not result.emission.two_sided
    assert rows == []


def test_light_of_the_back_alone_is_left_out_with_an_error(tree, convert):
    mixed = tree.add(
        "MixShader",
        Fac=tree.add("NewGeometry").outputs["Backfacing"],
        Shader=tree.add("BsdfDiffuse").outputs[0],
        Shader_001=tree.add("Emission", Strength=1.0).outputs[0],
    )
    result, rows = convert(tree.surface(mixed))
    assert result.emission is None
    assert [row["severity"] for row in rows] == ["error"]


@pytest.mark.parametrize("kind", ["SubsurfaceScattering", "BsdfHair"])
def test_unsupported_shader_is_diffuse_of_its_colour_with_a_row(tree, convert, kind):
    shader = tree.add(kind, Color=(0.5, 0.25, 0.125))
    result, rows = convert(tree.surface(shader))
    assert rgb_of(result.surface.reflectance) == pytest.approx((0.5, 0.25, 0.125))
    assert rows[0]["node"] == shader.name


def test_shader_group_is_entered(tree, convert):
    group = bpy.data.node_groups.new("Wall", "ShaderNodeTree")
    group.interface.new_socket("Colour", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    matt = group.nodes.new("ShaderNodeBsdfDiffuse")
    group.links.new(start.outputs[0], matt.inputs["Color"])
    group.links.new(matt.outputs[0], end.inputs[0])
    node = tree.add("Group", attributes={"node_tree": group})
    node.inputs[0].default_value = (0.25, 0.25, 0.25, 1.0)
    result, rows = convert(tree.surface(node))
    assert result.surface == Diffuse(Constant(0.25))
    assert rows == []


def test_picture_of_a_wall_keeps_its_pixels(tree, convert):
    pixels = np.random.default_rng(1).uniform(0, 1, (3, 4, 3))
    picture = tree.add("TexImage", attributes={"image": add_image("Wall", pixels)})
    shader = tree.add("BsdfDiffuse", Color=picture.outputs["Color"])
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface.reflectance, ImageTexture)
    assert result.surface.reflectance.pixels == pytest.approx(pixels, abs=1e-6)
    assert rows == []


def gradient_lamp(tree, kind):
    """Let a gradient that is cut by a ramp decide where a surface glows."""
    ramp = tree.add("ValToRGB", Fac=tree.add("TexGradient").outputs["Fac"])
    ramp.color_ramp.interpolation = "CONSTANT"
    ramp.color_ramp.elements[1].position = 0.75
    if kind == "factor":
        glow = tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=8.0)
        mix = tree.add("MixShader")
        for place, socket in enumerate((ramp.outputs["Color"], None, glow.outputs[0])):
            if socket is not None:
                tree.material.node_tree.links.new(socket, mix.inputs[place])
        return mix
    if kind == "strength":
        return tree.add("Emission", Color=ramp.outputs["Color"], Strength=8.0)
    return tree.add("BsdfPrincipled", Emission_Color=ramp.outputs["Color"], Emission_Strength=8.0)


@pytest.mark.parametrize("kind", ["factor", "strength", "principled"])
def test_a_lamp_behind_a_texture_that_is_replaced_keeps_its_light_and_is_an_error(
    tree, convert, kind
):
    result, rows = convert(tree.surface(gradient_lamp(tree, kind)))
    # A quarter of the surface glows with 8 W/(m2 sr).
    assert result.emission.luminance == pytest.approx(2.0 * EFFICACY, rel=0.02)
    assert result.emission.pattern is None
    (row,) = (row for row in rows if row["severity"] == "error")
    assert "emission depends on what cannot be taken over" in row["message"]


def test_a_surface_behind_a_replaced_texture_is_no_error(tree, convert):
    ramp = tree.add("ValToRGB", Fac=tree.add("TexNoise").outputs["Fac"])
    glow = tree.add("BsdfPrincipled", Base_Color=ramp.outputs["Color"], Emission_Strength=1.0)
    result, rows = convert(tree.surface(glow))
    assert result.emission.luminance == pytest.approx(EFFICACY)
    assert {row["severity"] for row in rows} == {"warning"}


@pytest.mark.parametrize(
    ("strength", "words"),
    [(-3.0, "negative"), (float("inf"), "W/(m2 sr)"), (float("nan"), "cannot be taken over")],
)
def test_an_emission_that_is_no_light_is_an_error(tree, convert, strength, words):
    material = tree.surface(tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=strength))
    result, rows = convert(material)
    assert result.emission is None
    assert any(row["severity"] == "error" and words in row["message"] for row in rows)
