"""Estimates: their stated errors."""

import numpy as np
import pytest

from lumenray.engine.accuracy.estimate import Accumulator, Estimate


def test_the_error_of_two_halves_is_half_their_difference():
    made = Estimate.from_groups(np.array([[3.0, 10.0], [5.0, 10.0]]), 64)
    assert made.mean.tolist() == [4.0, 10.0]
    assert made.standard_error.tolist() == [1.0, 0.0]


def test_the_stated_error_is_calibrated_for_known_noise():
    rng = np.random.default_rng(1)
    sums = Accumulator(2, 20000)
    for _ in range(8):
        sums.add(rng.normal(10.0, 3.0, (2, 20000, 4)).sum(axis=2), 4)
    made = sums.estimate()
    true = 3.0 / np.sqrt(64)
    assert made.samples == 64
    assert made.relative_error() == pytest.approx(true / 10.0, rel=0.02)
    assert np.std(made.mean) == pytest.approx(true, rel=0.02)


def test_relative_error_weighs_by_area():
    made = Estimate(np.array([1.0, 3.0]), np.array([1.0, 0.0]), 2)
    assert made.relative_error(np.array([1.0, 3.0])) == pytest.approx(0.5 / 2.5)
    assert Estimate(np.zeros(2), np.zeros(2), 2).relative_error() == float("inf")
