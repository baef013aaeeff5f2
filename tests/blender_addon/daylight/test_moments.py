"""Place and time in a world: the moment that they state at a frame, and where the sun stands then."""

import math
from datetime import UTC, datetime

import bpy
import numpy as np
import pytest
from blender_skies import new_sky

from lumenray.blender_addon.daylight.moment import find_moment, frame_of, state_moment
from lumenray.blender_addon.daylight.readout import describe_moment, describe_place
from lumenray.engine.errors import SceneError
from lumenray.engine.sky.place import Place
from lumenray.engine.sky.solar_position import find_sun


@pytest.fixture
def world():
    """Return a world in Berlin."""
    return new_sky()


def set_date(world, year, month, day, hour):
    time = world.lumenray.time
    time.year, time.month, time.day, time.hour = year, month, day, hour


def utc_of(moment):
    return datetime.fromtimestamp(moment.seconds, UTC).replace(tzinfo=None)


def say(world):
    return describe_moment(world, bpy.context.scene)


def test_the_clock_is_that_of_the_zone_with_daylight_saving_time(world):
    set_date(world, 2026, 7, 1, 14.5)
    assert utc_of(find_moment(world, 1)) == datetime(2026, 7, 1, 12, 30)
    set_date(world, 2026, 1, 10, 14.5)
    assert utc_of(find_moment(world, 1)) == datetime(2026, 1, 10, 13, 30)


def test_the_sun_is_that_of_the_place_turned_by_the_north_offset(world):
    set_date(world, 2026, 6, 21, 10.0)
    world.lumenray.time.use_refraction = False
    moment = find_moment(world, 1)
    sun = find_sun(moment.seconds, Place(52.52, 13.4, elevation=30.0))
    assert moment.elevation == pytest.approx(float(sun.elevation), abs=1e-5)
    assert moment.azimuth == pytest.approx(float(sun.azimuth), abs=1e-5)
    height, turn = math.radians(moment.elevation), math.radians(moment.azimuth)
    expected = [math.cos(height) * math.sin(turn), math.cos(height) * math.cos(turn)]
    np.testing.assert_allclose(moment.towards_sun[:2], expected, atol=1e-6)
    # Where +y points east, what stands in the east is ahead.
    world.lumenray.place.north = math.radians(90.0)
    turned = find_moment(world, 1).towards_sun
    np.testing.assert_allclose(turned[:2], [-expected[1], expected[0]], atol=1e-6)


def test_refraction_lifts_a_low_sun(world):
    set_date(world, 2026, 3, 21, 18.15)
    lifted = find_moment(world, 1).elevation
    world.lumenray.time.use_refraction = False
    plain = find_moment(world, 1).elevation
    assert 0.0 < plain < 2.0
    # Almanacs have 0.3 to 0.5 degrees within two degrees of the horizon.
    assert 0.28 < lifted - plain < 0.5


def test_time_follows_the_frames_and_the_clock_that_is_put_forward(world):
    set_date(world, 2026, 3, 29, 1.0)
    time = world.lumenray.time
    time.follows_frames, time.first_frame, time.minutes_per_frame = True, 11, 15.0
    assert utc_of(find_moment(world, 11)) == datetime(2026, 3, 29, 0, 0)
    later = find_moment(world, 19.0)
    assert utc_of(later) == datetime(2026, 3, 29, 2, 0)
    # From 2 to 3 o'clock the clock shows nothing.
    assert later.clock.hour == 4
    assert utc_of(find_moment(world, 10.5)) == datetime(2026, 3, 28, 23, 52, 30)
    bpy.context.scene.frame_set(19)
    assert frame_of(bpy.context.scene) == 19.0
    assert {("Clock", "04:00"), ("Zone", "UTC+02:00")} <= set(say(world).lines)
    time.follows_frames = False
    assert utc_of(find_moment(world, 19)) == datetime(2026, 3, 29, 0, 0)


def test_a_moment_that_is_stated_is_the_one_of_its_frame(world):
    set_date(world, 2026, 10, 25, 0.0)
    time = world.lumenray.time
    time.follows_frames, time.minutes_per_frame = True, 30.0
    # The second half past two of the night in which clocks are put back, at a frame on the other side of it.
    wanted = datetime(2026, 10, 25, 1, 30, tzinfo=UTC).timestamp()
    state_moment(world, 9.0, wanted)
    assert find_moment(world, 9.0).seconds == wanted
    time.follows_frames = False
    state_moment(world, 9.0, wanted)
    assert find_moment(world, 1.0).seconds == wanted
    assert (time.hour, time.is_second) == (2.5, True)


