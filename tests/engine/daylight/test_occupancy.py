"""Hours by the clocks of a place."""

import numpy as np
import pytest
from weather_files import epw, epw_year

from lumenray.engine.daylight.occupancy import WORKDAYS, Schedule, occupied_hours
from lumenray.engine.errors import SceneError
from lumenray.engine.sky.place import to_local
from lumenray.engine.sky.weather import find_middles
from lumenray.engine.sky.weather_file import read_weather


def year_of(tmp_path, year, **place):
    path = tmp_path / "year.epw"
    path.write_text(epw(epw_year(2005, year == 2024, dni=0, dhi=0), **place))
    weather = read_weather(path)
    return weather, find_middles(weather, year)


@pytest.mark.parametrize(
    ("zone", "place"),
    [
        ("Europe/Berlin", {"zone": 1}),
        ("America/New_York", {"zone": -5, "longitude": -74}),
        ("Australia/Sydney", {"zone": 10, "longitude": 151, "latitude": -34}),
        ("Asia/Kolkata", {"zone": 5.5, "longitude": 77}),
        ("UTC+1", {"zone": 1}),
    ],
)
def test_ten_hours_of_every_day_are_3650(tmp_path, zone, place):
    weather, times = year_of(tmp_path, 2025, **place)
    hours = occupied_hours(times, zone)
    assert np.count_nonzero(hours) == 3650
    clocks = [to_local(t, zone) for t in times[hours]]
    assert {clock.hour for clock in clocks} == set(range(8, 18))
    # While clocks are put forward the file's own hours begin one earlier.
    summer = weather.month == (1 if zone == "Australia/Sydney" else 7)
    saves = zone not in {"UTC+1", "Asia/Kolkata"}
    assert weather.hour[hours & summer].min() == (7.5 if saves else 8.5)
    winter = weather.month == (7 if zone == "Australia/Sydney" else 1)
    assert weather.hour[hours & winter].min() == 8.5


def test_leap_years_have_ten_hours_more(tmp_path):
    assert np.count_nonzero(occupied_hours(year_of(tmp_path, 2024)[1], "Europe/Berlin")) == 3660


@pytest.mark.parametrize("year", [1900, 2100])
def test_first_and_last_year(tmp_path, year):
    weather, times = year_of(tmp_path, year)
    assert len(weather) == 8760
    assert np.count_nonzero(occupied_hours(times, "UTC+1")) == 3650


def test_workdays(tmp_path):
    _, times = year_of(tmp_path, 2025)
    # 2025 begins on a Wednesday and has 261 workdays.
    hours = occupied_hours(times, "Europe/Berlin", Schedule(9.0, 17.0, WORKDAYS))
    assert np.count_nonzero(hours) == 261 * 8


@pytest.mark.parametrize(
    ("schedule", "words"),
    [
        (Schedule(18.0, 8.0), "from 18 to 8 h"),
        (Schedule(8.0, 25.0), "from 8 to 25 h"),
        (Schedule(days=()), "days of the schedule"),
        (Schedule(days=(7,)), "days of the schedule"),
    ],
)
def test_schedules_that_are_none_are_refused(schedule, words):
    with pytest.raises(SceneError, match=words):
        occupied_hours([0.0], "UTC", schedule)
