"""What 3D views show of sensors: made anew after changes alone, and numbers that do not cover each other."""

import types

import bpy
import numpy as np
import pytest

from lumenray.blender_addon.sensors.readings import Readings, write_readings
from lumenray.ui import sensor_overlay

pytestmark = pytest.mark.usefixtures("extension")


def new_readings(shape=(2, 3)):
    """Readings of a grid of 1 m cells at the origin: 100, 200, … lx."""
    rows, columns = shape
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    plane = np.stack([x.ravel(), y.ravel()], axis=1).astype(np.float32)
    places = np.column_stack([plane, np.zeros(len(plane))]).astype(np.float32)
    values = 100.0 * (1.0 + np.arange(len(plane), dtype=np.float32))[None]
    normals = np.tile(np.float32([0, 0, 1]), (len(plane), 1))
    return Readings(
        "PLANAR", places, normals, np.eye(4, dtype=np.float32), plane, np.arange(len(plane), dtype=np.int32), shape, ("",),
        values, 0.01 * values, 64, 0, "", "paths", "",
    )  # fmt: skip


def new_sensor():
    empty = bpy.data.objects.new("Sensors", None)
    empty.lumenray.sensor.is_sensor = True
    empty.lumenray.sensor.kept, empty.lumenray.sensor.serial = write_readings(new_readings()), "1"
    bpy.context.scene.collection.objects.link(empty)
    bpy.context.view_layer.update()
    return empty


def where():
    return types.SimpleNamespace(scene=bpy.context.scene, view_layer=bpy.context.view_layer)


def test_a_view_is_made_anew_after_changes_alone():
    empty = new_sensor()
    sensor_overlay.forget()
    first = sensor_overlay.drawing_of(where())
    assert len(first.corners) == 24
    assert sensor_overlay.drawing_of(where()) is first
    empty.lumenray.sensor.show_values = False
    second = sensor_overlay.drawing_of(where())
    assert second is not first
    assert len(second.labels) < len(first.labels)
    bpy.context.scene.lumenray.sensors.automatic = False
    bpy.context.scene.lumenray.sensors.high = 2000.0
    assert sensor_overlay.drawing_of(where()).scale.high == 2000.0
    empty.hide_set(True)
    assert not len(sensor_overlay.drawing_of(where()).corners)


def test_numbers_that_share_no_square_do_not_overlap():
    rng = np.random.default_rng(1)
    low = rng.uniform(0, 200, (60, 2))
    boxes = np.column_stack([low, low + rng.uniform(5, 60, (60, 2))])
    covered = [sensor_overlay.cover(box) for box in boxes]
    for k, one in enumerate(boxes):
        for m, other in enumerate(boxes[:k]):
            overlaps = (one[:2] < other[2:]).all() and (other[:2] < one[2:]).all()
            if overlaps:
                assert not covered[k].isdisjoint(covered[m])
