"""Sliders of baked light as levels of the groups whose maps are mixed."""

import bpy
import pytest

from lumenray.blender_addon.bake import mixing
from lumenray.engine.errors import SceneError

pytestmark = pytest.mark.usefixtures("extension")


def test_sliders_are_the_levels_of_their_groups():
    """Names are those of files; groups that share the slider of others go by that one."""
    look = bpy.context.scene.lumenray.look
    for name, strength in (("Ceiling lamps", 0.5), ("Others", 0.25)):
        row = look.layers.add()
        row.name, row.strength = name, strength
    levels = mixing.levels_of(look, ["Ceiling_lamps", "desk", "rest"])
    assert levels.level("Ceiling_lamps").flux == 0.5
    assert levels.level("desk").flux == levels.level("rest").flux == 0.25
    look.layers.remove(1)
    assert mixing.levels_of(look, ["Ceiling_lamps", "desk"]).level("desk").flux == 1.0


def test_without_a_bake_there_is_nothing_to_mix():
    with pytest.raises(SceneError, match="bake again with layers"):
        mixing.write_mix(bpy.context.scene)
