"""Readings of sensors: measured, kept with their empties, mixed by light group, and out of date when the scene changes."""

from dataclasses import fields

import bpy
import numpy as np
import pytest
from blender_bakes import add_lamp
from blender_objects import add_quad, new_paint
from mathutils import Matrix

from lumenray.blender_addon.sensors import asked, drawing, files, pictures, results, words
from lumenray.blender_addon.sensors.readings import read_readings, readings_of, write_readings
from lumenray.blender_addon.sensors.settings import find_sensors
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.light_mix import Level, LightMix
from lumenray.engine.scene.provenance import Provenance

pytestmark = pytest.mark.usefixtures("extension")

INTENSITY = 1000.0 / (4.0 * np.pi)
"""Of lamps of 1000 lm. [cd]"""


def new_sensor(layout="POINT", quantity="PLANAR", place=(0.0, 0.0, 0.0), **settings):
    empty = bpy.data.objects.new("Sensors", None)
    empty.location = place
    own = empty.lumenray.sensor
    own.is_sensor, own.layout, own.quantity = True, layout, quantity
    for name, value in settings.items():
        setattr(own, name, value)
    bpy.context.scene.collection.objects.link(empty)
    bpy.context.view_layer.update()
    return empty


def measure(rule=None):
    from lumenray.engine.session import Session

    bpy.context.view_layer.update()
    job, _ = asked.prepare(
        bpy.context.evaluated_depsgraph_get(), rule=rule or StopRule(samples=256)
    )
    job.run(Session())
    return job, results.store(job)


@pytest.fixture
def measured(monkeypatch):
    """A grid whose readings were made up: what is kept of them is not the engine's."""

    class Fake:
        def apply(self, delta):
            pass

        def measure(self, positions, normals, rule, seed, transport, progress, **_):
            from types import SimpleNamespace

            values = 100.0 + 50.0 * positions[:, 0]
            origin = Provenance("0", "mono", "", seed, 16, 1.0)
            return SimpleNamespace(
                illuminance=values,
                standard_error=0.01 * values,
                provenance=origin,
                method="fake",
                has_common_errors=False,
            )

    add_lamp("Lamp")
    empty = new_sensor("GRID", length=2.0, width=1.0, place=(1.0, 0.5, 0.0))
    bpy.context.view_layer.update()
    job, _ = asked.prepare(bpy.context.evaluated_depsgraph_get())
    job.run(Fake())
    results.store(job)
    return empty


@pytest.mark.mitsuba
def test_every_kind_of_illuminance_of_a_lamp_is_that_of_its_closed_form():
    """A lamp 2 m up, sensors 1.5 m beside it that look at its foot."""
    add_lamp("Lamp")
    for quantity in ("PLANAR", "VERTICAL", "CYLINDRICAL", "SEMICYLINDRICAL", "SPHERICAL"):
        new_sensor(quantity=quantity, place=(-1.5, 0.0, 0.0)).name = quantity
    square, beside = 1.5**2 + 2.0**2, 1.5
    sine, cosine = beside / np.sqrt(square), 2.0 / np.sqrt(square)
    expected = {
        "PLANAR": INTENSITY * cosine / square,
        "VERTICAL": INTENSITY * sine / square,
        "CYLINDRICAL": INTENSITY * sine / (np.pi * square),
        # (1 + cos alpha) sin gamma / pi, with the lamp straight ahead.
        "SEMICYLINDRICAL": INTENSITY * 2.0 * sine / (np.pi * square),
        "SPHERICAL": INTENSITY / (4.0 * square),
    }
    _, empties = measure(StopRule(samples=4096))
    for empty in empties:
        values, errors = readings_of(empty).mixed()
        assert abs(values[0] - expected[empty.name]) < 4.0 * errors[0] + 1e-4 * values[0]
        assert errors[0] < 0.01 * values[0]


@pytest.mark.mitsuba
def test_a_luminance_meter_reads_a_matt_floor():
    """A floor that reflects 60, 30 and 10 % of white lamps' colours, 2 m below one: L = rho E / pi."""
    floor = add_quad("Floor", material=new_paint())
    floor.scale, floor.location = (6.0, 6.0, 1.0), (-3.0, -3.0, 0.0)
    add_lamp("Lamp")
    empty = new_sensor(quantity="LUMINANCE", place=(-1.0, 0.0, 1.0))
    # X looks at the foot of the lamp.
    empty.rotation_euler.y = np.radians(45.0)
    _, (empty,) = measure(StopRule(each=0.01, floor=0.1))
    readings = readings_of(empty)
    values, errors = readings.mixed()
    reflectance = 0.2126 * 0.6 + 0.7152 * 0.3 + 0.0722 * 0.1
    exact = reflectance * INTENSITY / 4.0 / np.pi
    assert readings.unit == "cd/m²"
    assert values[0] == pytest.approx(exact, rel=0.03)
    assert errors[0] < 0.011 * values[0]
    assert dict(words.describe(empty))["value"].endswith("cd/m²")
    assert drawing.make_drawing(bpy.context.scene).labels[0].text.endswith("cd/m²")