def test_what_is_odd_about_a_clock_or_a_day_is_said(world):
    set_date(world, 2026, 10, 25, 2.5)
    assert "twice, and the first was taken" in say(world).problem
    set_date(world, 2026, 3, 29, 2.5)
    assert "leave out" in say(world).problem
    set_date(world, 2026, 2, 31, 12.0)
    assert "February 2026 has 28 days" in say(world).problem
    assert find_moment(world, 1).clock.day == 28
    set_date(world, 2026, 6, 21, 23.5)
    assert say(world).problem == "the sun is below the horizon"
    world.lumenray.place.city = "Tromsø, Norway"
    assert say(world).problem.startswith("polar day")
    assert not {"Sunrise", "Sunset"} & dict(say(world).lines).keys()
    set_date(world, 2026, 12, 21, 12.0)
    assert say(world).problem.startswith("polar night")


def test_rise_and_set_are_those_of_the_almanac(world):
    """Berlin on 2026-06-21: sunrise 4:43, sunset 21:33 (tables of the almanac, to the minute)."""
    set_date(world, 2026, 6, 21, 12.0)
    lines = dict(say(world).lines)
    assert lines["Sunrise"] in {"04:42", "04:43", "04:44"}
    assert lines["Sunset"] in {"21:32", "21:33", "21:34"}


@pytest.mark.parametrize(("zone", "year"), [("Europe/Nowhere", 2026), ("UTC", 2100)])
def test_a_moment_that_cannot_be_known_is_refused_in_one_sentence(world, zone, year):
    set_date(world, year, 12, 31, 12.0)
    world.lumenray.place.zone = zone
    time = world.lumenray.time
    time.follows_frames, time.minutes_per_frame = True, 1440.0
    with pytest.raises(SceneError, match=r"zone|years"):
        find_moment(world, 10.0)
    assert ("zone" in say(world).problem) == (zone != "UTC")


def test_a_city_fills_in_where_it_lies(world):
    place = world.lumenray.place
    place.city = "Sydney, Australia"
    assert math.degrees(place.latitude) == pytest.approx(-33.87, abs=0.05)
    assert math.degrees(place.longitude) == pytest.approx(151.21, abs=0.05)
    assert place.zone == "Australia/Sydney"
    assert describe_place(world) == ""
    set_date(world, 2026, 12, 21, 13.0)
    # In the south the sun of noon stands in the north.
    moment = find_moment(world, 1)
    assert moment.towards_sun[1] > 0.0
    assert moment.elevation > 75.0
    place.latitude = 0.0
    assert "Sydney" in describe_place(world)
    before = place.zone
    place.city = "Nowhere at All"
    assert place.zone == before


def test_the_choice_of_a_city_is_undone_as_one(world):
    remember = bpy.ops.ed.undo_push
    name = world.name
    remember(message="start")
    world.lumenray.place.city = "Tokyo, Japan"
    remember(message="city")
    bpy.ops.ed.undo()
    place = bpy.data.worlds[name].lumenray.place
    assert (place.city, place.zone) == ("Berlin, Germany", "Europe/Berlin")
    assert math.degrees(place.latitude) == pytest.approx(52.52)


def test_users_cities_are_offered_before_those_that_ship(world, tmp_path, monkeypatch):
    from lumenray.blender_addon.daylight import places

    path = tmp_path / "sites.csv"
    path.write_text(
        "name,country,latitude,longitude,elevation_m,zone\n"
        "Site 7,Germany,50.0,9.0,120,Europe/Berlin\nBroken,Germany,500,9,0,Europe/Berlin\n"
    )
    monkeypatch.setattr(places.preferences, "city_list", lambda: path)
    assert places.search_cities(None, None, "site") == ["Site 7, Germany"]
    world.lumenray.place.city = "Site 7, Germany"
    assert math.degrees(world.lumenray.place.latitude) == pytest.approx(50.0)
    assert "sites.csv" in describe_place(world)
    assert places.search_cities(None, None, "munch")[0] == "Munich, Germany"
    assert places.search_cities(None, None, "münch") == places.search_cities(None, None, "munch")
    assert "Asia/Kolkata" in places.search_zones(None, None, "kolk")
