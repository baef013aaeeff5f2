"""Sums by kind of sample: the light is the sum of the kinds' means, and who is worth most gets more."""

import numpy as np
import pytest

from lumenray.engine.transport.sensors.kind_sums import SPREAD, KindSums

CHEAP, DEAR = 0, 3
GROUPS, COUNT = 16, 40


def filled(scatter, counts, costs=None, seed=1):
    """Sums of normal samples about 1, with such a scatter of a sample and so many of them in a group, by kind."""
    draw = np.random.default_rng(seed)
    sums = KindSums(costs or {CHEAP: 1.0, DEAR: 4.0}, GROUPS, COUNT, 1, 0)
    for kind, many in counts.items():
        for group in range(GROUPS):
            samples = 1.0 + scatter[kind] * draw.normal(size=(COUNT, many))
            squares = samples**2
            tails = np.stack([squares.sum(axis=1), squares.max(axis=1)])
            lost = np.zeros(COUNT, dtype=np.int64)
            sums.add(kind, group, slice(0, COUNT), samples.sum(axis=1)[:, None], tails, lost)
    sums.extend(counts)
    return sums


def test_means_add_up_and_errors_are_those_of_all_kinds_together():
    scatter, counts = {CHEAP: 0.5, DEAR: 2.0}, {CHEAP: 64, DEAR: 256}
    made = filled(scatter, counts).estimate()
    square = sum(scatter[kind] ** 2 / (GROUPS * counts[kind]) for kind in counts)
    assert made.mean.mean() == pytest.approx(2.0, abs=4.0 * np.sqrt(square / COUNT))
    assert np.sqrt((made.standard_error**2).mean()) == pytest.approx(np.sqrt(square), rel=0.15)
    assert made.samples == round(GROUPS * (64 + 4.0 * 256) / 5.0)


@pytest.mark.parametrize(
    ("scatter", "chosen"),
    [((1.0, 100.0), [DEAR]), ((100.0, 1.0), [CHEAP]), ((1.0, 2.0), [CHEAP, DEAR])],
)
def test_the_kind_gets_more_that_lowers_the_error_most_for_its_cost(scatter, chosen):
    sums = filled(dict(zip((CHEAP, DEAR), scatter, strict=True)), {CHEAP: 64, DEAR: 64})
    assert sums.choose(np.ones(COUNT)) == chosen


def test_a_kind_that_has_next_to_nothing_gets_more_whatever_it_seems_to_be_worth():
    sums = filled({CHEAP: 0.0, DEAR: 1.0}, {CHEAP: 2, DEAR: 4 * SPREAD})
    assert CHEAP in sums.choose(np.ones(COUNT))


def test_lost_samples_are_a_share_of_their_kind():
    sums = filled({CHEAP: 1.0, DEAR: 1.0}, {CHEAP: 64, DEAR: 256})
    sums.lost[CHEAP][3] = 32
    sums.lost[DEAR][3] = 4
    shares = sums.lost_shares()
    assert shares[3] == pytest.approx(32 / (64 * GROUPS))
    assert not np.delete(shares, 3).any()
