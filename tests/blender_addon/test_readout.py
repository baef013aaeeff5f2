"""What panels say about lights, against closed forms and against what the engine is given."""

import math

import bpy
import numpy as np
import pytest

from lumenray.blender_addon import readout
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.lights import readings
from lumenray.blender_addon.sync.lights.lights import convert_light
from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.scene.light import Quantity


def lamp(kind, quantity=None, value=1000.0, **attributes):
    """Return a light object; physical where a quantity is given."""
    light = bpy.data.lights.new("Lamp", kind)
    if quantity:
        light.lumenray.use_physical = True
        light.lumenray.quantity = quantity
        light.lumenray.value = value
        light.lumenray.spectrum = "ILLUMINANT"
    for name, item in attributes.items():
        setattr(light, name, item)
    source = bpy.data.objects.new("Lamp", light)
    bpy.context.scene.collection.objects.link(source)
    return source


def lines_of(source):
    return dict(readout.describe_lamp(source, bpy.context.scene).lines)


def test_point_of_1000_lm_has_79_577_cd_and_as_many_lux_at_1_m():
    reading = readings.read_point("LUMINOUS_FLUX", 1000.0)
    assert reading.intensity == pytest.approx(79.57747, rel=1e-6)
    assert reading.illuminance == pytest.approx(79.57747, rel=1e-6)
    assert reading.luminance is None


def test_sphere_of_1000_lm_has_the_luminance_of_its_intensity_over_its_disk():
    reading = readings.read_point("LUMINOUS_FLUX", 1000.0, radius=0.1)
    assert reading.luminance == pytest.approx(1000.0 / (4.0 * math.pi) / (math.pi * 0.01))
    assert readings.read_point("LUMINANCE", reading.luminance, 0.1).flux == pytest.approx(1000.0)


def test_area_of_1_square_metre_and_1000_lm_has_318_31_cd_per_square_metre():
    reading = readings.read_area("LUMINOUS_FLUX", 1000.0, 1.0)
    assert reading.luminance == pytest.approx(318.30989, rel=1e-6)
    assert reading.intensity == pytest.approx(318.30989, rel=1e-6)


def test_narrow_spread_keeps_the_flux_and_raises_the_axis():
    reading = readings.read_area("LUMINOUS_FLUX", 1000.0, 1.0, spread=math.pi / 2)
    assert reading.flux == pytest.approx(1000.0)
    assert reading.luminance == pytest.approx(1000.0 / math.pi / (1.0 - math.pi / 4.0))


def test_hard_spot_of_120_degrees_sends_its_flux_into_pi_steradians():
    reading = readings.read_spot("LUMINOUS_FLUX", 1000.0, math.radians(60.0), 0.0)
    assert reading.intensity == pytest.approx(1000.0 / math.pi)
    assert readings.read_spot("ILLUMINANCE", 10.0, math.radians(60.0), 0.0).flux == pytest.approx(
        10.0 * math.pi
    )


def test_sun_of_100000_lx_has_a_luminance_of_1_5e9():
    reading = readings.read_sun("ILLUMINANCE", 1e5, math.radians(0.526))
    expected = 1e5 / (math.pi * math.sin(math.radians(0.263)) ** 2)
    assert reading.luminance == pytest.approx(expected)
    assert readings.read_sun(
        "LUMINANCE", expected, math.radians(0.526)
    ).illuminance == pytest.approx(1e5)
    assert reading.flux is None


@pytest.mark.parametrize("quantity", ["LUMINOUS_FLUX", "LUMINOUS_INTENSITY", "ILLUMINANCE"])
def test_every_quantity_leads_back_to_itself(quantity):
    field = {"LUMINOUS_FLUX": "flux", "LUMINOUS_INTENSITY": "intensity"}.get(
        quantity, "illuminance"
    )
    for reading in (
        readings.read_point(quantity, 7.0, 0.2),
        readings.read_spot(quantity, 7.0, 0.5, 0.3),
        readings.read_area(quantity, 7.0, 0.3, 2.0),
    ):
        assert getattr(reading, field) == pytest.approx(7.0)


def test_lines_of_a_point_light_are_rounded_to_three_digits():
    lines = lines_of(lamp("POINT", "LUMINOUS_FLUX", shadow_soft_size=0.0))
    assert lines == {
        "Luminous flux": "1\u2009000 lm",
        "Axial intensity": "79.6 cd",
        "At 1 m on the axis": "79.6 lx",
    }


def test_scale_of_the_object_and_length_of_the_unit_change_the_area():
    source = lamp("AREA", "LUMINOUS_FLUX", shape="RECTANGLE", size=1.0, size_y=1.0)
    source.scale = (2.0, 3.0, 1.0)
    bpy.context.scene.unit_settings.scale_length = 0.5
    bpy.context.view_layer.update()
    assert lines_of(source)["Luminance"] == "212 cd/m²"


def test_blender_watts_of_white_are_worth_the_efficacy_of_the_scene():
    source = lamp("AREA", energy=10.0)
    assert lines_of(source)["Luminous flux"] == "1\u2009778 lm"
    bpy.context.scene.lumenray.efficacy = 100.0
    assert lines_of(source)["Luminous flux"] == "1\u2009000 lm"


