"""Suns mended by the sky, and by the CIE's clear sky at a place and a date."""

from datetime import UTC, datetime

import numpy as np
import pytest

from lumenray.benchmarks.environment.drawn_maps import Spot, make_map
from lumenray.engine.environment.repair import (
    choose_time,
    find_north,
    find_times,
    find_tolerance,
    rebuild_sun,
    sun_factor,
    tell_times,
)
from lumenray.engine.environment.sources import find_sources
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.light import CieSky
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.sky.availability import usual_illuminance
from lumenray.engine.sky.place import Place
from lumenray.engine.sky.skies import find_luminances
from lumenray.engine.sky.solar_position import find_sun
from lumenray.engine.sky.sunlight import direct_illuminance

BERLIN = Place(52.52, 13.405, "Europe/Berlin", 34.0)


def clear_map(elevation, azimuth, clip, height=512):
    """A map of the CIE's clear sky in units of 1000 cd/m2 with its sun, clipped; and that sun."""
    sun = Spot(elevation, azimuth, illuminance=1e-3 * direct_illuminance(elevation, 3.0))
    sky = CieSky(12, sun.towards, usual_illuminance("clear", elevation))
    shown = make_map(height, [sun], lambda d: 1e-3 * find_luminances(sky, d), 0.5, clip)
    shown.flags.writeable = False
    return ImageTexture(shown), sun


def test_a_sun_is_brought_to_a_multiple_of_the_sky():
    image, spot = clear_map(40.0, 100.0, 2000.0)
    (source,) = find_sources(image).sources
    factor = sun_factor(source, 10.0, 4.0)
    assert factor * source.illuminance * np.sin(np.radians(40.0)) == pytest.approx(40.0, rel=5e-3)
    assert spot.illuminance > source.illuminance


@pytest.mark.parametrize("elevation", [12.0, 33.0, 58.0])
@pytest.mark.parametrize("clip", [800.0, 2e4])
def test_a_clipped_sun_is_rebuilt_by_a_place_of_its_sky(elevation, clip):
    """The map was drawn by the model, so that its own sun has to come out, from every place of the sky."""
    image, spot = clear_map(elevation, 130.0, clip)
    (source,) = find_sources(image).sources
    for place in (Spot(60.0, 310.0), Spot(25.0, 20.0), Spot(15.0, 200.0)):
        made = rebuild_sun(image, source.core, place.towards)
        assert made.illuminance == pytest.approx(spot.illuminance, rel=0.01)
        assert made.scale == pytest.approx(1000.0, rel=0.01)
    # Seen through a map that is turned and tipped.
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    made = rebuild_sun(image, turn.T @ source.core, turn.T @ place.towards, rotation=turn)
    assert made.illuminance == pytest.approx(spot.illuminance, rel=0.01)


def test_places_that_are_no_sky_are_refused():
    image, spot = clear_map(30.0, 130.0, 2e4, 64)
    for place, words in (
        (Spot(-5.0, 0.0), "below the horizon"),
        (Spot(31.0, 130.0), "of the sun"),
    ):
        with pytest.raises(SceneError, match=words):
            rebuild_sun(image, spot.towards, place.towards)
    with pytest.raises(SceneError, match="not above the horizon"):
        rebuild_sun(image, Spot(-1.0, 0.0).towards, Spot(40.0, 0.0).towards)
    black = ImageTexture(np.zeros((16, 32, 3), np.float32))
    with pytest.raises(SceneError, match="black"):
        rebuild_sun(black, spot.towards, Spot(40.0, 0.0).towards)


