"""Operators of sensors: they are added, measured in the engine's process, and forgotten."""

import time

import bpy
import numpy as np
import pytest
from blender_bakes import add_lamp
from blender_objects import add_quad, new_paint
from panels import context, draw

from lumenray.blender_addon.sensors import refresh, results, running
from lumenray.blender_addon.sensors.readings import readings_of
from lumenray.blender_addon.sensors.settings import find_sensors
from lumenray.ui import add_menu

pytestmark = pytest.mark.usefixtures("extension")


@pytest.fixture
def floor():
    """A floor of 4 m by 3 m under a lamp of 1000 lm, which is active."""
    floor = add_quad("Floor", material=new_paint())
    floor.scale = (4.0, 3.0, 1.0)
    add_lamp("Lamp").location = (2.0, 1.5, 2.5)
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = floor
    return floor


@pytest.mark.mitsuba
def test_sensors_over_a_floor_are_measured_in_the_engines_process(floor):
    assert bpy.ops.lumenray.add_sensors(layout="FLOOR", height=0.75) == {"FINISHED"}
    (empty,) = find_sensors(bpy.context.scene)
    assert bpy.context.object == empty
    assert draw("LUMENRAY_PT_sensors", context(scene=bpy.context.scene)).count("not measured") == 1
    assert bpy.ops.lumenray.measure_sensors() == {"FINISHED"}
    readings = readings_of(empty)
    values, errors = readings.mixed()
    away = readings.positions - np.array([2.0, 1.5, 2.5])
    square = (away**2).sum(axis=1)
    # What lies below gives no light to what looks up.
    exact = 1000.0 / (4.0 * np.pi) * -away[:, 2] / square**1.5
    assert (np.abs(values - exact) < 4.0 * errors + 1e-4 * exact).all()
    seen = draw("LUMENRAY_PT_active_sensors", context(object=empty))
    assert {"layout", "surface", "Uniformity U0", "35"} <= set(seen)
    assert bpy.ops.lumenray.show_sensor_plans() == {"FINISHED"}
    assert bpy.ops.lumenray.forget_readings() == {"FINISHED"}
    assert readings_of(empty) is None


def test_every_entry_of_the_menu_adds_sensors(floor):
    for _, layout, quantity, height in add_menu.SENSORS:
        bpy.context.view_layer.objects.active = floor
        assert bpy.ops.lumenray.add_sensors(layout=layout, quantity=quantity, height=height) == {
            "FINISHED"
        }
    found = find_sensors(bpy.context.scene)
    assert len(found) == len(add_menu.SENSORS)
    for empty in found:
        assert draw("LUMENRAY_PT_active_sensors", context(object=empty))


def test_what_is_missing_is_said(floor):
    with pytest.raises(RuntimeError, match=r"No sensors stand|poll"):
        bpy.ops.lumenray.measure_sensors()
    bpy.context.view_layer.objects.active = bpy.data.objects["Lamp"]
    with pytest.raises(RuntimeError, match="no mesh is active"):
        bpy.ops.lumenray.add_sensors(layout="FLOOR")
    bpy.ops.object.select_all(action="DESELECT")
    with pytest.raises(RuntimeError, match="no mesh is selected"):
        bpy.ops.lumenray.add_room_sensors()
    empty = bpy.data.objects.new("Plain", None)
    bpy.context.scene.collection.objects.link(empty)
    assert "This empty stands for no sensors" in draw(
        "LUMENRAY_PT_active_sensors", context(object=empty)
    )


@pytest.mark.mitsuba
def test_what_is_out_of_date_is_measured_again_by_itself_where_that_is_asked_for(floor):
    """What Blender's timers do, which do not run without a window."""
    bpy.context.scene.lumenray.sensors.time = 20.0
    bpy.ops.lumenray.add_sensors(layout="FLOOR")
    (empty,) = find_sensors(bpy.context.scene)
    bpy.ops.lumenray.measure_sensors()
    before = readings_of(empty).values.copy()
    refresh.begin(bpy.context)
    assert not running.is_running()
    bpy.data.objects["Lamp"].location.z = 1.5
    bpy.context.view_layer.update()
    assert results.is_outdated(empty)
    refresh.begin(bpy.context)
    assert running.is_running()
    end = time.monotonic() + 120.0
    while refresh._work() is not None:
        assert time.monotonic() < end
        time.sleep(0.05)
    assert not results.is_outdated(empty)
    assert not running.is_running()
    assert readings_of(empty).values.mean() > 1.5 * before.mean()