@pytest.mark.mitsuba
def test_light_groups_add_up_and_are_mixed_without_measuring_again():
    floor = add_quad("Floor", material=new_paint())
    floor.scale, floor.location = (6.0, 6.0, 1.0), (-3.0, -3.0, 0.0)
    add_lamp("A", "Near")
    add_lamp("B", "Far", 500.0).location = (2.0, 2.0, 1.0)
    empty = new_sensor(
        "GRID", length=2.0, width=2.0, use_spacing=True, spacing=1.0, place=(0, 0, 0.5)
    )
    measure(StopRule(each=0.01, floor=0.1))
    together, errors = readings_of(empty).mixed()
    bpy.context.scene.lumenray.light_mix.groups = "GROUPS"
    measure(StopRule(each=0.01, floor=0.1))
    readings = readings_of(empty)
    assert readings.groups == ("Far", "Near")
    total, total_errors = readings.mixed()
    assert (np.abs(total - together) < 4.0 * np.hypot(errors, total_errors)).all()
    assert (total_errors <= 0.0105 * total).all()
    half = LightMix((Level("Near", 0.5), Level("Far", is_on=False)))
    values, noise = readings.mixed(half)
    np.testing.assert_allclose(values, 0.5 * readings.values[1], rtol=1e-6)
    np.testing.assert_allclose(noise, 0.5 * readings.errors[1], rtol=1e-6)
    # By the settings of the scene, which panels and views follow.
    row = bpy.context.scene.lumenray.light_mix.rows.add()
    row.name, row.is_on = "Far", False
    shown = drawing.make_drawing(bpy.context.scene)
    told = [float(label.text.partition(" ")[0]) for label in shown.labels if not label.is_line]
    np.testing.assert_allclose(told, readings.values[1], rtol=0.01)


def test_readings_are_kept_as_they_are(measured):
    readings = readings_of(measured)
    again = read_readings(write_readings(readings))
    for name in (entry.name for entry in fields(readings)):
        value = getattr(readings, name)
        if isinstance(value, np.ndarray):
            np.testing.assert_array_equal(value, getattr(again, name))
        else:
            assert value == getattr(again, name)


@pytest.mark.parametrize("text", ["", "nonsense", "0000000000"])
def test_damaged_readings_are_none(text):
    assert read_readings(text) is None


def test_readings_are_saved_with_the_file_and_are_current_when_it_is_opened(measured, tmp_path):
    before = readings_of(measured).values
    path = str(tmp_path / "room.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    (empty,) = find_sensors(bpy.context.scene)
    np.testing.assert_array_equal(readings_of(empty).values, before)
    assert not results.is_outdated(empty)
    bpy.data.objects["Lamp"].location.x = 3.0
    bpy.context.view_layer.update()
    assert results.why_outdated(empty) == "Lamp"


def test_a_moved_lamp_makes_readings_out_of_date_and_they_are_drawn_grey(measured):
    assert not results.is_outdated(measured)
    coloured = drawing.make_drawing(bpy.context.scene).fills
    assert np.ptp(coloured[:, :3], axis=1).max() > 0.1
    bpy.data.objects["Lamp"].location.x = 3.0
    bpy.context.view_layer.update()
    assert results.why_outdated(measured) == "Lamp"
    grey = drawing.make_drawing(bpy.context.scene).fills
    assert np.ptp(grey[:, :3], axis=1).max() == 0.0
    assert dict(words.describe(measured))["out of date"] == "changed since: Lamp"


def test_a_moved_sensor_is_out_of_date_alone(measured):
    other = new_sensor()
    bpy.context.view_layer.update()
    other.location.x = 2.0
    bpy.context.view_layer.update()
    assert not results.is_outdated(measured)
    measured.location.x += 0.5
    bpy.context.view_layer.update()
    assert results.is_outdated(measured)
    measured.location.x -= 0.5
    bpy.context.view_layer.update()
    assert not results.is_outdated(measured)


def test_moving_sensors_leaves_lux_maps_current(measured, fake_engine, tmp_path):
    from blender_bakes import bake_all, baked

    add_quad("Floor", material=new_paint())
    bake_all(tmp_path)
    measured.location.x += 0.5
    assert baked().changed == ""


def test_cells_fill_a_grid_and_lines_lie_where_the_field_has_their_value(measured):
    shown = drawing.make_drawing(bpy.context.scene)
    readings = readings_of(measured)
    corners = shown.corners.reshape(-1, 4, 3)
    np.testing.assert_allclose(corners.mean(axis=1), readings.positions, atol=1e-5)
    sides = np.ptp(corners, axis=1)[:, :2]
    assert sides.prod(axis=1).sum() == pytest.approx(2.0, rel=1e-4)
    levels = [float(label.text) for label in shown.labels if label.is_line]
    assert levels
    fields = 100.0 + 50.0 * shown.lines[:, 0]
    away = np.abs(fields[:, None] - levels).min(axis=1)
    assert away.max() < 0.01
    # "125.0 ±1": value and error of each sensor.
    assert sum("±" in label.text for label in shown.labels) == len(readings.positions)


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (512.34, 3.2, "512 ±3"),
        (7.9018, 0.0061, "7.902 ±0.006"),
        (100.0, 0.0, "100"),
        (1234.5, 40.0, "1234 ±40"),
    ],
)
def test_readings_are_told_to_the_first_digit_of_their_error(value, error, text):
    assert drawing.format_reading(value, error) == text


