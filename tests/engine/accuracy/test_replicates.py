import numpy as np
import pytest
from scipy import stats

from lumenray.engine.accuracy.replicates import ReplicateSums
from lumenray.engine.accuracy.student import t_quantile
from lumenray.engine.errors import SceneError


def summed(replicates, weights):
    """Sums over replicates (R, n) of weights (R, n) or (R, 1)."""
    sums = ReplicateSums(replicates.shape[1])
    for values, weight in zip(replicates, np.broadcast_to(weights, replicates.shape), strict=True):
        sums.add(0, values, weight)
        sums.end_pass()
    return sums


def test_equal_weights_give_the_textbook_standard_error():
    values = 1e5 + np.random.default_rng(1).normal(size=(9, 50))
    sums = summed(values, 16)
    assert np.allclose(sums.mean(), values.mean(axis=0), rtol=1e-14)
    assert np.allclose(sums.standard_error(), values.std(axis=0, ddof=1) / 3.0, rtol=1e-6)
    assert np.allclose(sums.even(), values[0::2].mean(axis=0), rtol=1e-14)
    assert np.allclose(sums.odd(), values[1::2].mean(axis=0), rtol=1e-14)
    assert sums.degrees_of_freedom == 8.0
    assert (sums.samples() == 9 * 16).all()


@pytest.mark.parametrize("is_even", [False, True])
def test_joined_sums_are_those_of_all_passes(is_even):
    rng = np.random.default_rng(9)
    values = 1e3 + rng.normal(size=(11, 30))
    weights = np.full((11, 30), 8) if is_even else rng.integers(1, 9, (11, 30))
    parts = []
    for passes in (slice(0, 4), slice(4, 6), slice(6, 11)):
        sums = ReplicateSums(30, 2, is_even=is_even)
        for row, weight in zip(values[passes], weights[passes], strict=True):
            sums.add(0, np.stack([row, 2.0 * row], axis=1), weight)
            sums.end_pass()
        parts.append(sums)
    joined = parts[0]
    for part in parts[1:]:
        joined.join(part)
    whole = summed(values, weights)
    assert joined.passes == 11
    assert np.allclose(joined.mean(), whole.mean(), rtol=1e-6)
    assert np.allclose(joined.further_means()[:, 0], 2.0 * whole.mean(), rtol=1e-6)
    assert np.allclose(joined.variance(), whole.variance(), rtol=2e-3)
    assert np.allclose(joined.replicates(), whole.replicates(), rtol=1e-6)
    # All passes 0, 2, 4 and so on within their parts, which here begin with even ones.
    even = [0, 2, 4, 6, 8, 10]
    expected = (weights[even] * values[even]).sum(axis=0) / weights[even].sum(axis=0)
    assert np.allclose(joined.even(), expected, rtol=1e-6)


def test_even_sums_take_in_uneven_ones():
    rng = np.random.default_rng(10)
    values, weights = rng.normal(5.0, 1.0, (6, 20)), rng.integers(1, 9, (6, 20))
    weights[:3] = 4
    joined = ReplicateSums(20, is_even=True)
    for row in values[:3]:
        joined.add(0, row, 4)
        joined.end_pass()
    joined.join(summed(values[3:], weights[3:]))
    whole = summed(values, weights)
    assert np.allclose(joined.mean(), whole.mean(), rtol=1e-6)
    assert np.allclose(joined.variance(), whole.variance(), rtol=1e-3)
    with pytest.raises(SceneError, match="21 values cannot be joined"):
        joined.join(ReplicateSums(21))


def test_uneven_weights_follow_the_formula():
    rng = np.random.default_rng(2)
    values, weights = rng.normal(5.0, 1.0, (12, 40)), rng.integers(0, 9, (12, 40))
    weights[:2] += 1
    sums = summed(values, weights)
    total, squares = weights.sum(axis=0), (weights**2).sum(axis=0)
    mean = (weights * values).sum(axis=0) / total
    variance = (weights**2 * (values - mean) ** 2).sum(axis=0) / (total**2 - squares)
    assert np.allclose(sums.mean(), mean, rtol=1e-12)
    assert np.allclose(sums.variance(), variance, rtol=1e-4)
    assert np.allclose(sums.replicates(), total**2 / squares)


