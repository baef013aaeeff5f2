"""Panels of the world with a sky, and of portals."""

import math

import bpy
import pytest
from blender_objects import needs_cycles
from blender_skies import add_portal, add_sun, new_sky, rotation_of
from panels import context, draw


@pytest.fixture
def world():
    """Return a world with a sky of the CIE."""
    return new_sky()


def test_the_panel_shows_what_counts(world):
    where = context(world=world)
    seen = draw("LUMENRAY_PT_world_sky", where)
    assert {"source", "type", "illuminance", "ground_reflectance"} <= set(seen)
    assert not {"use_sun_lamp", "elevation", "azimuth"} & set(seen)
    assert draw("LUMENRAY_PT_world_unit", where) is None
    assert draw("LUMENRAY_PT_world_surface", where) is None
    world.lumenray.sky.type = "12"
    assert {"use_sun_lamp", "elevation", "azimuth"} <= set(draw("LUMENRAY_PT_world_sky", where))
    add_sun("Noon", rotation_of(60, 180))
    bpy.context.view_layer.update()
    seen = draw("LUMENRAY_PT_world_sky", where)
    assert not {"elevation", "azimuth"} & set(seen)
    assert {"Noon", "60.0°", "180.0°"} <= set(seen)
    world.lumenray.source = "NODES"
    assert draw("LUMENRAY_PT_world_sky", where) == ["source"]
    assert draw("LUMENRAY_PT_world_unit", where)


def test_the_panel_states_the_zenith(world):
    """Moon and Spencer's sky has a horizontal illuminance of 7 pi / 9 of its zenith luminance."""
    world.lumenray.sky.illuminance = 7.0 * math.pi / 9.0 * 2000.0
    assert any(
        text.replace("\u2009", "") == "2000 cd/m²"
        for text in draw("LUMENRAY_PT_world_sky", context(world=world))
    )


@needs_cycles
def test_a_portal_states_no_amount_of_light(world):
    portal = add_portal()
    where = context(light=portal.data, object=portal)
    assert {"is_portal", "size"} <= set(draw("LUMENRAY_PT_light", where))
    assert draw("LUMENRAY_PT_light_photometry", where) is None
    assert "energy" not in draw("LUMENRAY_PT_active_light", where)


def test_every_setting_has_a_tooltip(world):
    own = world.lumenray
    groups = ("sky", "place", "time", "sun", "arc")
    for group in (own, *(getattr(own, name) for name in groups)):
        for entry in group.bl_rna.properties:
            if entry.identifier in {"rna_type", "name", *groups} or entry.is_hidden:
                continue
            assert entry.description, entry.identifier
            if entry.type == "ENUM":
                assert all(item.description for item in entry.enum_items), entry.identifier