def test_plans_become_images_and_files(measured, tmp_path):
    bpy.ops.lumenray.show_sensor_plans()
    image = bpy.data.images["Plan Sensors"]
    assert image.packed_file
    plan = pictures.draw_plan("Sensors", readings_of(measured))
    paths = pictures.write_plans(tmp_path, [("Sensors", plan)])
    assert [path.suffix for path in paths] == [".png", ".svg"]
    assert "U0" in paths[1].read_text()


def test_files_tell_figures_and_readings(measured, tmp_path):
    import csv
    import json

    readings = readings_of(measured)
    named = [("Desk, left", readings)]
    files.write_rows(tmp_path / "a.csv", named, LightMix(), ["note: a remark"])
    lines = (tmp_path / "a.csv").read_text().splitlines()
    assert lines[0] == "# note: a remark"
    rows = list(csv.DictReader(lines[1:]))
    assert len(rows) == len(readings.positions)
    assert rows[0]["object"] == "Desk, left"
    assert float(rows[-1]["value"]) == pytest.approx(100.0 + 50.0 * float(rows[-1]["x"]), rel=1e-5)
    files.write_document(tmp_path / "a.json", "room.blend", named, LightMix())
    content = json.loads((tmp_path / "a.json").read_text())
    assert content["sensors"][0]["uniformity_u0"] == pytest.approx(
        readings.values.min() / readings.values.mean(), rel=1e-5
    )
    assert content["sensors"][0]["minimum_range"][0] < content["sensors"][0]["minimum"]


def test_without_sensors_there_is_nothing_to_measure():
    with pytest.raises(SceneError, match="no sensors stand in the scene"):
        asked.prepare(bpy.context.evaluated_depsgraph_get())


def test_a_copy_keeps_readings_where_they_were_measured_and_is_out_of_date_when_moved(measured):
    copy = measured.copy()
    bpy.context.scene.collection.objects.link(copy)
    bpy.context.view_layer.update()
    assert not results.is_outdated(copy)
    copy.matrix_world = Matrix.Translation((5.0, 0.0, 0.0))
    bpy.context.view_layer.update()
    assert results.is_outdated(copy)
    assert not results.is_outdated(measured)


def test_what_is_left_out_of_all_light_groups_does_not_cancel_in_their_sum():
    """Samples of groups are independent; a simplification is wrong in all of them alike."""
    from kept_readings import LUX, NOISE, measure, new_room, set_sliders

    empty = new_room(requirement="")
    measure(noise=NOISE, simplified=0.02)
    readings, total = readings_of(empty), sum(LUX.values())
    assert readings.simplified == 0.02
    values, errors = readings.mixed()
    np.testing.assert_allclose(values, total, rtol=0.1)
    noise = NOISE * np.hypot(*LUX.values())
    np.testing.assert_allclose(errors, np.hypot(noise, 0.02 * values), rtol=0.03)
    half = LightMix((Level("Desk", 0.0),))
    values, errors = readings.mixed(half)
    np.testing.assert_allclose(errors, np.hypot(NOISE, 0.02) * LUX["Ceiling"], rtol=1e-3)
    # The mean of sensors is wrong by as much.
    assert readings.mean_error() >= 0.02
    set_sliders()
    told = dict(words.describe(empty))["error of the mean"]
    assert told.startswith("sampling and the rest 0.")
    assert told.endswith("simplifications at most 2 %")
    assert files.describe_readings("Desk", readings, LightMix())["simplifications_at_most"] == 0.02
    measure(noise=NOISE)
    assert "error of the mean" not in dict(words.describe(empty))
