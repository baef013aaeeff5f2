"""Physical parameters start with what a light gives, in a quantity that suits it, and a light shines by one file."""

import math

import bpy
import numpy as np
import pytest
from panels import draw, interface, new_light

from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.lights.lights import convert_light
from lumenray.engine.photometry.units import BLENDER_EFFICACY
from lumenray.engine.transport.compiled.emission import (
    area_luminance,
    line_luminance,
    luminaire_flux,
    point_intensity,
    spot_intensity,
    sun_illuminance,
)
from lumenray.libraries import luminaires

AMOUNT = {
    "PointLight": point_intensity,
    "SpotLight": spot_intensity,
    "SunLight": sun_illuminance,
    "AreaLight": area_luminance,
    "LineLight": line_luminance,
    "Luminaire": luminaire_flux,
}
"""What the engine makes of each kind."""


@pytest.fixture(autouse=True)
def _registered(registered):
    with interface():
        yield


def emitted(source):
    """Amount of light that the engine gets of an object. [cd, cd/m2, lx or lm, by its kind]"""
    bpy.context.view_layer.update()
    efficacy = bpy.context.scene.lumenray.efficacy
    made = convert_light(source, "x", "x", source.matrix_world, 1.0, efficacy, ConversionReport())
    return 0.0 if made is None else AMOUNT[type(made).__name__](made).amount


def add_ies_node(light):
    """Let an IES texture shape a light, with a strength of 2."""
    light.use_nodes = True
    tree = light.node_tree
    emission = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeEmission")
    texture = tree.nodes.new("ShaderNodeTexIES")
    texture.mode = "EXTERNAL"
    texture.filepath = str(luminaires.FOLDER / "photometry" / "downlight_60.ies")
    texture.inputs["Strength"].default_value = 2.0
    tree.links.new(texture.outputs[0], emission.inputs["Strength"])


def set_strength(light):
    """Let a light's own nodes treble it in a colour."""
    light.use_nodes = True
    emission = next(n for n in light.node_tree.nodes if n.bl_idname == "ShaderNodeEmission")
    emission.inputs["Strength"].default_value = 3.0
    emission.inputs["Color"].default_value = (1.0, 0.5, 0.2, 1.0)


def spread_out(light):
    """Let a light grow brighter with its size, where Blender knows that."""
    if hasattr(light, "normalize"):
        light.normalize = False


def draw_out(light):
    """Make a point light a tube."""
    light.lumenray.tube_length = 1.2


def draw_out_and_spread(light):
    """Make a point light a tube that grows brighter with its size."""
    draw_out(light)
    spread_out(light)


CASES = {
    "point": ("POINT", {"energy": 1000.0}, None),
    "coloured point": ("POINT", {"energy": 60.0, "color": (1.0, 0.3, 0.1)}, None),
    "point with nodes": ("POINT", {"energy": 5.0}, set_strength),
    "point not normalised": ("POINT", {"energy": 9.0, "shadow_soft_size": 0.3}, spread_out),
    "tube": ("POINT", {"energy": 30.0, "shadow_soft_size": 0.02}, draw_out),
    "tube not normalised": (
        "POINT",
        {"energy": 9.0, "shadow_soft_size": 0.02},
        draw_out_and_spread,
    ),
    "narrow spot": ("SPOT", {"energy": 100.0, "spot_size": 0.4, "spot_blend": 0.7}, None),
    "spot with an IES texture": ("SPOT", {"energy": 1.0, "spot_size": 2.0}, add_ies_node),
    "sun": ("SUN", {"energy": 3.5, "angle": 0.01}, None),
    "dark sun": ("SUN", {"energy": 0.0}, None),
    "area": ("AREA", {"energy": 40.0, "shape": "ELLIPSE", "size": 0.5, "size_y": 0.2}, None),
    "area of small spread": ("AREA", {"energy": 40.0, "spread": 0.6}, None),
    "area not normalised": ("AREA", {"energy": 40.0, "size": 0.7}, spread_out),
}


@pytest.mark.parametrize("case", CASES)
def test_switching_physical_parameters_on_changes_no_light(case):
    kind, values, prepare = CASES[case]
    source = new_light(kind).object
    source.scale = (1.5, 2.0, 1.0)
    light = source.data
    for name, value in values.items():
        setattr(light, name, value)
    if prepare is not None:
        prepare(light)
    before = emitted(source)
    lights = len(bpy.data.lights), len(bpy.data.objects)
    light.lumenray.use_physical = True
    assert emitted(source) == pytest.approx(before, rel=1e-5)
    assert (len(bpy.data.lights), len(bpy.data.objects)) == lights
    # Switched off and on again it starts with what has changed meanwhile.
    light.lumenray.use_physical = False
    light.energy *= 0.5
    light.lumenray.use_physical = True
    assert emitted(source) == pytest.approx(0.5 * before, rel=1e-5)


def test_a_kilowatt_point_starts_with_its_lumens_in_blenders_meaning():
    light = new_light("POINT").light
    light.energy = 1000.0
    light.lumenray.use_physical = True
    assert light.lumenray.quantity == "LUMINOUS_FLUX"
    assert light.lumenray.value == pytest.approx(1000.0 * BLENDER_EFFICACY, rel=1e-6)