def test_watts_of_a_named_spectrum_become_lumens():
    source = lamp("POINT", "RADIANT_FLUX", 10.0)
    source.data.lumenray.illuminant = "E"
    flux = float(lines_of(source)["Luminous flux"].split(" ")[0].replace("\u2009", ""))
    # 683.002 lm/W times the integral of V over the 471 nm of equal energy.
    assert flux == pytest.approx(10.0 * 683.002 * 106.857 / 471.0, abs=1.0)


def test_quantity_without_a_meaning_is_a_problem_that_names_the_way_out():
    said = readout.describe_lamp(lamp("SUN", "LUMINOUS_FLUX"), bpy.context.scene)
    assert not said.lines
    assert "sun" in said.problem
    assert "lx" in said.problem


def test_watts_of_a_coloured_light_are_not_guessed():
    source = lamp("POINT", "RADIANT_FLUX", 10.0, color=(1.0, 0.2, 0.1))
    source.data.lumenray.spectrum = "RGB"
    said = readout.describe_lamp(source, bpy.context.scene)
    assert not said.lines
    assert said.problem == readout.NEEDS_THE_ENGINE


@pytest.mark.parametrize("kind", ["POINT", "TUBE", "SPOT", "AREA", "SUN"])
@pytest.mark.parametrize("physical", [False, True])
def test_readings_agree_with_the_light_that_the_engine_is_given(kind, physical):
    quantity = "ILLUMINANCE" if kind == "SUN" else "LUMINOUS_FLUX"
    blender_kind = "POINT" if kind == "TUBE" else kind
    stated = quantity if physical else None
    source = lamp(blender_kind, stated, 321.0, color=(1.0, 0.5, 0.25), energy=12.0)
    if kind == "TUBE":
        source.data.lumenray.tube_length, source.data.shadow_soft_size = 1.5, 0.02
    source.scale = (1.5, 0.5, 2.0)
    bpy.context.view_layer.update()
    settings = bpy.context.scene.lumenray
    made = convert_light(
        source, "id", "Lamp", source.matrix_world, 1.0, settings.efficacy, ConversionReport()
    )
    given = made.output.quantity
    value = made.output.value
    match kind:
        case "POINT":
            expected = readings.read_point(given.name, value, made.radius)
        case "TUBE":
            expected = readings.read_line(given.name, value, made.length, made.radius)
        case "SPOT":
            # An ellipse of light, as the scale makes it.
            on_axis = float(intensity(made.distribution, np.array([0.0, 0.0, -1.0])))
            on_axis *= value / flux(made.distribution)
            expected = readings.Reading(value, on_axis, on_axis, None)
        case "AREA":
            assert made.shape == "rectangle"
            area = made.size_x * made.size_y
            expected = readings.read_area(given.name, value, area, made.spread)
        case "SUN":
            assert given is Quantity.ILLUMINANCE
            expected = readings.read_sun(given.name, value, made.angle)
    shown = [
        readout.format_number(amount)
        for amount in (expected.flux, expected.intensity, expected.illuminance, expected.luminance)
        if amount is not None
    ]
    assert [text.split(" ")[0] for text in lines_of(source).values()] == shown


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (0.01234, "0.0123"),
        (9.999, "10.0"),
        (99.96, "100"),
        (123.4, "123"),
        (1234.5, "1\u2009234"),
        (123456.0, "123\u2009456"),
        (1.5e9, "1.50e+09"),
        (2e-5, "2.00e-05"),
    ],
)
def test_numbers_are_written_for_people(value, text):
    assert readout.format_number(value) == text


def test_ev100_of_8_says_its_white():
    settings = bpy.context.scene.lumenray
    settings.exposure = "EV100"
    settings.ev100 = 8.0
    assert readout.describe_exposure(settings) == "307 cd/m² becomes 1.0"


def test_text_is_broken_to_the_width_of_the_region():
    text = "the engine's libraries could not be loaded on this computer"
    lines = readout.wrap(text, 200)
    assert len(lines) > 1
    assert " ".join(lines) == text
    assert readout.wrap("", 200) == [""]
    assert np.all([len(line) <= 30 for line in lines])


def test_unit_of_the_value_follows_quantity_and_kind():
    assert readout.value_unit(lamp("AREA", "LUMINANCE").data) == "cd/m²"
    assert readout.value_unit(lamp("POINT", "RADIANT_FLUX").data) == "W"
    assert readout.value_unit(lamp("SUN", "RADIANT_FLUX").data) == "W/m²"


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (312.34, 1.249, "312.3 ± 1.2"),
        (1512.3, 61.0, "1\u2009512 ± 61"),
        (0.5123, 0.0042, "0.5123 ± 0.0042"),
        (500.0, 0.0, "500"),
    ],
)
def test_estimates_end_at_the_second_digit_of_their_error(value, error, text):
    assert readout.format_estimate(value, error) == text
