"""Errors by balanced replicates: those of the textbook where figures are linear, and intervals that hold the truth."""

import math

import numpy as np
import pytest

from lumenray.engine.accuracy.estimate import Estimate
from lumenray.engine.accuracy.student import t_quantile
from lumenray.engine.daylight import lm83, metrics
from lumenray.engine.daylight.replicated import (
    MetricEstimate,
    balanced_signs,
    estimate,
    find_by_sensor,
    over_area,
    perturb,
    with_error,
)
from lumenray.engine.errors import SceneError


@pytest.mark.parametrize("count", [2, 3, 8, 12, 16])
def test_signs_are_balanced(count):
    signs = balanced_signs(count)
    assert set(np.unique(signs)) <= {-1.0, 1.0}
    np.testing.assert_array_equal(signs.T @ signs, len(signs) * np.eye(count))


@pytest.mark.parametrize("count", [2, 5, 16])
def test_linear_figures_have_the_error_of_a_mean(count):
    rng = np.random.default_rng(count)
    replicates = rng.normal(400.0, 50.0, (count, 3, 40))
    weights = rng.uniform(size=40)
    versions = perturb(replicates)
    made = with_error(lambda e: e @ weights, versions[0], versions[1:], count - 1)
    expected = Estimate.from_groups(replicates @ weights, count)
    np.testing.assert_allclose(made.value, expected.mean, rtol=1e-12)
    np.testing.assert_allclose(made.standard_error, expected.standard_error, rtol=1e-10)
    low, high = made.interval()
    reach = t_quantile(0.975, count - 1) * expected.standard_error
    np.testing.assert_allclose(high - low, 2.0 * reach, rtol=1e-9)


def test_smooth_figures_have_the_error_of_their_slope():
    rng = np.random.default_rng(4)
    versions = perturb(rng.normal(500.0, 2.0, (16, 1, 10)))
    made = with_error(lambda e: np.log(e).sum(), versions[0], versions[1:], 15)
    slope = with_error(lambda e: (e / versions[0]).sum(), versions[0], versions[1:], 15)
    assert made.standard_error == pytest.approx(float(slope.standard_error), rel=1e-2)


def test_a_step_that_nothing_crosses_is_not_known_better_than_a_step():
    versions = perturb(np.random.default_rng(1).normal(500.0, 1.0, (16, 4, 3650)))
    hours = np.ones(3650, bool)
    made = with_error(
        lambda e: metrics.daylight_autonomy(e, hours), versions[0], versions[1:], 15, 1.0 / 3650
    )
    np.testing.assert_array_equal(made.value, 1.0)
    low, _ = made.interval()
    np.testing.assert_allclose(1.0 - low, 1.0 / 3650, rtol=1e-9)


def test_exact_values_have_no_error():
    made = MetricEstimate.exact([1.0, 2.0])
    assert made.interval()[0].tolist() == made.interval()[1].tolist() == [1.0, 2.0]
    assert made.freedom == math.inf


def test_blocks_of_sensors_give_what_all_at_once_give():
    rng = np.random.default_rng(7)
    versions = perturb(rng.gamma(2.0, 200.0, (8, 50, 200)))
    hours = rng.uniform(size=200) < 0.5
    figures = {
        "autonomy": lambda e: metrics.daylight_autonomy(e, hours),
        "useful": lambda e: metrics.useful_illuminance(e, hours),
    }
    in_use, most = 0, 0

    def block(start):
        nonlocal in_use, most
        for version in versions[:, start : start + 16]:
            in_use += 1
            most = max(most, in_use)
            yield version
            in_use -= 1

    made = find_by_sensor(figures, (block(start) for start in range(0, 50, 16)))
    for name, figure in figures.items():
        np.testing.assert_array_equal(made[name], [figure(version) for version in versions])
    assert made["autonomy"].shape == (9, 50)
    assert made["useful"].shape == (9, 50, 4)
    assert most == 1
    whole = over_area(metrics.area_mean, made["autonomy"], 7)
    direct = with_error(
        lambda e: metrics.area_mean(figures["autonomy"](e)), versions[0], versions[1:], 7
    )
    assert whole.standard_error == direct.standard_error


# ---- what the errors promise ----

SENSORS, HOURS, PATCHES, REPLICATES = 60, 600, 24, 16


def make_truth(seed: int):
    """Coefficients (sensors, patches) of a room that gets darker away from its window, and skies (patches, hours)."""
    rng = np.random.default_rng([28, seed])
    depth = np.linspace(0.0, 1.0, SENSORS)[:, None]
    coefficients = 0.03 * np.exp(-2.2 * depth) * rng.uniform(0.3, 1.7, (SENSORS, PATCHES))
    level = rng.gamma(2.0, 900.0, HOURS)
    skies = level * rng.uniform(0.2, 1.8, (PATCHES, HOURS))
    return rng, coefficients, skies


EVERY = np.ones(HOURS, bool)

FIGURES = {
    "mean": lambda e: metrics.area_mean(metrics.mean_illuminance(e, EVERY)),
    "autonomy of a sensor": lambda e: metrics.daylight_autonomy(e, EVERY)[20],
    "continuous autonomy of a sensor": lambda e: metrics.continuous_autonomy(e, EVERY)[20],
    "useful daylight of a sensor": lambda e: metrics.useful_illuminance(e, EVERY)[20, 2],
    "mean autonomy": lambda e: metrics.area_mean(metrics.daylight_autonomy(e, EVERY)),
    "median autonomy": lambda e: metrics.area_median(metrics.daylight_autonomy(e, EVERY)),
    "area with autonomy": lambda e: lm83.spatial_autonomy(metrics.daylight_autonomy(e, EVERY)),
    "uniformity": lambda e: metrics.uniformity(metrics.mean_illuminance(e, EVERY)),
}

STEPS = {
    "autonomy of a sensor": 1.0 / HOURS,
    "useful daylight of a sensor": 1.0 / HOURS,
    "area with autonomy": 1.0 / SENSORS,
}


@pytest.mark.parametrize("name", FIGURES)
def test_intervals_hold_the_truth_as_often_as_they_say(name):
    """100 rooms, each computed with noise of 60 % in each coefficient of a replicate, 15 % in the mean."""
    figure, held = FIGURES[name], 0
    for seed in range(100):
        rng, coefficients, skies = make_truth(seed)
        noise = rng.gamma(1.0 / 0.36, 0.36, (REPLICATES, *coefficients.shape))
        versions = perturb(coefficients * noise)
        made = estimate(
            [figure(version @ skies) for version in versions], REPLICATES - 1, STEPS.get(name, 0.0)
        )
        low, high = made.interval()
        held += bool(low <= figure(coefficients @ skies) <= high)
    assert 90 <= held <= 99


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: balanced_signs(1), "1 replicate tells nothing of an error"),
        (lambda: estimate([[1.0]], 1.0), "needs replicates beside the mean"),
        (lambda: estimate([1.0, 2.0], 0.0), "needs replicates beside the mean"),
        (lambda: find_by_sensor({"a": np.sum}, []), "no sensor whose year can be judged"),
        (
            lambda: find_by_sensor(
                {"a": lambda e: e[:, 0]}, [np.ones((3, 2, 4)), np.ones((4, 2, 4))]
            ),
            "different numbers of replicates",
        ),
    ],
)
def test_what_cannot_be_is_refused(call, words):
    with pytest.raises(SceneError, match=words):
        call()
