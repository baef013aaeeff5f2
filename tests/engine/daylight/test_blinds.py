"""Blinds by rules of one's own, on light whose states can be told by hand."""

import numpy as np
import pytest
from made_up_years import open_coefficients
from weather_files import sunny_year

from lumenray.engine.daylight.blinds import (
    FixedTimes,
    PlaneBound,
    SensorBound,
    StandardRule,
    StateTable,
    SunBound,
    find_plane_irradiance,
    read_state_tables,
)
from lumenray.engine.daylight.light import YearLight
from lumenray.engine.daylight.study import OWN_RULES, Question, judge, shade
from lumenray.engine.daylight.year import make_year
from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.sky.clock_range import ClockRange
from lumenray.engine.sky.place import to_local
from lumenray.engine.sky.weather_file import read_weather


@pytest.fixture(scope="module")
def year(tmp_path_factory):
    path = tmp_path_factory.mktemp("weather") / "made_up.epw"
    path.write_text(sunny_year(), encoding="latin-1")
    return make_year(read_weather(path), ground_reflectance=0.2)


@pytest.fixture(scope="module")
def states(year):
    """Coefficients with blinds open and closed."""
    return tuple(open_coefficients(year, (part, 0.5 * part)) for part in (0.3, 0.01))


def follow(year, states, *rules, zone="Europe/Berlin"):
    opened, closed = states
    return shade(year, opened, (closed,) * max(len(rules), 1), None, Question(zone, blinds=rules))


def test_always_closed_is_the_closed_state(year, states):
    light = follow(year, states, FixedTimes())
    expected = YearLight(states[1], year)
    for found, wanted in zip(light.illuminance(), expected.illuminance(), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-4, atol=1e-2)


def test_the_standards_rule_is_what_there_is_without_rules(year, states):
    light = follow(year, states, StandardRule())
    np.testing.assert_array_equal(light.is_closed, follow(year, states).is_closed)
    assert not isinstance(light, type(follow(year, states, FixedTimes())))


def test_blinds_by_the_clock_know_daylight_saving_time_and_the_days(year, states):
    stretch = ClockRange((10, 3), (8.0, 16.0))
    closed = follow(year, states, FixedTimes(stretch, (0, 6))).is_closed[0]
    for number, time in enumerate(year.middles[year.lit]):
        clock = to_local(time, "Europe/Berlin")
        wanted = clock.month in {10, 11, 12, 1, 2, 3} and 8 <= clock.hour < 16
        assert closed[number] == (wanted and clock.weekday() in {0, 6})
    assert 0 < closed.sum() < len(closed)


def test_hours_over_midnight():
    stretch = ClockRange(hours=(22.0, 6.0))
    assert stretch.holds([1] * 5, [21.9, 22.0, 2.0, 5.9, 6.0]).tolist() == [0, 1, 1, 1, 0]


def test_a_table_has_a_state_for_every_record(year, states, tmp_path):
    rng = np.random.default_rng(3)
    wanted = rng.uniform(size=(year.count, 2)) < 0.4
    path = tmp_path / "states.csv"
    path.write_text("south,west\n" + "".join(f"{a:d},{b:d}\n" for a, b in wanted))
    tables = read_state_tables(path)
    light = follow(year, states, *tables)
    np.testing.assert_array_equal(light.is_closed, wanted[year.lit].T)
    with pytest.raises(SceneError, match=r"has 10 states, expected .* 8760 records"):
        follow(year, states, StateTable(np.zeros(10, bool)))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "has no states"),
        ("1,0\n1\n", "has 1 states, expected 2"),
        ("0\n0.5\n", "has the state 0.5"),
        ("0\nopen\n", "found 'open'"),
    ],
)
def test_tables_that_are_none_name_the_line(tmp_path, text, words):
    path = tmp_path / "states.csv"
    path.write_text(text)
    with pytest.raises(FileFormatError, match=words):
        read_state_tables(path)


def test_bounds_of_irradiance(year, states):
    direct = np.nan_to_num(year.hours.direct_normal)[year.lit]
    diffuse = np.nan_to_num(year.hours.diffuse_horizontal)[year.lit]
    closed = follow(year, states, SunBound(300.0)).is_closed[0]
    np.testing.assert_array_equal(closed, direct > 300.0)
    sine = np.maximum(np.sin(np.radians(year.hours.sun.elevation))[year.lit], 0.0)
    on_ground = direct * sine + diffuse
    found = find_plane_irradiance(year, (0.0, 0.0, 1.0))
    np.testing.assert_allclose(found, on_ground, rtol=2e-3, atol=0.5)
    # The mean over all vertical planes: what a small upright cylinder gets.
    turns = np.arange(72) * 2.0 * np.pi / 72
    planes = [find_plane_irradiance(year, (np.sin(t), np.cos(t), 0.0)) for t in turns]
    ground = 0.5 * 0.2 * on_ground
    by_sun = direct * np.sqrt(1.0 - sine**2) / np.pi
    overcast = direct == 0.0
    rest = np.mean(planes, axis=0) - ground - by_sun
    # An even sky would give half of its horizontal irradiance; these are brighter at the zenith or about the sun.
    assert (rest[overcast] > 0.3 * diffuse[overcast]).all()
    assert (rest > 0.0).all()
    facade = follow(year, states, PlaneBound(200.0, (0.0, -1.0, 0.0))).is_closed[0]
    np.testing.assert_array_equal(facade, find_plane_irradiance(year, (0, -1, 0)) > 200.0)


def test_a_bound_of_the_sensors_light_tells_what_is_uncertain(year, states):
    light = follow(year, states, SensorBound(2000.0))
    mean = light.opened.illuminance()[0].mean(axis=0)
    np.testing.assert_array_equal(light.is_closed[0], mean > 2000.0)
    noisy = (open_coefficients(year, (0.3, 0.15), noise=0.3, seed=1), states[1])
    (note,) = follow(year, noisy, SensorBound(2000.0)).notes
    assert "2000 lx" in note


def test_spatial_autonomy_keeps_the_blinds_of_its_standard(year, states):
    own = judge(follow(year, states, FixedTimes()), Question(blinds=(FixedTimes(),)))
    standard = judge(follow(year, states), Question())
    assert own.area["sda"].value == standard.area["sda"].value
    assert own.area["daylight_autonomy"].value < standard.area["daylight_autonomy"].value
    assert OWN_RULES in own.notes


def test_rules_that_do_not_fit_the_groups_are_refused(year, states):
    opened, closed = states
    with pytest.raises(SceneError, match="2 rules for the blinds of 3 groups"):
        shade(year, opened, (closed,) * 3, None, Question(blinds=(FixedTimes(), FixedTimes())))
    with pytest.raises(SceneError, match="there are none"):
        shade(year, opened, (), None, Question(blinds=(FixedTimes(),)))
    with pytest.raises(SceneError, match="numbers of 1 to 12"):
        ClockRange(months=(0, 5))
    with pytest.raises(SceneError, match="two different ones"):
        ClockRange(hours=(5.0, 5.0))
