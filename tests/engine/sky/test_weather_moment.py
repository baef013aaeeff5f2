"""What a weather file says of a moment: its record by the standard clock, leap days, and means over a month."""

from datetime import datetime

import numpy as np
import pytest
from weather_files import epw, epw_record

from lumenray.engine.errors import SceneError
from lumenray.engine.scene.light import PerezSky
from lumenray.engine.sky.air import standard_air
from lumenray.engine.sky.hour import find_daylight_hours
from lumenray.engine.sky.measured import make_grid_world
from lumenray.engine.sky.picture import find_illuminance
from lumenray.engine.sky.place import from_local
from lumenray.engine.sky.skies import check_sky, with_zenith_luminance, zenith_luminance
from lumenray.engine.sky.weather import find_hours
from lumenray.engine.sky.weather_file import read_weather
from lumenray.engine.sky.weather_moment import find_weather_moment


@pytest.fixture
def weather(tmp_path):
    """Hours of some days of July, and one of 28 February; direct irradiance tells them apart."""
    records = [
        epw_record(2005, 7, day, hour, dni=10 * day + hour, dhi=90 + day, dew=11.0)
        for day in (1, 2, 3)
        for hour in (11, 12, 13)
    ]
    records.append(epw_record(2005, 7, 4, 12, dni="9999", dhi=100))
    records.append(epw_record(1999, 2, 28, 12, dni=500, dhi=80))
    path = tmp_path / "weather.epw"
    path.write_text(epw(records))
    return read_weather(path)


def seconds_of(*clock, zone="Europe/Berlin"):
    return from_local(datetime(*clock), zone).seconds


@pytest.mark.parametrize(
    ("clock", "record"),
    [
        # The record of hour 12 holds 11 to 12 o'clock of standard time, 12 to 13 by daylight saving time.
        ((2026, 7, 2, 12, 0), 12),
        ((2026, 7, 2, 12, 59), 12),
        ((2026, 7, 2, 13, 0), 13),
        ((2031, 7, 2, 11, 30), 11),
    ],
)
def test_the_record_is_the_one_that_holds_the_moment(weather, clock, record):
    found = find_weather_moment(weather, seconds_of(*clock), is_mean=False)
    index = int(
        np.flatnonzero((weather.month == 7) & (weather.day == 2) & (weather.hour == record - 0.5))[
            0
        ]
    )
    hours = find_hours(weather, clock[0])
    expected = find_daylight_hours(weather, hours)
    assert found.direct_normal == pytest.approx(float(expected.direct_normal[index]))
    assert found.diffuse_horizontal == pytest.approx(float(expected.diffuse_horizontal[index]))
    assert found.clearness == pytest.approx(float(expected.clearness[index]))
    assert found.days == 1


def test_a_leap_day_that_the_file_lacks_is_the_day_before(weather):
    found = find_weather_moment(weather, seconds_of(2028, 2, 29, 11, 30), is_mean=False)
    assert "28th was taken" in found.note
    assert found.direct_normal > 0.0
    assert find_weather_moment(weather, seconds_of(2028, 2, 28, 11, 30), is_mean=False).note == ""


def test_what_the_file_does_not_say_is_refused(weather):
    with pytest.raises(SceneError, match="no record of 07-02 20:00"):
        find_weather_moment(weather, seconds_of(2026, 7, 2, 21, 0), is_mean=False)
    with pytest.raises(SceneError, match="of 07-04"):
        find_weather_moment(weather, seconds_of(2026, 7, 4, 12, 30), is_mean=False)


def test_the_mean_has_the_mean_of_the_days_illuminances(weather):
    seconds = seconds_of(2026, 7, 2, 12, 30)
    mean = find_weather_moment(weather, seconds, is_mean=True)
    single = [
        find_weather_moment(weather, seconds_of(2026, 7, day, 12, 30), is_mean=False)
        for day in (1, 2, 3)
    ]
    assert mean.days == 3
    assert "1 day lacks" in mean.note
    assert mean.direct_normal == pytest.approx(np.mean([each.direct_normal for each in single]))
    expected = np.mean([each.diffuse_horizontal for each in single])
    assert mean.diffuse_horizontal == pytest.approx(expected)
    # The grid is coarser than the skies about the sun.
    world = make_grid_world(mean.mean)
    assert find_illuminance(world.image, np.eye(3), (0, 0, 1)) == pytest.approx(expected, rel=0.01)


def test_air_gets_thinner_and_colder_upwards():
    """ISO 2533, tables for 0, 1000 and 5000 m."""
    for height, pressure, temperature in (
        (0, 101_325, 15.0),
        (1000, 89_874.6, 8.5),
        (5000, 54_019.9, -17.5),
    ):
        air = standard_air(height)
        assert air.pressure == pytest.approx(pressure, rel=1e-3)
        assert air.temperature == pytest.approx(temperature, abs=0.05)


def test_a_sky_can_be_stated_by_its_zenith():
    sky = PerezSky(2.3, 0.2, np.array([0.5, 0.5, 0.7]), 1.0)
    made = with_zenith_luminance(sky, 4321.0)
    check_sky(made)
    assert zenith_luminance(made) == pytest.approx(4321.0, rel=1e-9)
