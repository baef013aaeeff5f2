"""Principled shaders become the engine's surfaces, departures become rows."""

from types import SimpleNamespace

import numpy as np
import pytest
from conversion import messages_of, rgb_of
from material_trees import EFFICACY, add_image

from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.materials.principled import convert_principled
from lumenray.blender_addon.sync.nodes.evaluation import Context, Inputs
from lumenray.engine.scene.material import (
    Cauchy,
    Coated,
    Dielectric,
    Diffuse,
    Glossy,
    Mix,
    Raised,
    Surface,
    ThinGlass,
    Transparent,
    Varnish,
)
from lumenray.engine.scene.spectrum import Constant

pytestmark = pytest.mark.blender


def test_principled_paint_is_a_coated_base_without_rows(tree, convert):
    shader = tree.add("BsdfPrincipled", Base_Color=(0.6, 0.4, 0.2), Roughness=0.3)
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface, Coated)
    assert rgb_of(result.surface.reflectance) == pytest.approx((0.6, 0.4, 0.2))
    assert result.surface.ior == pytest.approx(1.5, abs=1e-5)
    assert result.surface.roughness == pytest.approx(0.3)
    assert (result.id, result.name, result.emission) == ("key", "Paint", None)
    assert rows == []


def test_specular_level_scales_the_reflectance_at_normal_incidence(tree, convert):
    shader = tree.add("BsdfPrincipled", IOR=1.5, Specular_IOR_Level=1.0)
    result, _ = convert(tree.surface(shader))
    reflectance = ((result.surface.ior - 1) / (result.surface.ior + 1)) ** 2
    assert reflectance == pytest.approx(0.08, rel=1e-4)


def test_no_specular_level_leaves_plain_diffuse(tree, convert):
    shader = tree.add("BsdfPrincipled", Base_Color=(0.5, 0.5, 0.5), Specular_IOR_Level=0.0)
    result, _ = convert(tree.surface(shader))
    assert result.surface == Diffuse(Constant(0.5))


@pytest.mark.parametrize(("level", "kind"), [(0.5, Coated), (0.0, Diffuse)])
def test_diffuse_roughness_is_taken_over(tree, convert, level, kind):
    shader = tree.add("BsdfPrincipled", Diffuse_Roughness=0.6, Specular_IOR_Level=level)
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface, kind)
    assert result.surface.as_coated.base_roughness == pytest.approx(0.6)
    assert rows == []


def test_full_metallic_is_glossy_alone(tree, convert):
    shader = tree.add("BsdfPrincipled", Base_Color=(0.9, 0.7, 0.3), Metallic=1.0, Roughness=0.25)
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface, Glossy)
    assert result.surface.roughness == pytest.approx(0.25)
    assert rows == []


def test_metallic_mask_mixes_place_by_place(tree, convert):
    mask = tree.add("TexImage", attributes={"image": add_image("Picture", np.eye(2)[..., None])})
    shader = tree.add("BsdfPrincipled", Metallic=mask.outputs["Color"])
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface, Mix)
    assert isinstance(result.surface.first, Coated)
    assert isinstance(result.surface.second, Glossy)
    assert result.surface.factor.pixels[..., 0].tolist() == [[1, 0], [0, 1]]
    assert rows == []


def test_principled_glass_is_a_dielectric_with_the_root_of_its_colour(tree, convert):
    shader = tree.add(
        "BsdfPrincipled",
        Base_Color=(0.25, 0.25, 0.25),
        Transmission_Weight=1.0,
        IOR=1.45,
        Roughness=0.0,
    )
    result, _ = convert(tree.surface(shader))
    assert isinstance(result.surface, Dielectric)
    assert result.surface.ior == Cauchy(pytest.approx(1.45), 0.0)
    # Light passes the boundary twice, and what Blender shows then is the base colour.
    assert result.surface.tint.value**2 == pytest.approx(0.25)


def test_alpha_lets_light_through(tree, convert):
    result, _ = convert(tree.surface(tree.add("BsdfPrincipled", Alpha=0.25)))
    assert isinstance(result.surface.first, Transparent)
    assert isinstance(result.surface.second, Coated)
    assert result.surface.factor == pytest.approx(0.25)


def test_emission_strength_times_efficacy_is_luminance(tree, convert):
    shader = tree.add("BsdfPrincipled", Emission_Color=(1.0, 0.5, 0.25), Emission_Strength=3.0)
    result, _ = convert(tree.surface(shader))
    relative = 0.2126 * 1.0 + 0.7152 * 0.5 + 0.0722 * 0.25
    assert result.emission.luminance == pytest.approx(EFFICACY * 3.0 * relative, rel=1e-5)
    assert rgb_of(result.emission.spectrum) == pytest.approx((1.0, 0.5, 0.25))
    assert result.emission.two_sided


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("Subsurface_Weight", 0.5),
    ],
)
def test_unsupported_part_of_principled_is_reported(tree, convert, name, value):
    _, rows = convert(tree.surface(tree.add("BsdfPrincipled", **{name: value})))
    (row,) = rows
    assert row["object"] == "Paint"
    assert row["node"] == "Principled BSDF"
    assert row["instead"]


