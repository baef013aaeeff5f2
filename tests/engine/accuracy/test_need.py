"""Which values get the next samples."""

import numpy as np
import pytest

from lumenray.engine.accuracy.need import (
    LEAST,
    NEIGHBOURS,
    foretell,
    gain_of,
    order_by_place,
    share_out,
    wanted_for_all,
    wanted_for_each,
)

COUNT = 400


def scattered(seed=1):
    """Variances of single samples over four decades."""
    return np.tile(10.0 ** np.random.default_rng(seed).uniform(-2.0, 2.0, COUNT), (2, 1))


def test_by_need_the_mean_square_is_the_least_that_so_many_samples_give():
    variances, counts = scattered(), np.full((2, COUNT), 16)
    wanted = wanted_for_all(counts, variances, 1000.0)
    assert wanted.mean() == pytest.approx(1016.0)
    assert wanted.min() == pytest.approx(LEAST * 1016.0)
    own = (variances / wanted).mean()
    # None may be without samples, which costs a part of what all by need would gain.
    assert 1.0 < (variances / 1016.0).mean() / own < gain_of(variances)
    free = wanted > LEAST * 1016.0 * 1.001
    np.testing.assert_allclose(np.ptp((np.sqrt(variances) / wanted)[free]), 0.0, atol=1e-9)
    # Whatever is moved from one to another makes it worse.
    draw = np.random.default_rng(5)
    for _ in range(100):
        one, other = draw.choice(np.flatnonzero(free.ravel()), 2, replace=False)
        moved = wanted.copy()
        moved.flat[one] += 20.0
        moved.flat[other] -= 20.0
        assert (variances / moved).mean() > own


def test_nobody_loses_samples_and_who_has_too_many_gets_none():
    variances = scattered()
    counts = np.full((2, COUNT), 64)
    counts[:, :50] = 5000
    wanted = wanted_for_all(counts, variances, 32.0)
    assert (wanted >= counts).all()
    assert (wanted - counts).mean() == pytest.approx(32.0, rel=1e-6)


def test_where_nothing_scatters_all_get_as_many():
    counts = np.full((2, 5), 8)
    np.testing.assert_array_equal(wanted_for_all(counts, np.zeros((2, 5)), 8.0), counts + 8.0)
    assert gain_of(np.zeros((2, 5))) == 1.0


def test_for_single_limits_only_those_get_more_who_miss_theirs():
    counts, excess = np.full((2, 4), 1024), np.array([0.5, 2.0, 1.01, 0.0])
    wanted = wanted_for_each(counts, excess, 1e9)
    np.testing.assert_allclose(wanted, np.tile([1024, 4096, 1024 * 9 / 8, 1024], (2, 1)))
    # As far as the samples of a pass go.
    part = wanted_for_each(counts, excess, 256.0)
    assert (part - counts).mean() == pytest.approx(256.0)
    assert (part[:, [0, 3]] == 1024).all()
    np.testing.assert_array_equal(wanted_for_each(counts, np.ones(4), 256.0), counts)
    assert np.isfinite(wanted_for_each(counts, np.full(4, np.inf), 256.0)).all()


@pytest.mark.parametrize("unit", [1, 8, 64])
def test_shares_are_whole_units_and_add_up(unit):
    counts = np.full((2, COUNT), 64)
    wanted = wanted_for_all(counts, scattered(), 100.0)
    units = share_out(wanted, counts, unit)
    assert units.min() >= 0
    assert abs(units.sum() * unit - (wanted - counts).sum()) <= unit
    assert np.abs(units * unit - (wanted - counts)).max() <= unit


def test_what_is_foretold_of_a_half_does_not_follow_from_itself():
    variances, order = scattered(), np.arange(COUNT)
    changed = variances.copy()
    changed[1, 200] *= 1e6
    before, after = foretell(variances, order), foretell(changed, order)
    assert after[1, 200] == pytest.approx(before[1, 200])
    near = slice(200 - NEIGHBOURS, 200 + NEIGHBOURS + 1)
    assert (after[0, near] > 100.0 * before[0, near]).all()
    np.testing.assert_allclose(after[:, : 200 - NEIGHBOURS], before[:, : 200 - NEIGHBOURS])


def test_of_even_scatter_it_is_the_same_everywhere_and_one_value_alone_asks_its_other_half():
    np.testing.assert_allclose(foretell(np.full((2, 30), 3.0), np.arange(30)), 3.0)
    np.testing.assert_allclose(foretell(np.array([[2.0], [5.0]]), np.arange(1)), [[5.0], [2.0]])


def test_neighbours_along_the_curve_lie_near_and_face_alike():
    draw = np.random.default_rng(7)
    places = draw.uniform(0.0, 10.0, (1000, 3)) * [1.0, 1.0, 0.0]
    up = draw.random(1000) < 0.5
    normals = np.where(up, 1.0, -1.0)[:, None] * [0.0, 0.0, 1.0]
    order = order_by_place(places, normals)
    assert sorted(order) == list(range(1000))
    steps = np.linalg.norm(np.diff(places[order], axis=0), axis=1)
    # Of 500 on 100 m2 the nearest lies about 0.22 m away; any two are 5 m apart.
    assert np.median(steps) < 0.6
    assert np.count_nonzero(np.diff(up[order].astype(int))) == 1
    # Places that are all the same have an order too.
    assert sorted(order_by_place(np.zeros((3, 3)), normals[:3])) == [0, 1, 2]