def test_a_tube_lies_along_the_x_axis_of_its_point_light_and_has_its_flux():
    where = new_light("POINT")
    light, source = where.light, where.object
    light.shadow_soft_size, light.energy = 0.02, 1000.0
    light.lumenray.tube_length = 1.2
    source.location = (1.0, 2.0, 3.0)
    source.rotation_euler = (0.0, 0.0, math.radians(90.0))
    bpy.context.view_layer.update()
    made = convert_light(source, "x", "x", source.matrix_world, 0.5, 10.0, ConversionReport())
    assert type(made).__name__ == "LineLight"
    # A Blender unit is half a metre here.
    assert (made.length, made.radius) == (pytest.approx(0.6), pytest.approx(0.01))
    np.testing.assert_allclose(made.frame[:3, 3], [0.5, 1.0, 1.5], atol=1e-6)
    np.testing.assert_allclose(made.frame[:3, 0], [0.0, 1.0, 0.0], atol=1e-6)
    assert line_luminance(made).amount * math.pi * made.area == pytest.approx(1000.0 * 10.0)
    assert "tube_length" in draw("LUMENRAY_PT_light", where)


def test_a_sun_is_darkened_at_its_limb_where_that_is_asked_for():
    where = new_light("SUN")
    source, light = where.object, where.light
    given = [source, "x", "x", source.matrix_world, 1.0, 10.0, ConversionReport()]
    assert convert_light(*given).limb_darkening == 0.0
    light.lumenray.limb_darkening = True
    assert convert_light(*given).limb_darkening == 0.6
    assert "limb_darkening" in draw("LUMENRAY_PT_light", where)


def test_the_3d_view_draws_a_tube_where_the_engine_has_it():
    from lumenray.ui import tube_overlay

    where = new_light("POINT")
    light, source = where.light, where.object
    light.shadow_soft_size, light.lumenray.tube_length = 0.05, 1.2
    source.location, source.scale = (1.0, 2.0, 3.0), (2.0, 0.5, 1.0)
    source.rotation_euler = (0.3, 0.2, 0.7)
    bpy.context.view_layer.update()
    made = convert_light(source, "x", "x", source.matrix_world, 1.0, 10.0, ConversionReport())
    assert tube_overlay.shown_tubes(bpy.context) == [source]
    own = (tube_overlay.place_outline(source) - made.frame[:3, 3]) @ made.frame[:3, :3]
    np.testing.assert_allclose(np.hypot(own[:, 1], own[:, 2]), made.radius, rtol=1e-5)
    np.testing.assert_allclose(np.abs(own[:, 0]), 0.5 * made.length, rtol=1e-5)
    # Where a file says how it shines there is no tube.
    light.lumenray.rayset.use_file = True
    assert tube_overlay.shown_tubes(bpy.context) == []
    light.lumenray.rayset.use_file, light.lumenray.tube_length = False, 0.0
    assert tube_overlay.shown_tubes(bpy.context) == []


def test_a_tube_without_a_radius_is_left_out_and_said():
    where = new_light("POINT")
    where.light.shadow_soft_size = 0.0
    where.light.lumenray.tube_length = 1.2
    report = ConversionReport()
    source = where.object
    assert convert_light(source, "x", "tube", source.matrix_world, 1.0, 10.0, report) is None
    assert any("radius of 0 m" in row.message for row, _ in report.rows)


def test_what_was_stated_is_kept():
    light = new_light("POINT").light
    settings = light.lumenray
    settings.quantity, settings.value = "LUMINOUS_INTENSITY", 80.0
    settings.use_physical = True
    assert (settings.quantity, settings.value) == ("LUMINOUS_INTENSITY", 80.0)
    settings.use_physical = False
    settings.use_physical = True
    assert (settings.quantity, settings.value) == ("LUMINOUS_INTENSITY", 80.0)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        (
            "POINT",
            {"LUMINOUS_FLUX", "LUMINOUS_INTENSITY", "ILLUMINANCE", "LUMINANCE", "RADIANT_FLUX"},
        ),
        ("SPOT", {"LUMINOUS_FLUX", "LUMINOUS_INTENSITY", "ILLUMINANCE", "RADIANT_FLUX"}),
        ("SUN", {"ILLUMINANCE", "RADIANT_FLUX"}),
    ],
)
def test_panels_offer_the_quantities_that_suit_a_light(kind, expected):
    where = new_light(kind)
    if kind == "SUN":
        where.light.angle = 0.0
    where.light.lumenray.use_physical = True
    for name in ("LUMENRAY_PT_light_photometry", "LUMENRAY_PT_active_light"):
        seen = draw(name, where)
        offered = {text.partition("=")[2] for text in seen if text.startswith("quantity=")}
        assert offered == expected
        assert "quantity" not in seen
    if kind == "SUN":
        # A disk has a luminance.
        where.light.angle = math.radians(0.53)
        assert "quantity=LUMINANCE" in draw("LUMENRAY_PT_light_photometry", where)


def test_a_luminaire_and_a_ray_set_switch_each_other_off_and_the_panel_says_so():
    where = new_light("POINT")
    settings = where.light.lumenray
    settings.rayset.filepath = "library:led_dome"
    settings.luminaire.filepath = str(luminaires.FOLDER / "photometry" / "downlight_60.ies")
    settings.luminaire.use_file = True
    settings.rayset.use_file = True
    assert not settings.luminaire.use_file
    assert "Off: the ray set gives the light" in draw("LUMENRAY_PT_luminaire", where)
    settings.luminaire.use_file = True
    assert not settings.rayset.use_file
    seen = " ".join(draw("LUMENRAY_PT_rayset", where))
    assert "Off: the photometric file gives the light" in seen
    assert np.isfinite(emitted(where.object))