def test_the_tint_of_a_highlight_is_taken_over_but_for_glass(tree, convert):
    values = {"Specular_Tint": (1.0, 0.2, 0.2)}
    result, rows = convert(tree.surface(tree.add("BsdfPrincipled", **values)))
    assert rgb_of(result.surface.tint) == pytest.approx((1.0, 0.2, 0.2))
    assert rows == []
    _, rows = convert(tree.surface(tree.add("BsdfPrincipled", Transmission_Weight=1.0, **values)))
    assert "highlight" in messages_of(rows)


def test_a_coat_lies_over_each_part_of_a_mixture(tree, convert):
    shader = tree.add(
        "BsdfPrincipled",
        Metallic=0.5,
        Coat_Weight=0.75,
        Coat_Roughness=0.2,
        Coat_IOR=1.7,
        Coat_Tint=(0.3, 0.6, 0.9),
    )
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface, Mix)
    for part, base in ((result.surface.first, Coated), (result.surface.second, Glossy)):
        assert isinstance(part, Varnish)
        assert isinstance(part.base, base)
        assert (part.weight, part.roughness, part.ior) == pytest.approx((0.75, 0.2, 1.7))
        assert rgb_of(part.tint) == pytest.approx((0.3, 0.6, 0.9))
    assert rows == []


def test_the_weight_of_a_coat_may_vary_by_place(tree, convert):
    mask = tree.add("TexImage", attributes={"image": add_image("Picture", np.eye(2)[..., None])})
    result, rows = convert(
        tree.surface(tree.add("BsdfPrincipled", Coat_Weight=mask.outputs["Color"]))
    )
    assert isinstance(result.surface, Varnish)
    np.testing.assert_allclose(result.surface.weight.pixels.squeeze(), np.eye(2))
    assert rows == []


def test_a_coat_dims_the_light_below_it(tree, convert):
    """By a smooth coat of index 1.5, which reflects 9.2 % of even light (Duntley)."""
    values = {"Emission_Color": (1.0, 1.0, 1.0), "Emission_Strength": 3.0, "Coat_Weight": 1.0}
    result, rows = convert(tree.surface(tree.add("BsdfPrincipled", **values)))
    assert result.emission.luminance == pytest.approx(EFFICACY * 3.0 * (1.0 - 0.0918), rel=2e-3)
    assert "dims" in messages_of(rows)


def test_a_normal_bends_all_parts_of_principled_but_those_that_light_passes_straight(tree, convert):
    normal = tree.add("NormalMap", Color=(0.7, 0.5, 0.9))
    shader = tree.add("BsdfPrincipled", Metallic=0.5, Alpha=0.5, Normal=normal.outputs[0])
    result, rows = convert(tree.surface(shader))
    assert rows == []
    assert isinstance(result.surface.first, Transparent)
    assert all(
        isinstance(part, Raised)
        for part in vars(result.surface.second).values()
        if isinstance(part, Surface)
    )


def test_a_normal_of_the_coats_own_is_reported(tree, convert):
    normal = tree.add("NormalMap", Color=(0.7, 0.5, 0.9))
    shader = tree.add("BsdfPrincipled", Coat_Weight=0.5, Coat_Normal=normal.outputs[0])
    assert "normal of the coat" in messages_of(convert(tree.surface(shader))[1])


def test_roughness_picture_of_a_coat_becomes_its_mean_with_a_row(tree, convert):
    picture = tree.add("TexImage", attributes={"image": add_image("Picture", [[[0.2], [0.6]]])})
    shader = tree.add("BsdfPrincipled", Roughness=picture.outputs["Color"])
    result, rows = convert(tree.surface(shader))
    assert result.surface.roughness == pytest.approx(0.4, abs=1e-5)
    assert "0.4" in rows[0]["instead"]


def test_colour_above_one_is_held_and_reported(tree, convert):
    shader = tree.add("BsdfDiffuse", Color=(2.0, 0.5, 0.5))
    result, rows = convert(tree.surface(shader))
    assert result.surface.reflectance.red == 1.0
    assert "0..1" in messages_of(rows)


@pytest.mark.parametrize("roughness", [0.0, 0.5])
def test_a_thin_wall_is_a_pane_and_no_solid(tree, roughness):
    """The node has its socket from Blender 5.2 on; here one is put beside those that it has."""
    shader = tree.add(
        "BsdfPrincipled", Transmission_Weight=1.0, Base_Color=(0.5, 0.5, 0.5), Roughness=roughness
    )
    wall = SimpleNamespace(
        identifier="Thin Wall", name="Thin Wall", type="BOOLEAN", links=(), default_value=True, is_output=False
    )  # fmt: skip
    report = ConversionReport()
    context = Context("Paint", report)
    for default_value, kind in ((True, ThinGlass), (False, Dielectric)):
        wall.default_value = default_value
        node = SimpleNamespace(name=shader.name, inputs=[*shader.inputs, wall])
        made = convert_principled(Inputs(node, shader.outputs[0], context, ()))
        assert isinstance(made.surface, kind)
        if default_value:
            assert made.surface.ior == pytest.approx(1.5)
            assert made.surface.transmittance == Constant(pytest.approx(0.5))
            assert bool(report.rows) == (roughness > 0.1)