@pytest.mark.parametrize("hour", [5, 7, 9, 14, 16])
def test_the_time_follows_from_a_sun_in_a_map(hour):
    """The sun of NREL's algorithm for a time is drawn, found in the map, and leads back to that time and to north."""
    wanted = datetime(2026, 5, 20, hour, 40, tzinfo=UTC).timestamp()
    sun = find_sun(wanted, BERLIN)
    spot = Spot(float(sun.elevation), 77.0, illuminance=20.0)
    image = ImageTexture(make_map(1024, [spot], clip=2000.0))
    (source,) = find_sources(image).sources
    elevation = np.degrees(np.arcsin(source.core[2]))
    times = find_times(elevation, BERLIN, 2026, 5, 20, is_lifted=False)
    assert len(times) == 2
    found = choose_time(times, hour < 11)
    assert abs(found.seconds - wanted) < 180.0
    assert found.clock.hour == hour + 2
    north = find_north(source.core, found.azimuth)
    assert north == pytest.approx((float(sun.azimuth) - 77.0 + 180.0) % 360.0 - 180.0, abs=0.5)


def test_a_sun_that_is_never_so_high_is_refused():
    with pytest.raises(SceneError, match=r"stands 70\.0 degrees high in the picture"):
        find_times(70.0, BERLIN, 2026, 12, 21)
    with pytest.raises(SceneError, match="no day"):
        find_times(20.0, BERLIN, 2026, 2, 30)


def test_near_noon_the_time_is_said_to_be_wide():
    """Altitude and time from the sun's own positions: at the bounds it stands a tolerance lower, and noon lies within."""
    noon = datetime(2026, 5, 20, 11, 2, tzinfo=UTC).timestamp()
    high = float(find_sun(noon, BERLIN).elevation)
    for minutes in (5.0, 20.0):
        wanted = noon - 60.0 * minutes
        height, tolerance = float(find_sun(wanted, BERLIN).elevation), find_tolerance(512)
        found = choose_time(
            find_times(height, BERLIN, 2026, 5, 20, is_lifted=False, tolerance=tolerance), True
        )
        first, last = found.first.timestamp(), found.last.timestamp()
        assert first < wanted < last
        assert float(find_sun(first, BERLIN).elevation) == pytest.approx(
            height - tolerance, abs=1e-3
        )
        assert (last > noon) == (high < height + tolerance)
        assert last - first > 900.0 and found.turn > 5.0
        assert "says little of the time" in tell_times(found, tolerance)
    # Read half a pixel too high, the sun never stands so: it was noon then, and that is as wide.
    (found,) = find_times(
        high + 0.1, BERLIN, 2026, 5, 20, is_lifted=False, tolerance=find_tolerance(512)
    )
    assert abs(found.seconds - noon) < 180.0
    assert found.first.timestamp() < found.seconds < found.last.timestamp()
    with pytest.raises(SceneError, match="high in the picture"):
        find_times(high + 0.3, BERLIN, 2026, 5, 20, is_lifted=False, tolerance=find_tolerance(512))


def test_away_from_noon_the_time_is_as_wide_as_the_suns_speed_makes_it():
    wanted = datetime(2026, 3, 20, 6, 30, tzinfo=UTC).timestamp()
    around = find_sun(np.array([wanted - 30.0, wanted, wanted + 30.0]), BERLIN).elevation
    found = choose_time(
        find_times(float(around[1]), BERLIN, 2026, 3, 20, is_lifted=False, tolerance=0.1), True
    )
    minutes = (found.last - found.first).total_seconds() / 60.0
    assert minutes == pytest.approx(0.2 / float(around[2] - around[0]), rel=0.02)
    assert "little" not in tell_times(found, 0.1)


def test_a_low_sun_says_how_much_its_height_changes_its_light():
    """A sun drawn half a pixel off gives another light by no more than is said, and by about as much."""
    for elevation, least in ((5.0, 0.02), (45.0, 0.0)):
        image, _ = clear_map(elevation, 130.0, 2e4, 256)
        tolerance, place = find_tolerance(256), Spot(50.0, 330.0).towards
        made, lower, higher = (
            rebuild_sun(image, Spot(elevation + off, 130.0).towards, place, tolerance=tolerance)
            for off in (0.0, -tolerance, tolerance)
        )
        change = max(abs(each.illuminance / made.illuminance - 1.0) for each in (lower, higher))
        assert made.spread == pytest.approx(change, rel=1e-6)
        assert made.spread > least
    assert made.spread < 0.01
