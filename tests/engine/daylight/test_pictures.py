"""Heat maps and plans: colours stand where the values are."""

from datetime import date, datetime, timedelta

import numpy as np
import pytest

from lumenray.engine.analysis.colour_scale import ColourScale
from lumenray.engine.daylight.heat_map import arrange, draw_heat_map, find_sun_hours
from lumenray.engine.daylight.plan import draw_plan, find_spacing
from lumenray.engine.errors import SceneError
from lumenray.engine.sky.place import Place, from_local, to_local
from lumenray.engine.sky.solar_position import find_day

BERLIN = Place(52.52, 13.4, "Europe/Berlin")
SCALE = ColourScale(0.0, 100.0, "lx")


def hours_of(year, zone, count=8760):
    start = from_local(datetime(year, 1, 1), zone).seconds
    return start + (np.arange(count) + 0.5) * 3600.0


def pixels(picture):
    return np.asarray(picture).astype(int)


def count_of(picture, value):
    return int((np.abs(pixels(picture) - SCALE.colours(value)).sum(axis=-1) < 12).sum())


@pytest.mark.parametrize("dark", [False, True])
def test_a_bright_month_is_where_that_month_is(dark):
    place = Place(0.0, 0.0, "UTC")
    times = hours_of(2025, "UTC")
    clocks = [to_local(t, "UTC") for t in times]
    values = np.where([c.month == 4 and 12 <= c.hour < 18 for c in clocks], 62.5, 0.0)
    picture = draw_heat_map(values, times, place, "April", SCALE, dark=dark)
    hit = np.argwhere(np.abs(pixels(picture) - SCALE.colours(62.5)).sum(axis=-1) < 12)
    # The bar has the colour too, on the right.
    rows, columns = hit[hit[:, 1] < 850].T
    share = np.quantile(columns, [0.02, 0.98])
    left, right = 50 * 440 / 480, 960 - 94 * 440 / 480
    np.testing.assert_allclose((share - left) / (right - left) * 365, [90, 120], atol=2.5)
    top, bottom = 68 * 440 / 480, 440 - 66 * 440 / 480
    hours = 24.0 * (bottom - np.quantile(rows, [0.98, 0.02])) / (bottom - top)
    np.testing.assert_allclose(hours, [12.0, 18.0], atol=0.3)


def test_clocks_that_are_put_forward_leave_an_hour_empty_and_back_share_one():
    times = hours_of(2025, "Europe/Berlin")
    clocks = [to_local(t, "Europe/Berlin") for t in times]
    days = [date(2025, 1, 1) + timedelta(days=k) for k in range(365)]
    values = np.arange(8760.0)
    grid = arrange(values, clocks, days, 1.0)
    assert grid.shape == (24, 365)
    spring, autumn = days.index(date(2025, 3, 30)), days.index(date(2025, 10, 26))
    assert np.argwhere(np.isnan(grid)).tolist() == [[2, spring]]
    assert grid[3, spring] == grid[1, spring] + 1.0
    assert grid[2, autumn] == grid[1, autumn] + 1.5
    assert grid[3, autumn] == grid[1, autumn] + 3.0


def test_quarters_of_an_hour_have_rows_of_their_own():
    times = from_local(datetime(2025, 1, 1), "UTC").seconds + (np.arange(96) + 0.5) * 900.0
    grid = arrange(np.arange(96.0), [to_local(t, "UTC") for t in times], [date(2025, 1, 1)], 0.25)
    np.testing.assert_array_equal(grid[:, 0], np.arange(96.0))


@pytest.mark.parametrize(
    "place",
    [BERLIN, Place(-33.87, 151.21, "Australia/Sydney"), Place(0.0, -78.5, "America/Guayaquil")],
)
def test_lines_of_the_sun_are_those_of_the_days(place):
    days = [date(2025, month, 15) for month in range(1, 13)]
    for day, (rise, noon, down) in zip(days, find_sun_hours(days, place), strict=True):
        exact = find_day(day.year, day.month, day.day, place)
        for hour, seconds in ((rise, exact.rise), (noon, exact.noon), (down, exact.set)):
            clock = to_local(seconds, place.zone)
            assert hour == pytest.approx(
                clock.hour + clock.minute / 60 + clock.second / 3600, abs=0.025
            )


