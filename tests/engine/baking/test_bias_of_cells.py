"""What cells add to means, by comparisons with full paths in some of the passes."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from lumenray.engine.accuracy.history import History, Mark, ended
from lumenray.engine.baking.means import _bias, _mean_error


def sums_of(passes):
    """As layers keep them, of lists of differences by pass."""
    parts = [np.asarray(each, dtype=float) for each in passes if len(each)]
    every = np.concatenate([*parts, np.zeros(0)])
    squares = sum(each.sum() ** 2 / len(each) for each in parts)
    return [len(every), every.sum(), (every**2).sum(), len(parts), squares]


def test_an_object_that_was_not_compared_has_an_unknown_bias():
    rows = np.array([sums_of([[0.1, 0.2], [0.3]]), sums_of([]), sums_of([[0.4]])]).T
    assert math.isfinite(_bias(rows, 0)[1])
    assert _bias(rows, 1) == (0.0, math.inf)
    assert _bias(rows, 2) == (0.0, math.inf)
    # Full paths need no comparison.
    assert _bias(np.zeros((5, 2)), 0) == (0.0, 0.0)


def test_what_all_of_a_pass_share_is_part_of_the_error():
    random = np.random.default_rng(2)
    off, stated = [], []
    for _ in range(300):
        passes = [random.normal(random.normal(0.0, 1.0), 1.0, 500) for _ in range(4)]
        mean, error = _bias(np.array([sums_of(passes)]).T, 0)
        off.append(mean)
        stated.append(error)
    # Of 2000 differences that owed each other nothing it would be 0.03.
    assert np.sqrt(np.mean(np.square(stated))) == pytest.approx(np.std(off), rel=0.15)


def test_error_over_time_ends_at_what_is_stated():
    history = History((Mark(1.0, 8.0, 0.2, 4.0), Mark(4.0, 32.0, 0.1, 4.0)), 0.1)
    assert [mark.error for mark in ended(history, 0.3).marks] == [0.2, 0.1, 0.3]
    assert ended(history, 0.1) is history
    assert ended(History(), 0.3) == History()


def test_an_object_that_light_reaches_nowhere_has_no_scatter():
    """All of a plate inside a solid: it ended in a division by 0."""
    passes = np.array([[8.0, 0.0], [8.0, 0.0]])
    sums = SimpleNamespace(variance=lambda rows: np.zeros(len(rows)))
    state = SimpleNamespace(object_passes=passes, sums=sums)
    assert _mean_error([state], 0, np.zeros(0, dtype=int), np.zeros(0)) == 0.0
