"""Two estimates side by side, and errors that stem from few samples: statistics alone."""

from types import SimpleNamespace

import numpy as np
import pytest

from lumenray.engine.accuracy.tails import tail_factor
from lumenray.engine.accuracy.uneven_sums import UnevenSums
from lumenray.engine.accuracy.witnesses import batch_error, compare

BATCHES = 32


def witnesses(truth, first_error, second_error, seed, missing=0.0):
    """Two estimates of the same values, the second with errors by batches; the first lacks a part."""
    draw = np.random.default_rng(seed)
    first = truth - missing + first_error * draw.normal(size=truth.shape)
    spread = second_error * np.sqrt(BATCHES)
    batches = truth + spread * draw.normal(size=(BATCHES, *truth.shape))
    return first, batches.mean(axis=0), batch_error(batches)


def test_estimates_that_differ_by_chance_are_left_alone():
    """Four thousand comparisons of twenty values: about one in ten thousand lots may be blamed."""
    truth, blamed = np.full(20, 100.0), 0
    for seed in range(200):
        first, second, error = witnesses(truth, 0.3, 1.0, seed)
        blamed += not compare(first, np.full(20, 0.3), second, error, BATCHES - 1.0, truth).agrees
    assert blamed <= 1


def test_doubt_is_seldom_where_all_is_well_and_sure_where_a_difference_is_near_to_be_seen():
    truth, doubts = np.full(20, 100.0), np.zeros((2, 200))
    for seed in range(200):
        for row, missing in enumerate((0.0, np.arange(20) == 3)):
            first, second, error = witnesses(truth, 0.3, 1.0, seed, 4.5 * missing)
            own = np.full(20, 0.3)
            made = compare(first, own, second, error, BATCHES - 1.0, truth, doubt=0.2)
            doubts[row, seed] = made.is_doubtful or not made.agrees
    # About normal, for 21 comparisons: binomial within three standard deviations.
    assert doubts[0].mean() == pytest.approx(0.2, abs=3.0 * np.sqrt(0.16 / 200))
    assert doubts[1].mean() > 0.85


def test_a_value_that_lacks_light_gets_the_difference_as_its_error():
    missing = np.zeros(20)
    missing[7] = 12.0
    first, second, error = witnesses(np.full(20, 100.0), 0.3, 1.0, 1, missing)
    made = compare(first, np.full(20, 0.3), second, error, BATCHES - 1.0, np.ones(20))
    assert made.differs.tolist() == [number == 7 for number in range(20)]
    assert made.floor[7] == pytest.approx(12.0, abs=4.0)
    assert made.floor[:7].sum() == 0.0 == made.rest


def test_what_no_value_shows_alone_is_found_in_the_mean():
    first, second, error = witnesses(np.full(400, 100.0), 0.1, 1.0, 1, 1.0)
    made = compare(first, np.full(400, 0.1), second, error, BATCHES - 1.0, np.ones(400))
    assert not made.differs.any()
    assert made.rest == pytest.approx(1.0, abs=0.25)
    np.testing.assert_allclose(made.floor, made.rest)


def test_a_witness_that_may_have_missed_light_does_not_blame_what_found_it():
    ones = np.ones(3)
    args = (ones * 0.1, BATCHES - 1.0, ones)
    less = compare(10 * ones, 0.1 * ones, 5 * ones, *args, hidden=5.0)
    more = compare(10 * ones, 0.1 * ones, 15 * ones, *args, hidden=5.0)
    assert less.agrees
    assert more.differs.all()


def test_a_first_that_is_uncertain_itself_gives_way_soon():
    """Ten of an error of seven beside 46.3 of 0.1: five standard errors, which few passes cannot rule out."""
    made = compare([10.1], [6.8], [46.3], [0.1], BATCHES - 1.0, [1.0])
    assert made.floor[0] == pytest.approx(36.2)


def test_errors_that_are_not_known_are_not_compared():
    made = compare([1.0, 1.0], [np.inf, 0.1], [9.0, 9.0], [0.1, 0.1], BATCHES - 1.0, [1.0, 1.0])
    assert made.differs.tolist() == [False, True]


# ---- heavy tails ----


def estimate_of(samples):
    """Estimate of a value from samples (groups, n)."""
    sums, halves = UnevenSums(len(samples), 1, 1), np.array(np.split(samples, 2))
    tails = np.stack([(halves**2).sum(axis=(1, 2)), (halves**2).max(axis=(1, 2))])
    none = np.zeros(2, dtype=np.int64)
    sums.add(np.arange(2), none, samples.shape[1], halves.sum(axis=2)[..., None], tails, none)
    made = sums.estimate()
    return made.mean.item(), made.standard_error.item()


