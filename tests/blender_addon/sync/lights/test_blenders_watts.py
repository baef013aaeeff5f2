"""Blender's own watts keep their meaning, and physical parameters take their place."""

import bpy
import numpy as np
import pytest
from blender_objects import add_light
from conversion import converted_scene, measure_light

from lumenray.engine.session import Session

pytestmark = pytest.mark.usefixtures("extension")


@pytest.mark.parametrize(
    ("kind", "settings", "watts_to_irradiance"),
    [
        ("POINT", {"shadow_soft_size": 0.0}, 1 / (4 * np.pi)),
        ("POINT", {"shadow_soft_size": 0.1}, 1 / (4 * np.pi)),
        ("SPOT", {"shadow_soft_size": 0.0, "spot_size": 1.0}, 1 / (4 * np.pi)),
        ("SUN", {"angle": 0.01}, 1.0),
        ("AREA", {"size": 0.01}, 1 / np.pi),
        ("AREA", {"size": 0.01, "shape": "DISK"}, 1 / np.pi),
    ],
    ids=str,
)
def test_plain_blender_watts_keep_their_meaning(kind, settings, watts_to_irradiance):
    add_light(kind, energy=10.0, color=(1.0, 0.5, 0.25), **settings)
    luma = 0.2126 + 0.7152 * 0.5 + 0.0722 * 0.25
    expected = 10.0 * luma * 177.83 * watts_to_irradiance
    value, error = measure_light((0, 0, 0))
    assert abs(value - expected) < 3 * error + 1e-3 * expected


def test_physical_parameters_replace_watts_and_colour_never_changes_lumens():
    light = add_light("POINT", energy=1.0, color=(1.0, 0.1, 0.1), shadow_soft_size=0.0)
    light.data.lumenray.use_physical = True
    light.data.lumenray.quantity = "LUMINOUS_FLUX"
    light.data.lumenray.value = 100.0
    value, error = measure_light((0, 0, 0))
    assert abs(value - 100 / (4 * np.pi)) < 3 * error + 0.003


def test_scene_units_scale_distances():
    add_light("POINT", location=(0, 0, 100), energy=10.0, shadow_soft_size=0.0)
    settings = bpy.context.scene.unit_settings
    settings.system, settings.scale_length = "METRIC", 0.01
    value, _ = measure_light((0, 0, 0))
    assert value == pytest.approx(10.0 * 177.83 / (4 * np.pi), rel=1e-3)


def test_object_scale_enlarges_area_lights():
    light = add_light("AREA", location=(0, 0, 0.5), energy=10.0, size=1.0)
    light.scale = (2.0, 2.0, 2.0)
    session = Session(witness=False)
    session.apply(converted_scene().delta)
    area = next(iter(session.scene.lights.values()))
    assert area.size_x == pytest.approx(2.0)


def test_a_quantity_that_does_not_fit_the_light_is_reported():
    light = add_light("SUN")
    light.data.lumenray.use_physical = True
    light.data.lumenray.quantity = "LUMINOUS_FLUX"
    made = converted_scene()
    assert any("not defined for a sun" in row.message for row, _ in made.report.rows)
