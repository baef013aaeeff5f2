"""Units of settings: per cent, lengths of the scene, and those of no scene."""

import bpy
import pytest
from panels import new_light

from lumenray.blender_addon import preferences, properties
from lumenray.blender_addon.bake.settings import LumenrayBakeSettings
from lumenray.blender_addon.foundation.units import format_lengths


def test_errors_are_shown_in_per_cent_and_kept_as_shares():
    own = bpy.context.scene.lumenray
    for settings in (own.render, own.bake):
        settings.error = 0.02
        assert settings.error_percent == pytest.approx(2.0)
        settings.error_percent = 0.5
        assert settings.error == pytest.approx(0.005)
        assert settings.bl_rna.properties["error_percent"].subtype == "PERCENTAGE"


def test_lengths_follow_the_units_of_the_scene():
    units = bpy.context.scene.unit_settings
    light = new_light("POINT").light
    settings = light.lumenray.rayset
    settings.width_position = 2.0
    assert settings.position_spread == pytest.approx(0.002)
    units.scale_length = 0.01
    assert settings.position_spread == pytest.approx(0.2)
    settings.position_spread = 0.1
    assert settings.width_position == pytest.approx(1.0)
    assert settings.bl_rna.properties["position_spread"].subtype == "DISTANCE"
    assert format_lengths([0.0254, 0.508]) == "25.4 × 508 mm"
    units.system = "IMPERIAL"
    assert format_lengths([0.0254, 0.508]) == "1 × 20 in"
    assert format_lengths([3.048]) == "10 ft"


def test_settings_that_do_not_follow_the_units_of_the_scene_say_so():
    """Preferences are of no scene, and densities are compared between scenes, in files and on the command line."""
    scene, item = LumenrayBakeSettings, properties.LumenrayObjectSettings
    own = preferences.LumenrayPreferences
    for group, name in ((own, "solid_radius"), (scene, "density"), (item, "density")):
        setting = group.bl_rna.properties[name]
        assert "metre" in setting.description
        assert "whatever the units of the scene" in setting.description
        # Blender shows lengths by the units and the scale of the open scene.
        assert setting.subtype == "NONE"