def test_nothing_is_known_of_the_error_of_one_replicate():
    sums = ReplicateSums(3)
    assert np.isinf(sums.standard_error()).all()
    assert (sums.mean() == 0.0).all()
    assert sums.degrees_of_freedom == 0.0
    sums.add(0, np.array([1.0, 2.0, 3.0]), 4)
    sums.end_pass()
    assert np.isinf(sums.standard_error()).all()
    # The second pass leaves the last value out.
    sums.add(0, np.array([3.0, 2.0, 0.0]), np.array([4, 4, 0]))
    sums.end_pass()
    assert np.allclose(sums.standard_error(), [1.0, 0.0, np.inf])
    assert np.allclose(sums.mean(), [2.0, 2.0, 3.0])


def test_values_may_be_added_block_by_block_with_further_channels():
    rng = np.random.default_rng(3)
    values, weights = rng.random((5, 10, 4)), rng.integers(1, 9, (5, 10))
    whole, blocks = ReplicateSums(10, 4), ReplicateSums(10, 4)
    for means, weight in zip(values, weights, strict=True):
        whole.add(0, means, weight)
        blocks.add(4, means[4:], weight[4:])
        blocks.add(0, means[:4], weight[:4])
        for sums in (whole, blocks):
            sums.end_pass()
    expected = (values * weights[..., None]).sum(axis=0) / weights.sum(axis=0)[:, None]
    assert np.allclose(whole.further_means(), expected[:, 1:], rtol=1e-5)
    assert np.allclose(whole.mean(), expected[:, 0], rtol=1e-12)
    for name, array in whole.state().items():
        assert array.tobytes() == blocks.state()[name].tobytes()


def test_a_state_goes_on_as_if_nothing_had_happened():
    rng = np.random.default_rng(4)
    values, weights = rng.random((7, 20)), rng.integers(1, 50, (7, 20))
    through, first = summed(values, weights), summed(values[:3], weights[:3])
    again = ReplicateSums.from_state({name: a.copy() for name, a in first.state().items()})
    for means, weight in zip(values[3:], weights[3:], strict=True):
        again.add(0, means, weight)
        again.end_pass()
    for name, array in through.state().items():
        assert array.tobytes() == again.state()[name].tobytes()


@pytest.mark.parametrize("name", ["sums", "weights", "squares", "passes", "further"])
def test_a_state_that_does_not_fit_together_is_refused(name):
    state = ReplicateSums(5, 2).state()
    for broken in (None, np.zeros(3, dtype=np.float32), np.full_like(state[name], -1)[None]):
        changed = {key: value for key, value in state.items() if key != name}
        if broken is not None:
            changed[name] = broken
        with pytest.raises(SceneError, match="the state of the sums"):
            ReplicateSums.from_state(changed)


LUMELS, TRUTH = 20_000, 3.0


def normal(rng, count, weight):
    """Means of ``weight`` samples each; the error falls as that of plain random numbers."""
    return rng.normal(TRUTH, 1.0 / np.sqrt(weight), (count, LUMELS))


def skewed(rng, count, weight):
    """Means of exponential samples, of skewness 2 / sqrt(weight)."""
    return TRUTH + rng.gamma(weight, 1.0 / weight, (count, LUMELS)) - 1.0


def smooth(rng, count, weight):
    """Means of low-discrepancy samples: the variance falls as weight^-2.5."""
    return rng.normal(TRUTH, weight**-1.25, (count, LUMELS))


