"""Light of a year from made-up coefficients, whose illuminances are known."""

from datetime import date

import numpy as np
import pytest
from made_up_years import GROUPS, open_coefficients
from weather_files import sunny_year

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.daylight.coefficients import DaylightOrder
from lumenray.engine.daylight.factors import find_factors
from lumenray.engine.daylight.kept import read_coefficients, write_coefficients
from lumenray.engine.daylight.light import YearLight
from lumenray.engine.daylight.study import Question, judge, shade
from lumenray.engine.daylight.sunlight import make_day
from lumenray.engine.daylight.year import make_year
from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.sky.weather_file import read_weather


@pytest.fixture(scope="module")
def year(tmp_path_factory):
    """Ten clear days and ten overcast ones in turn."""
    path = tmp_path_factory.mktemp("weather") / "made_up.epw"
    path.write_text(sunny_year(), encoding="latin-1")
    return make_year(read_weather(path), ground_reflectance=0.0)


def test_an_open_sensor_has_what_the_weather_has(year):
    values, errors = YearLight(open_coefficients(year, (1.0, 0.5)), year).illuminance()
    beam = np.zeros(len(year.lit))
    has_sun = year.sun >= 0
    beam[has_sun] = year.direct_normal[has_sun] * year.suns[year.sun[has_sun], 2]
    exact = year.diffuse_horizontal + beam
    np.testing.assert_allclose(values[0], exact, rtol=2e-4, atol=1e-3)
    np.testing.assert_allclose(values[1], 0.5 * exact, rtol=2e-4, atol=1e-3)
    # Only what nodes do not resolve is left.
    assert (errors < 0.02 * np.maximum(values, 1.0)).all()


def test_errors_are_those_of_the_groups(year):
    made = open_coefficients(year, (1.0,), noise=0.2, seed=3)
    light = YearLight(made, year)
    _, errors = light.illuminance()
    groups = made.sky @ year.sky.T
    expected = groups.std(axis=0, ddof=1) / np.sqrt(GROUPS)
    np.testing.assert_allclose(errors, expected, rtol=0.05)
    versions = np.stack(list(light.versions(slice(None))))
    spread = np.sqrt(((versions[1:] - versions[0]) ** 2).mean(axis=0))
    np.testing.assert_allclose(spread, errors, rtol=1e-3, atol=1e-3)


def test_figures_of_an_open_sensor(year):
    moments = make_day(date(2001, 3, 21), year.weather.place, 10.0, 600.0)
    suns = np.concatenate([year.suns, moments.sun.directions(0.0)])
    made = open_coefficients(year, (1.0, 0.02), suns=suns)
    figures = judge(shade(year, made, ()), Question(day=moments))
    factors = figures.sensors["daylight_factor"]
    np.testing.assert_allclose(factors.value, [1.0, 0.02], rtol=1e-3)
    assert figures.area["daylight_factor_mean"].value == pytest.approx(0.51, rel=1e-3)
    values, _ = YearLight(made, year).illuminance()
    # Eight to six by the clock of the file, dark hours with them.
    clock = year.weather.hour[year.lit]
    counted = (clock > 8.0) & (clock < 18.0)
    hours = ((year.weather.hour > 8.0) & (year.weather.hour < 18.0)).sum()
    expected = (values[:, counted] >= 300.0).sum(axis=1) / hours
    np.testing.assert_allclose(figures.sensors["daylight_autonomy"].value, expected)
    assert figures.sunlight_level == "high"
    day = figures.sensors["sunlight_of_day_h"].value
    np.testing.assert_allclose(day, len(moments.times) * 600.0 / 3600.0)


def test_closed_blinds_take_the_place_of_open_ones(year):
    opened, closed = (open_coefficients(year, (part, part)) for part in (0.3, 0.01))
    light = shade(year, opened, (closed,))
    direct = light.opened.direct_sun() - YearLight(closed, year).direct_sun()
    expected = (direct > 1000.0).mean(axis=0) > 0.02
    np.testing.assert_array_equal(light.is_closed[0], expected)
    assert 0 < expected.sum() < len(expected)
    values, _ = light.illuminance()
    own = [YearLight(each, year).illuminance()[0] for each in (opened, closed)]
    np.testing.assert_allclose(values, np.where(expected, own[1], own[0]), rtol=1e-5)


def test_daylight_factors_with_the_ground(year):
    made = open_coefficients(year)
    made.sky[..., -1] = 0.5
    with_ground = find_factors(made, ground_reflectance=0.2)[0]
    np.testing.assert_allclose(with_ground, 1.0 + 0.5 * 0.2 / np.pi, rtol=1e-3)


def test_coefficients_come_back_from_a_file(year, tmp_path):
    made = open_coefficients(year, (1.0, 0.5), noise=0.1)
    path = write_coefficients(tmp_path / "traced.lumenray", made, "s", "o")
    back = read_coefficients(path, "s", "o")
    np.testing.assert_array_equal(back.sky, made.sky)
    np.testing.assert_array_equal(back.neighbours, made.neighbours)
    assert back.provenance == made.provenance
    assert back.samples == made.samples
    with pytest.raises(FileFormatError):
        read_coefficients(path, "another scene", "o")
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(FileFormatError):
        read_coefficients(path, "s", "o")


def test_coefficients_of_other_suns_are_refused(year):
    made = open_coefficients(year, suns=year.suns[:5])
    with pytest.raises(SceneError, match="other suns"):
        YearLight(made, year)
    assert DaylightOrder(year.suns, 0.01).rule == StopRule(samples=4096)
