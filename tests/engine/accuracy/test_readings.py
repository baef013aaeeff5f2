"""Figures of sensors: their values, and how often their ranges hold the true ones."""

import numpy as np
import pytest

from lumenray.engine.accuracy.readings import judge_readings


def test_figures_of_exact_readings_are_exact():
    found = judge_readings([300.0, 400.0, 500.0], [0.0, 0.0, 0.0])
    assert found.mean == pytest.approx(400.0)
    assert found.overall.value == pytest.approx(0.75)
    assert found.diversity.value == pytest.approx(0.6)
    for extreme, value in ((found.least, 300.0), (found.largest, 500.0), (found.overall, 0.75)):
        assert (extreme.low, extreme.high) == pytest.approx((value, value))


def test_dark_sensors_have_figures():
    found = judge_readings(np.zeros(4), np.zeros(4))
    assert (found.mean, found.overall.value, found.diversity.value) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("spread", [0.0, 0.02, 0.3])
@pytest.mark.parametrize("shared", [0.0, 1.0])
def test_ranges_hold_the_true_figures(spread, shared):
    """Readings are means of 16 groups; with ``shared`` noise all sensors err alike."""
    rng = np.random.default_rng(5)
    truth = 400.0 * (1.0 + spread * np.linspace(-1.0, 1.0, 60))
    names = ("mean", "least", "largest", "overall", "diversity")
    exact = dict(
        zip(
            names,
            (truth.mean(), truth.min(), truth.max(), truth.min() / truth.mean(), truth.min() / truth.max()),
            strict=True,
        )
    )  # fmt: skip
    held, runs = dict.fromkeys(names, 0), 600
    for _ in range(runs):
        noise = (1.0 - shared) * rng.standard_normal((16, 60))
        noise += shared * rng.standard_normal((16, 1))
        groups = truth * (1.0 + 0.05 * noise)
        found = judge_readings(groups.mean(axis=0), groups.std(axis=0, ddof=1) / 4.0)
        held["mean"] += abs(found.mean - exact["mean"]) <= 2.131 * found.mean_error
        for name in names[1:]:
            extreme = getattr(found, name)
            held[name] += extreme.low <= exact[name] <= extreme.high
    # 95 % are promised; of 600 runs at 95 % fewer than 553 hold in one of a thousand cases.
    assert min(held.values()) >= 553, held


def test_independent_errors_cancel_in_the_mean():
    values, errors = np.array([300.0, 400.0, 500.0, 400.0]), np.full(4, 6.0)
    assert judge_readings(values, errors).mean_error == pytest.approx(6.0)
    assert judge_readings(values, errors, has_common=False).mean_error == pytest.approx(3.0)