@pytest.mark.parametrize("kind", [normal, skewed, smooth])
@pytest.mark.parametrize("passes", [(4, 0), (4, 4), (4, 28), (16, 0)])
def test_stated_errors_are_right_after_a_pilot_and_more_passes(kind, passes):
    """Passes of the pilot have 8 samples, the others 4 times as many: the stated error is that of the spread over lumels."""
    rng = np.random.default_rng(5)
    first, second = kind(rng, passes[0], 8.0), kind(rng, passes[1], 32.0)
    weights = np.repeat([8.0, 32.0], passes)[:, None]
    sums = summed(np.concatenate([first, second]), weights)
    mean, error = sums.mean(), sums.standard_error()
    true = np.sqrt(np.mean((mean - TRUTH) ** 2))
    # No bias of the mean beyond four of its own standard errors.
    assert abs(mean.mean() - TRUTH) < 4.0 * true / np.sqrt(LUMELS)
    # Where errors fall much faster than samples count, few passes beside a pilot leave a known surplus of 8 %.
    near = 0.1 if kind is smooth else 0.03
    assert np.sqrt(np.mean(error**2)) == pytest.approx(true, rel=near)
    reach = stats.t.ppf(0.975, sums.degrees_of_freedom) * error
    share = (np.abs(mean - TRUTH) <= reach).mean()
    assert 0.93 < share < (0.99 if kind is smooth else 0.97)


@pytest.mark.parametrize("freedom", [1.0, 1.5, 2.0, 3.0, 7.0, 15.3, 63.0, 1e3, 9.9e4, 1e7, np.inf])
def test_quantiles_are_those_of_scipy(freedom):
    for probability in (0.005, 0.5, 0.6, 0.9, 0.975, 0.9995):
        expected = stats.t.ppf(probability, freedom)
        assert t_quantile(probability, freedom) == pytest.approx(expected, rel=1e-8, abs=1e-9)


def test_quantiles_are_those_of_the_printed_table():
    """Abramowitz and Stegun, table 26.10."""
    for freedom, expected in ((1, 12.706), (2, 4.303), (3, 3.182), (10, 2.228), (30, 2.042)):
        assert t_quantile(0.975, freedom) == pytest.approx(expected, abs=5e-4)


# ---- equal weights ----


@pytest.mark.parametrize("channels", [1, 4])
def test_sums_of_equal_weights_tell_the_same_in_less_memory(channels):
    rng = np.random.default_rng(11)
    count = 3000
    whole, even = ReplicateSums(count, channels), ReplicateSums(count, channels, is_even=True)
    for weight in (64, 64, 64, 32):
        values = rng.gamma(4.0, 50.0, (count, channels))
        for sums in (whole, even):
            sums.add(0, values[:1000], np.full(1000, weight))
            sums.add(1000, values[1000:], weight)
            sums.end_pass()
    some = np.array([5, 7, 2999])
    for part in (slice(None), slice(500, 1500), some):
        for name in ("samples", "mean", "even", "odd", "variance", "replicates"):
            mine, theirs = getattr(even, name)(part), getattr(whole, name)(part)
            assert mine.shape == theirs.shape
            np.testing.assert_allclose(mine, theirs, rtol=2e-6)
    np.testing.assert_allclose(even.further_means(), whole.further_means(), rtol=2e-6)
    assert even.mean_samples == whole.mean_samples == 224.0
    size = [sum(each.nbytes for each in sums.state().values()) for sums in (whole, even)]
    assert size[0] - size[1] == pytest.approx(20 * count, abs=100)


def test_sums_of_equal_weights_go_on_from_their_state():
    rng = np.random.default_rng(12)
    through = ReplicateSums(100, is_even=True)
    for number in range(4):
        if number == 2:
            again = ReplicateSums.from_state(through.state())
        values = rng.normal(100.0, 5.0, 100)
        for sums in (through, again) if number >= 2 else (through,):
            sums.add(0, values, 16.0)
            sums.end_pass()
    assert again.is_even
    np.testing.assert_array_equal(again.variance(), through.variance())


def test_unequal_weights_are_refused_where_equal_ones_were_promised():
    sums = ReplicateSums(10, is_even=True)
    with pytest.raises(SceneError, match="equal weights"):
        sums.add(0, np.ones(10), np.arange(10))
    sums = ReplicateSums(10, is_even=True)
    sums.add(0, np.ones(5), 1.0)
    with pytest.raises(SceneError, match="equal weights"):
        sums.add(5, np.ones(5), 2.0)
    # What was refused has changed nothing.
    sums.add(5, np.ones(5), 1.0)
    sums.end_pass()
    np.testing.assert_array_equal(sums.mean(), np.ones(10))
