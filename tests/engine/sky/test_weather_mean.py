"""Means over chosen hours of a weather file: what they give is the mean of what the hours give."""

import numpy as np
import pytest
from weather_files import epw, epw_record, sunny_year

from lumenray.engine.errors import SceneError
from lumenray.engine.scene.light import PerezSky
from lumenray.engine.sky.clock_range import ClockRange
from lumenray.engine.sky.hour import find_daylight_hours
from lumenray.engine.sky.pattern import evaluate, evaluate_all
from lumenray.engine.sky.perez import pattern_of
from lumenray.engine.sky.picture import find_illuminance
from lumenray.engine.sky.skies import find_luminances
from lumenray.engine.sky.solar_position import find_sun
from lumenray.engine.sky.weather import find_hours, find_middles
from lumenray.engine.sky.weather_file import read_weather
from lumenray.engine.sky.weather_mean import find_weather_mean, make_mean_world

CHOSEN = ClockRange((5, 7), (9.0, 17.0))


@pytest.fixture(scope="module")
def weather(tmp_path_factory):
    path = tmp_path_factory.mktemp("weather") / "year.epw"
    path.write_text(sunny_year(), encoding="latin-1")
    return read_weather(path)


@pytest.fixture(scope="module")
def mean(weather):
    return find_weather_mean(weather, 2026, CHOSEN)


def on_plane(world, normal):
    return find_illuminance(world.image, np.eye(3), normal)


def hemisphere(rows=90, columns=180):
    """Directions of the sky and solid angles, even in the sine of the elevation."""
    sine = (np.arange(rows) + 0.5) / rows
    turn = 2.0 * np.pi * (np.arange(columns) + 0.5) / columns
    plan = np.sqrt(1.0 - sine**2)[:, None]
    made = np.stack(
        np.broadcast_arrays(plan * np.sin(turn), plan * np.cos(turn), sine[:, None]), -1
    )
    return made.reshape(-1, 3), 2.0 * np.pi / (rows * columns)


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, -1, 0), (0.8, 0, 0.6)])
def test_the_mean_gives_the_mean_of_the_hours(weather, mean, normal):
    hours = find_hours(weather, 2026)
    daylight = find_daylight_hours(weather, hours)
    chosen = np.flatnonzero(CHOSEN.holds(weather.month, weather.hour))
    assert len(chosen) == 92 * 8
    assert mean.hours == 92 * 8
    normal, (directions, solid) = np.array(normal, float), hemisphere()
    facing = np.maximum(directions @ normal, 0.0) * solid
    by_sky = []
    for i in chosen[::5]:
        sun = hours.sun.directions()[i]
        sky = PerezSky(
            float(daylight.clearness[i]), float(daylight.brightness[i]), sun,
            float(daylight.diffuse_horizontal[i]),
        )  # fmt: skip
        by_sky.append(find_luminances(sky, directions) @ facing)
    sky = make_mean_world(mean, has_sun=False)
    # Of every fifth hour: as exact as that sample of regular weather is.
    assert on_plane(sky, normal) == pytest.approx(np.mean(by_sky), rel=0.02)
    # The sun minute by minute.
    share = (np.arange(60) + 0.5) / 60.0 - 0.5
    times = find_middles(weather, 2026)[chosen][:, None] + 3600.0 * share
    towards = find_sun(times, weather.place).directions()
    seen = np.maximum(towards @ normal, 0.0) * (towards[..., 2] > 0.0)
    by_sun = (daylight.direct_normal[chosen] * seen.mean(axis=1)).mean()
    both = make_mean_world(mean)
    found = on_plane(both, normal) - on_plane(sky, normal)
    assert found == pytest.approx(by_sun, rel=3e-3)


def test_the_horizontal_illuminance_is_exactly_that_of_the_file(weather, mean):
    daylight = find_daylight_hours(weather, find_hours(weather, 2026))
    chosen = CHOSEN.holds(weather.month, weather.hour)
    assert mean.diffuse_horizontal == pytest.approx(daylight.diffuse_horizontal[chosen].mean())
    sky = make_mean_world(mean, 0.3, has_sun=False)
    assert on_plane(sky, (0, 0, 1)) == pytest.approx(mean.diffuse_horizontal, rel=1e-4)
    ground = 0.3 * (mean.diffuse_horizontal + mean.direct_horizontal) / np.pi
    both = make_mean_world(mean, 0.3)
    assert float(both.image.pixels[0, 0, 0]) == pytest.approx(ground, rel=1e-5)


def test_the_sun_is_where_it_goes_in_these_hours(weather, mean):
    elevation = np.degrees(np.arcsin(mean.suns[:, 2]))
    azimuth = np.degrees(np.arctan2(mean.suns[:, 0], mean.suns[:, 1])) % 360.0
    # At 49.5 degrees north, 8.5 degrees east: noon of the solstice, and the hours from 9 to 17 of UTC+1.
    assert elevation.max() == pytest.approx(90.0 - 49.5 + 23.44, abs=0.1)
    assert 100.0 < azimuth.min() < 120.0
    assert 260.0 < azimuth.max() < 280.0


def test_dark_hours_count(weather):
    """Night and day together have the light of the day over all hours."""
    day = find_weather_mean(weather, 2026, ClockRange((6, 6), (2.0, 22.0)))
    whole = find_weather_mean(weather, 2026, ClockRange((6, 6)))
    assert whole.diffuse_horizontal * 24.0 == pytest.approx(day.diffuse_horizontal * 20.0, rel=1e-9)
    assert whole.direct_horizontal * 24.0 == pytest.approx(day.direct_horizontal * 20.0, rel=1e-9)


def test_parts_of_a_stretch_add_up(weather):
    parts = [find_weather_mean(weather, 2026, ClockRange((m, m), (8.0, 18.0))) for m in (12, 1, 2)]
    whole = find_weather_mean(weather, 2026, ClockRange((12, 2), (8.0, 18.0)))
    total = sum(each.diffuse_horizontal * each.hours for each in parts)
    assert whole.diffuse_horizontal * whole.hours == pytest.approx(total)


def test_many_patterns_are_those_of_each():
    rng = np.random.default_rng(0)
    directions, _ = hemisphere(6, 12)
    patterns = []
    for _ in range(5):
        sun = np.append(rng.uniform(-1, 1, 2), rng.uniform(0.1, 1.0))
        sky = PerezSky(rng.uniform(1.0, 8.0), rng.uniform(0.05, 0.5), sun, 1.0)
        patterns.append(pattern_of(sky))
    expected = [evaluate(pattern, directions) for pattern in patterns]
    np.testing.assert_allclose(evaluate_all(patterns, directions), expected, rtol=1e-9)


def test_what_no_hour_tells_is_refused(tmp_path):
    path = tmp_path / "few.epw"
    records = [epw_record(2005, 7, day, 12, dni=500, dhi=100) for day in (1, 2)]
    records += [epw_record(2005, 7, 3, 12, dni="9999", dhi=100)]
    records += [
        epw_record(2005, 1, 3, 2, dni=0, dhi=0),
        epw_record(2005, 2, 1, 12, dni="9999", dhi=9),
    ]
    path.write_text(epw(records))
    weather = read_weather(path)
    mean = find_weather_mean(weather, 2026, ClockRange((7, 7)))
    assert mean.hours == 2.0
    assert "1 record lacks" in mean.note
    for months, words in (((5, 5), "no record"), ((1, 1), "give no light"), ((2, 2), "lack")):
        with pytest.raises(SceneError, match=words):
            find_weather_mean(weather, 2026, ClockRange(months))
