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


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("CIE", {"type", "level", "illuminance"}),
        ("CLOUDINESS", {"cloudiness", "level", "illuminance", "use_place", "elevation"}),
        ("WEATHER", {"weather_file", "weather_mean", "use_file_level"}),
        ("MEASURED", {"measured_text", "measured_file", "use_file_level"}),
    ],
)
def test_every_kind_of_sky_shows_what_belongs_to_it(world, kind, names):
    world.lumenray.sky.kind = kind
    seen = set(draw("LUMENRAY_PT_world_sky", context(world=world)))
    assert names | {"kind", "colour_temperature", "ground_reflectance"} <= seen
    own = {"type", "cloudiness", "weather_file", "measured_file"}
    assert own & seen == own & names
    if kind in {"WEATHER", "MEASURED"}:
        assert "level" not in seen
        world.lumenray.sky.use_file_level = False
        world.lumenray.sky.level = "ZENITH"
        seen = set(draw("LUMENRAY_PT_world_sky", context(world=world)))
        assert {"level", "zenith_luminance"} <= seen
        assert any("is chosen" in text for text in seen)


def test_a_clear_skys_spectrum_asks_for_the_air(world):
    sky = world.lumenray.sky
    sky.type, sky.elevation = "12", 0.5
    seen = set(draw("LUMENRAY_PT_world_sky", context(world=world)))
    assert {"spectrum", "colour_temperature"} <= seen
    sky.spectrum, sky.level = "CLEAR", "MODEL"
    seen = set(draw("LUMENRAY_PT_world_sky", context(world=world)))
    assert "turbidity" in seen
    assert not {"colour_temperature", "illuminance"} & seen


def test_a_mean_of_hours_asks_for_them(world):
    sky = world.lumenray.sky
    sky.kind = "WEATHER"
    names = {"mean_first_month", "mean_last_month", "mean_start", "mean_end", "use_mean_sun"}
    assert not names & set(draw("LUMENRAY_PT_world_sky", context(world=world)))
    sky.weather_mean = "RANGE"
    assert names <= set(draw("LUMENRAY_PT_world_sky", context(world=world)))


def test_the_panel_of_place_and_time_says_what_the_clock_means(world):
    where = context(world=world)
    time = world.lumenray.time
    time.month, time.hour = 6, 13.0
    seen = draw("LUMENRAY_PT_world_place", where)
    assert {"city", "zone", "north", "hour", "use_refraction", "is_shown"} <= set(seen)
    assert "radius" not in seen
    assert {"13:00", "UTC+02:00", "Sun's Elevation", "Sunrise"} <= set(seen)
    time.hour = 2.0
    world.lumenray.arc.is_shown = True
    seen = draw("LUMENRAY_PT_world_place", where)
    assert "radius" in seen
    assert "The sun is below the horizon" in seen
    world.lumenray.place.zone = "Moon/Base"
    assert any("Moon/Base" in text for text in draw("LUMENRAY_PT_world_place", where))


def test_a_sun_is_added_described_and_let_go(world):
    where = context(world=world)
    assert draw("LUMENRAY_PT_world_sun", where) == ["lumenray.add_sun"]
    bpy.ops.lumenray.add_sun()
    assert bpy.data.objects["Sun"] == world.lumenray.sun.lamp
    seen = draw("LUMENRAY_PT_world_sun", where)
    assert {"lamp", "amount", "turbidity", "Facing the Sun"} <= set(seen)
    world.lumenray.sun.amount = "WEATHER"
    assert any("sky is of none" in text for text in draw("LUMENRAY_PT_world_sun", where))
    world.lumenray.sun.lamp = None
    assert "Sun" in bpy.data.objects
    # A selected Sun light is taken.
    mine = add_sun("Mine")
    mine.select_set(True)
    bpy.ops.lumenray.add_sun()
    assert world.lumenray.sun.lamp == mine
    assert len([thing for thing in bpy.data.objects if thing.type == "LIGHT"]) == 2


def test_a_sun_needs_a_world(world):
    bpy.context.scene.world = None
    assert not bpy.ops.lumenray.add_sun.poll()


def test_a_study_shows_its_frames(world):
    where = context(world=world)
    assert draw("LUMENRAY_PT_world_study", where) == ["follows_frames", "use_note"]
    world.lumenray.time.follows_frames = True
    assert "minutes_per_frame" in draw("LUMENRAY_PT_world_study", where)


@needs_cycles
def test_a_portal_states_no_amount_of_light(world):
    portal = add_portal()
    where = context(light=portal.data, object=portal)
    assert {"is_portal", "size"} <= set(draw("LUMENRAY_PT_light", where))
    assert draw("LUMENRAY_PT_light_photometry", where) is None
    assert "energy" not in draw("LUMENRAY_PT_active_light", where)


def test_every_setting_has_a_tooltip(world):
    own = world.lumenray
    groups = ("sky", "place", "time", "sun", "arc", "environment", "ground")
    for group in (own, *(getattr(own, name) for name in groups)):
        for entry in group.bl_rna.properties:
            if entry.identifier in {"rna_type", "name", *groups} or entry.is_hidden:
                continue
            assert entry.description, entry.identifier
            if entry.type == "ENUM":
                assert all(item.description for item in entry.enum_items), entry.identifier
