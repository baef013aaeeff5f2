"""Sky and sun of a weather file's hour in a scene: what planes receive is what the file says."""

import numpy as np
import pytest
from small_scenes import session_of
from weather_files import epw, epw_record, wea

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.sky.hour import find_daylight_hours, make_hour
from lumenray.engine.sky.perez import find_daylight, precipitable_water
from lumenray.engine.sky.weather import find_hours
from lumenray.engine.sky.weather_file import read_weather


@pytest.fixture
def day(tmp_path):
    """Hours of a clear day with a missing value and a cloud."""
    path = tmp_path / "day.epw"
    given = {9: (600, 80), 12: (800, 95), 13: (0, 210), 17: ("9999", 60), 23: (0, 0)}
    records = [epw_record(2005, 7, 3, h, dni=a, dhi=b, dew=11.0) for h, (a, b) in given.items()]
    path.write_text(epw(records))
    weather = read_weather(path)
    hours = find_hours(weather)
    return weather, hours, find_daylight_hours(weather, hours)


def test_water_is_that_of_the_dew_point_or_of_radiance(day, tmp_path):
    weather, hours, found = day
    sun = hours.sun
    water = float(precipitable_water(11.0))
    expected = find_daylight(600.0, 80.0, sun.elevation[0], water, sun.distance[0])
    assert found.diffuse_horizontal[0] == expected.diffuse_horizontal
    path = tmp_path / "day.wea"
    path.write_text(wea([(7, 3, 8.5, 600, 80)]))
    plain = read_weather(path)
    hours = find_hours(plain, 2005)
    without = find_daylight_hours(plain, hours)
    sun = hours.sun
    expected = find_daylight(600.0, 80.0, sun.elevation[0], 20.0, sun.distance[0])
    assert without.direct_normal[0] == float(expected.direct_normal)
    assert weather.place.latitude == plain.place.latitude


def test_what_gives_no_light_is_left_out(day):
    _, hours, found = day
    kinds = [[each is not None for each in make_hour(hours, found, i)] for i in range(5)]
    # A cloud before the sun; a record without a direct irradiance, which is not known; night.
    assert kinds == [[True, True], [True, True], [True, False], [False, False], [False, False]]


def test_twilight_has_a_sky_without_a_sun(tmp_path):
    path = tmp_path / "dusk.epw"
    path.write_text(epw([epw_record(2005, 7, 3, 22, dni=0, dhi=4)]))
    weather = read_weather(path)
    hours = find_hours(weather)
    assert hours.sun.elevation[0] < 0.0
    sky, sun = make_hour(hours, find_daylight_hours(weather, hours), 0)
    assert sun is None
    assert sky.towards_sun[2] == 0.0
    assert np.linalg.norm(sky.towards_sun) == pytest.approx(1.0)


@pytest.mark.mitsuba
def test_planes_receive_what_the_hour_says(day):
    """A horizontal plane and one that faces the sun, in a scene turned by 30 degrees."""
    _, hours, found = day
    sky, sun = make_hour(hours, found, 0, north=30.0, ground_reflectance=0.0)
    azimuth = np.radians(hours.sun.azimuth[0] - 30.0)
    height = np.radians(hours.sun.elevation[0])
    plan = np.cos(height)
    towards = np.array([plan * np.sin(azimuth), plan * np.cos(azimuth), np.sin(height)])
    session = session_of(sky, sun)
    normals = np.array([[0.0, 0.0, 1.0], towards, -towards])
    made = session.measure(
        np.zeros((3, 3)), normals, StopRule(samples=1 << 14), transport="mono", seed=5
    )
    expected = found.diffuse_horizontal[0] + found.direct_normal[0] * np.sin(height)
    assert abs(made.illuminance[0] - expected) < 4.0 * made.standard_error[0] + 2e-4 * expected
    # The plane that faces the sun has all of it, and the one that turns away has none.
    assert made.illuminance[1] > found.direct_normal[0]
    assert made.illuminance[2] < found.diffuse_horizontal[0]
