"""Figures of sensors and areas by closed forms: years whose illuminances are known hour by hour."""

import numpy as np
import pytest

from lumenray.engine.daylight import metrics
from lumenray.engine.daylight.occupancy import CountedHours
from lumenray.engine.errors import SceneError

HOURS = np.ones(1000, bool)
QUARTERS = CountedHours(HOURS, interval=0.25)

RAMP = np.arange(1000.0) + 0.5
"""Each illuminance up to 1000 lx once."""


def test_a_year_that_rises_evenly():
    year = np.stack([RAMP, 4.0 * RAMP, np.full(1000, 300.0), np.zeros(1000)])
    np.testing.assert_allclose(metrics.daylight_autonomy(year, HOURS), [0.7, 1.0 - 0.075, 1.0, 0.0])
    # Below 300 lx the mean of E / 300 is a half.
    np.testing.assert_allclose(
        metrics.continuous_autonomy(year, HOURS), [0.7 + 0.15, 0.925 + 0.0375, 1.0, 0.0]
    )
    np.testing.assert_allclose(
        metrics.useful_illuminance(year, HOURS),
        [
            [0.1, 0.2, 0.7, 0.0],
            [0.025, 0.05, 0.675, 0.25],
            [0.0, 0.0, 1.0, 0.0],
            [1.0, 0.0, 0.0, 0.0],
        ],
    )
    np.testing.assert_allclose(metrics.mean_illuminance(year, HOURS), [500.0, 2000.0, 300.0, 0.0])
    np.testing.assert_allclose(metrics.light_exposure(year, QUARTERS)[0], 500.0 * 250.0)
    np.testing.assert_allclose(metrics.hours_above(year, QUARTERS, 300.0), [175.0, 231.25, 0, 0])


def test_only_hours_of_the_mask_count():
    hours = RAMP > 500.0
    year = np.stack([RAMP, RAMP])
    year[:, ~hours] = np.nan
    np.testing.assert_allclose(metrics.daylight_autonomy(year, hours, 750.0), 0.5)
    np.testing.assert_allclose(metrics.mean_illuminance(year, hours), 750.0)


def test_hours_without_light_count_though_they_have_no_column():
    rng = np.random.default_rng(6)
    year = rng.gamma(1.0, 700.0, (4, 2000)) * (rng.uniform(size=2000) < 0.5)
    counts = rng.uniform(size=2000) < 0.4
    lit = np.flatnonzero(year.any(axis=0))
    hours = CountedHours.of_year(counts, lit)
    assert hours.count == np.count_nonzero(counts)
    for figure in (
        metrics.daylight_autonomy,
        metrics.continuous_autonomy,
        metrics.useful_illuminance,
        metrics.mean_illuminance,
        metrics.light_exposure,
    ):
        np.testing.assert_allclose(
            figure(year[:, lit], hours), figure(year, counts), rtol=1e-12, atol=1e-15
        )
    np.testing.assert_array_equal(
        metrics.hours_above(year[:, lit], hours, 300.0), metrics.hours_above(year, counts, 300.0)
    )


def test_years_in_which_no_counted_hour_has_light_are_dark():
    hours = CountedHours(np.zeros(5, bool), dark=10)
    year = np.ones((2, 5))
    assert metrics.daylight_autonomy(year, hours).tolist() == [0.0, 0.0]
    assert metrics.useful_illuminance(year, hours)[:, 0].tolist() == [1.0, 1.0]
    assert metrics.mean_illuminance(year, hours).tolist() == [0.0, 0.0]


def test_bounds_belong_to_what_suffices():
    year = np.array([[100.0, 300.0, 3000.0, 99.999, 299.99, 3000.1]])
    np.testing.assert_allclose(
        metrics.useful_illuminance(year, np.ones(6, bool)) * 6, [[1, 2, 2, 1]]
    )
    np.testing.assert_allclose(
        metrics.useful_illuminance(year, np.ones(6, bool), (100.0, 500.0, 2000.0)) * 6,
        [[1, 3, 0, 2]],
    )


def test_single_precision_sums_in_double():
    year = np.full((1, 8760), 16_777_217.0, dtype=np.float32)
    year[0, 1::2] = 1.0
    expected = (16_777_216.0 + 1.0) * 4380
    assert metrics.light_exposure(year, np.ones(8760, bool))[0] == expected


def test_areas_weigh():
    values, areas = np.array([1.0, 2.0, 3.0]), np.array([1.0, 1.0, 2.0])
    assert metrics.area_mean(values, areas) == 2.25
    assert metrics.area_median(values, areas) == 2.5
    assert metrics.area_share(values, 2.0, areas) == 0.75
    assert metrics.area_share_above(values, 2.0, areas) == 0.5
    assert metrics.area_exceeded(values, 0.95, areas) == 1.0
    assert metrics.uniformity(values, areas) == pytest.approx(1.0 / 2.25)
    # Who stands for nothing has no say.
    assert metrics.area_least(np.array([0.0, *values]), np.array([0.0, *areas])) == 1.0


@pytest.mark.parametrize("count", [1, 2, 7, 100])
def test_median_of_even_areas_is_that_of_the_values(count):
    values = np.random.default_rng(count).normal(size=count)
    assert metrics.area_median(values) == np.median(values)


def test_dark_rooms_have_no_uniformity():
    assert metrics.uniformity(np.zeros(3)) == 0.0


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: metrics.daylight_autonomy(RAMP, HOURS), "do not fit 1000 hours"),
        (lambda: metrics.daylight_autonomy(RAMP[None], HOURS[1:]), "do not fit 999 hours"),
        (lambda: metrics.daylight_autonomy(RAMP[None], ~HOURS), "no hour of the year counts"),
        (
            lambda: metrics.daylight_autonomy(np.full((1, 1000), np.nan), HOURS),
            "an illuminance of an hour that counts is missing",
        ),
        (
            lambda: metrics.useful_illuminance(RAMP[None], HOURS, (300.0, 100.0, 3000.0)),
            "do not ascend",
        ),
        (lambda: metrics.daylight_autonomy(RAMP[None], HOURS, 0.0), "is 0.0 lx, expected above 0"),
        (lambda: metrics.area_mean([1.0, 2.0], [1.0]), "2 sensors have 1 areas"),
        (lambda: metrics.area_mean([1.0, 2.0], [1.0, -1.0]), "not numbers of at least 0"),
        (lambda: metrics.area_mean([1.0, 2.0], [0.0, 0.0]), "or all 0"),
        (lambda: metrics.area_mean([], []), "0 sensors have 0 areas"),
    ],
)
def test_what_cannot_be_is_refused(call, words):
    with pytest.raises(SceneError, match=words):
        call()
