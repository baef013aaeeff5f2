"""Sums of light groups at levels that change: those of adding everything up anew."""

import numpy as np
import pytest

from lumenray.engine.accuracy.group_sum import GroupSum


@pytest.fixture
def groups():
    rng = np.random.default_rng(3)
    values = rng.uniform(0.0, 500.0, (5, 200)).astype(np.float32)
    return values, (0.02 * values).astype(np.float32)


def test_levels_that_change_a_thousand_times_give_the_sum_of_the_last_ones(groups):
    values, errors = groups
    made, rng = GroupSum(values, errors), np.random.default_rng(4)
    levels = np.ones(5)
    for _ in range(1000):
        levels[rng.integers(5)] = rng.uniform(0.0, 2.0)
        made.set_levels(levels)
    np.testing.assert_allclose(made.total, levels @ values.astype(float), rtol=1e-12)
    exact = np.sqrt((levels[:, None] ** 2 * errors.astype(float) ** 2).sum(axis=0))
    np.testing.assert_allclose(made.error, exact, rtol=1e-6)
    mean, least, largest = made.describe()
    assert (least, largest) == (made.total.min(), made.total.max())
    assert least < mean < largest


def test_groups_that_are_all_off_give_nothing_at_all(groups):
    made = GroupSum(*groups)
    made.set_levels([0.1, 0.2, 0.3, 0.7, 1.3])
    made.set_levels(np.zeros(5))
    assert not made.total.any()
    assert not made.error.any()
