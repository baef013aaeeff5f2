"""Sums of values with unlike numbers of samples: means, errors, and that what decides about a half leaves its mean alone."""

import numpy as np
import pytest

from lumenray.engine.accuracy.estimate import Estimate
from lumenray.engine.accuracy.need import foretell
from lumenray.engine.accuracy.uneven_sums import HALVES, UnevenSums

GROUPS = 16
EACH = GROUPS // HALVES


def add(sums, half, number, samples):
    """Add samples (m, groups of a half, n) of one channel to halves of values."""
    square = samples**2
    tails = np.stack([square.sum(axis=(1, 2)), square.max(axis=(1, 2))])
    lost = np.zeros(len(number), dtype=np.int64)
    sums.add(half, number, samples.shape[2], samples.sum(axis=2)[..., None], tails, lost)


def rows(count):
    """Both halves of all values."""
    half = np.repeat(np.arange(HALVES), count)
    return half, np.tile(np.arange(count), HALVES)


def test_where_all_have_as_many_it_is_the_estimate_from_groups():
    draw, sums = np.random.default_rng(1), UnevenSums(GROUPS, 3, 1)
    samples = draw.random((HALVES * 3, EACH, 32))
    add(sums, *rows(3), samples[..., :16])
    add(sums, *rows(3), samples[..., 16:])
    means = samples.mean(axis=2).reshape(HALVES, 3, EACH).transpose(0, 2, 1).reshape(GROUPS, 3)
    expected, made = Estimate.from_groups(means, 32 * GROUPS), sums.estimate()
    np.testing.assert_allclose(made.mean[:, 0], expected.mean, rtol=1e-12)
    np.testing.assert_allclose(made.standard_error[:, 0], expected.standard_error, rtol=1e-12)
    assert made.samples == expected.samples
    np.testing.assert_allclose(sums.variances().mean(), 1.0 / 12.0, rtol=0.5)


def test_several_rows_of_one_value_add_up():
    sums = UnevenSums(GROUPS, 2, 1)
    half, number = np.array([0, 0, 1, 1, 1]), np.array([0, 0, 0, 1, 1])
    add(sums, half, number, np.ones((5, EACH, 4)))
    assert sums.counts.tolist() == [[8, 0], [4, 8]]
    np.testing.assert_allclose(sums.means()[:EACH, 0], 1.0)
    assert sums.samples == 5.0


def test_stated_errors_are_true_where_halves_and_values_have_unlike_numbers():
    draw, count = np.random.default_rng(2), 4000
    sums = UnevenSums(GROUPS, count, 1)
    for many in (4, 16):
        # The first half of the values stops after a few, and so does the second half of all groups.
        half, number = rows(count)
        some = slice(None) if many == 4 else (half == 0) & (number >= count // 2)
        half, number = half[some], number[some]
        add(sums, half, number, 5.0 + draw.normal(size=(len(number), EACH, many)))
    made = sums.estimate()
    for part, squares in (
        (slice(0, count // 2), 1.0 / (GROUPS * 4)),
        (slice(count // 2, count), (1.0 / 20 + 1.0 / 4) / (2 * GROUPS)),
    ):
        stated = np.sqrt((made.standard_error[part] ** 2).mean())
        assert stated == pytest.approx(np.sqrt(squares), rel=0.03)
        assert made.mean[part].std() == pytest.approx(np.sqrt(squares), rel=0.05)


@pytest.mark.parametrize("by_others", [True, False])
def test_means_are_right_only_if_what_decides_about_a_half_is_not_its_own(by_others):
    """Rare bright samples: who has seen none seems not to scatter, and gets no more if it is asked itself."""
    draw, count = np.random.default_rng(3), 20_000
    sums = UnevenSums(GROUPS, count, 1)
    half, number = rows(count)

    def make(some, many):
        return (draw.random((int(some.sum()), EACH, many)) < 0.01) / 0.01

    every = np.ones(len(half), dtype=bool)
    add(sums, half, number, make(every, 4))
    variances = sums.variances()
    told = foretell(variances, np.arange(count)) if by_others else variances
    needs = (told > np.median(told)).ravel()
    add(sums, half[needs], number[needs], make(needs, 28))
    mean = sums.estimate().mean
    apart = (mean.mean() - 1.0) / (mean.std() / np.sqrt(count))
    assert abs(apart) < 4.0 if by_others else apart < -20.0


def test_errors_from_few_large_samples_are_the_larger():
    draw, sums = np.random.default_rng(4), UnevenSums(GROUPS, 1, 1)
    samples = 1e-3 * draw.random((HALVES, EACH, 64))
    samples[1, 3, 5] = 1.0
    add(sums, *rows(1), samples)
    made = sums.estimate()
    plain = Estimate.from_groups(sums.means(), made.samples)
    assert made.standard_error[0, 0] / plain.standard_error[0, 0] == pytest.approx(2.3, rel=0.02)
    assert made.events[0, 0] == pytest.approx(1.0, abs=0.01)


def test_lost_samples_are_a_share_of_ones_own():
    sums = UnevenSums(GROUPS, 2, 1)
    add(sums, *rows(2), np.ones((4, EACH, 8)))
    sums.add(
        np.array([0]), np.array([1]), 8, np.zeros((1, EACH, 1)), np.zeros((2, 1)), np.array([6])
    )
    assert sums.lost_shares() == pytest.approx([0.0, 6 / (EACH * 24)])