@pytest.mark.parametrize("expected", [5.0, 7.0])
def test_a_mean_from_few_large_samples_holds_the_truth_as_often_as_others(expected):
    """Rare events of one size on an even ground: within two errors 95 % of the time, without the factor 90 %."""
    held, plain, count = 0, 0, 2000
    draw = np.random.default_rng(5)
    for _ in range(count):
        samples = 1e-3 * draw.random((16, 256))
        hits = draw.random(samples.shape) < expected / samples.size
        # An event at least, or there is nothing that could be heavy.
        hits.flat[draw.integers(samples.size)] |= not hits.any()
        samples[hits] = 1.0
        mean, error = estimate_of(samples)
        groups = samples.mean(axis=1)
        truth = expected / samples.size + 5e-4
        held += abs(mean - truth) < 2.0 * error
        plain += abs(mean - truth) < 2.0 * groups.std(ddof=1) / 4.0
    assert held / count > 0.94
    assert plain / count < held / count - 0.03


def test_errors_of_ordinary_samples_stay_as_they_are():
    draw = np.random.default_rng(1)
    for samples in (draw.exponential(size=(16, 1024)), draw.random((16, 16)), np.ones((16, 4))):
        groups = samples.mean(axis=1)
        assert estimate_of(samples)[1] == pytest.approx(groups.std(ddof=1) / 4.0, abs=1e-15)


def test_a_single_part_makes_an_error_worth_less_than_half():
    assert tail_factor(1.0, 1.0, 1000) == pytest.approx(1.0 + np.sqrt(1.75))
    assert tail_factor(1.0, 0.05, 1000) == 1.0
    assert tail_factor(1.0, 0.25, 4) == 1.0
    assert tail_factor(0.0, 0.0, 4) == 1.0


@pytest.mark.mitsuba
def test_an_error_of_a_map_that_a_single_lumel_makes_is_not_trusted():
    from lumenray.engine.transport import backend

    backend.start(spectral=False)
    from lumenray.engine.baking.estimates import find_whole

    survey = SimpleNamespace(area=np.ones(1000), valid=np.ones(1000, dtype=bool))
    error = np.full(1000, 1e-3)
    even, spike = (
        SimpleNamespace(illuminance=np.ones(1000), standard_error=error.copy(), surplus=np.zeros(1))
        for _ in range(2)
    )
    spike.standard_error[7] = 10.0
    table = SimpleNamespace(survey=survey)
    assert find_whole(even, table)[2] == pytest.approx(1e-3)
    one = 10.0 / np.sqrt(1000.0)
    assert find_whole(spike, table)[2] == pytest.approx((1.0 + np.sqrt(1.75)) * one, rel=1e-3)


@pytest.mark.parametrize(("paths", "blames"), [(6.0, False), (9.0, False), (13.0, True)])
def test_a_few_heavy_paths_that_all_missed_blame_nobody(paths, blames):
    """Six of them all miss once in 400 times, thirteen once in 400 000: less than what is asked for."""
    made = compare([3000.0], [6.0], [0.0], [0.0], 31.0, [1.0], 3000.0 / paths)
    assert made.differs.tolist() == [blames]
    assert made.floor.tolist() == [3000.0 if blames else 0.0]
    # Light that it has found itself, no path can have missed.
    assert compare([0.0], [6.0], [3000.0], [1.0], 31.0, [1.0], 3000.0 / paths).differs.all()


def test_quantities_that_share_all_their_paths_are_as_uncertain_together_as_alone():
    random, count, blamed = np.random.default_rng(7), 48, {"shared": 0, "apart": 0}
    for _ in range(400):
        shared = 10.0 + random.standard_normal((32, 1)) * np.ones(count)
        first, none = np.full(count, 10.0), np.zeros(count)
        error = shared.std(axis=0, ddof=1) / np.sqrt(32)
        args = (first, none, shared.mean(axis=0), error, 31.0, np.ones(count), 0.0)
        blamed["shared"] += not compare(*args, shared).agrees
        blamed["apart"] += not compare(*args).agrees
    assert blamed["shared"] <= 1
    # What it would be if the errors were taken for independent ones.
    assert blamed["apart"] > 40