def test_polar_days_have_no_lines():
    hours = find_sun_hours([date(2025, 6, 21), date(2025, 12, 21)], Place(78.0, 15.0, "UTC+1"))
    assert np.isnan(hours[:, [0, 2]]).all()
    assert np.isfinite(hours[:, 1]).all()
    draw_heat_map(
        np.zeros(8760), hours_of(2025, "UTC+1"), Place(90.0, 0.0, "UTC+1"), "Pole", size=(300, 200)
    )


@pytest.mark.parametrize(("year", "count"), [(2024, 8784), (1900, 8760), (2100, 8760)])
def test_years_of_any_length(year, count):
    values = np.full(count, 62.5)
    values[:200] = np.nan
    picture = draw_heat_map(
        values, hours_of(year, "UTC", count), Place(10.0, 0.0), "A year", SCALE, size=(400, 220)
    )
    assert count_of(picture, 62.5) > 20_000


def test_years_without_a_value_are_pictures_too():
    draw_heat_map(
        np.full(10, np.nan), hours_of(2025, "UTC", 10), BERLIN, "Nothing", size=(300, 200)
    )


def test_sensors_lie_on_the_plan_as_in_the_room():
    x, y = np.meshgrid(np.arange(6) * 0.5, np.arange(4) * 0.5)
    points = np.stack([x.ravel(), y.ravel(), np.zeros(24)], axis=1)
    values = np.where((points[:, 0] > 1.0) & (points[:, 1] < 0.4), 62.5, 0.0)
    picture = draw_plan(points, values, "Plan", SCALE, size=(640, 560))
    hit = np.argwhere(np.abs(pixels(picture) - SCALE.colours(62.5)).sum(axis=-1) < 12)
    rows, columns = hit[hit[:, 1] < 520].T
    # Three cells of the lowest row, on the right.
    assert np.ptp(columns) / np.ptp(rows) == pytest.approx(3.0, rel=0.03)
    assert rows.min() > 0.6 * 560
    assert columns.min() > 0.4 * 520


def test_spacing_is_that_of_neighbours():
    rng = np.random.default_rng(3)
    x, y = np.meshgrid(np.arange(40) * 0.25, np.arange(70) * 0.5)
    grid = np.stack([x.ravel(), y.ravel()], axis=1)
    assert find_spacing(rng.permutation(grid)) == pytest.approx(0.25)
    assert find_spacing(grid[:1]) == 1.0
    assert find_spacing(np.repeat(grid[:2], 2, axis=0)) == pytest.approx(0.25)


@pytest.mark.parametrize("points", [[[1.0, 2.0]], [[0.0, 0.0], [0.0, 100.0]], [[1.0, 1.0]] * 3])
def test_odd_plans_are_pictures_too(points):
    draw_plan(points, np.arange(len(points)), "Odd", size=(300, 300), dark=True)
    draw_plan(points, np.full(len(points), np.nan), "Empty", size=(300, 300))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: draw_heat_map([1.0], [0.0, 1.0], BERLIN, ""), "2 hours has 1 values"),
        (lambda: draw_heat_map([], [], BERLIN, ""), "0 hours has 0 values"),
        (lambda: draw_plan([[0.0, 0.0]], [1.0, 2.0], ""), "1 sensors has 2 values"),
        (lambda: draw_plan(np.zeros((0, 3)), [], ""), "places are numbers"),
        (lambda: draw_plan([[np.nan, 0.0]], [1.0], ""), "places are numbers"),
    ],
)
def test_what_cannot_be_drawn_is_refused(call, words):
    with pytest.raises(SceneError, match=words):
        call()
