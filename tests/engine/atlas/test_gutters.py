"""Filling of gutters and of lumels that could not be computed."""

import numpy as np

from lumenray.engine.atlas.gutters import fill


def page(height, width, *charts):
    """Charts as (number, rows, columns) slices."""
    made = np.full((height, width), -1, np.int32)
    for number, rows, columns in charts:
        made[rows, columns] = number
    return made


def test_gutters_grow_by_rings_and_leave_what_is_known():
    chart = page(11, 11, (3, slice(5, 6), slice(5, 6)))
    values = np.where(chart == 3, 7.0, -1.0)[None].astype(np.float32)
    grown, owner = fill(values, chart == 3, chart, 2)
    assert grown.dtype == np.float32
    assert (grown[0, 3:8, 3:8] == 7.0).all()
    assert (owner[3:8, 3:8] == 3).all()
    assert grown.sum() == 25 * 7.0
    assert (owner >= 0).sum() == 25


def test_gutters_never_take_from_another_chart():
    # Values of a chart are all its own number times a hundred, so any mixture shows.
    rng = np.random.default_rng(5)
    chart = np.full((120, 150), -1, np.int32)
    for number in range(60):
        y, x = rng.integers(2, 110), rng.integers(2, 140)
        chart[y : y + rng.integers(1, 9), x : x + rng.integers(1, 9)] = number
    known = (chart >= 0) & (rng.random(chart.shape) < 0.7)
    values = np.stack([chart * 100.0, chart * 3.0 + 1.0])
    for margin in (1, 2, 5):
        grown, owner = fill(values, known, chart, margin)
        has = owner >= 0
        assert np.array_equal(grown[0][has], owner[has] * 100.0)
        assert np.array_equal(grown[1][has], owner[has] * 3.0 + 1.0)
        assert (grown[:, ~has] == 0.0).all()
        # Inside a chart nothing takes another chart's values.
        assert (owner[has & (chart >= 0)] == chart[has & (chart >= 0)]).all()
        # Free pixels within the margin of a known one belong to somebody.
        near = np.zeros_like(has)
        y, x = np.nonzero((chart >= 0) & has)
        for dy in range(-margin, margin + 1):
            for dx in range(-margin, margin + 1):
                near[np.clip(y + dy, 0, 119), np.clip(x + dx, 0, 149)] = True
        assert has[(chart == -1) & near].mean() > 0.97
        assert not has[(chart == -1) & ~near].any()


def test_neighbouring_charts_share_the_gap_between_them():
    chart = page(9, 14, (0, slice(None), slice(0, 4)), (1, slice(None), slice(10, 14)))
    values = np.where(chart == 0, 1.0, 2.0)[None]
    grown, owner = fill(values, chart >= 0, chart, 4)
    assert (owner[:, :7] == 0).all()
    assert (owner[:, 7:] == 1).all()
    assert (grown[0] == np.where(owner == 0, 1.0, 2.0)).all()


def test_holes_are_filled_from_their_own_chart_however_deep():
    # A ramp with a hole of 20 x 20 and another chart's lumels in the middle of it.
    chart = page(60, 60, (4, slice(5, 55), slice(5, 55)), (9, slice(29, 31), slice(29, 31)))
    ramp = np.broadcast_to(np.arange(60.0), (60, 60))
    values = np.where(chart == 9, 1e6, ramp)[None]
    known = chart >= 0
    known[20:40, 20:40] = False
    known[29:31, 29:31] = True
    filled, owner = fill(values, known, chart, 1)
    hole = (chart == 4) & ~known
    assert (owner[hole] == 4).all()
    assert filled[0][hole].min() >= 18.0
    assert filled[0][hole].max() <= 41.0
    # Near its sides the hole continues what is beside it.
    assert np.abs(filled[0][20:40, 20] - 19.5).max() < 1.0
    assert np.array_equal(filled[0][known], values[0][known])


def test_a_chart_of_which_nothing_is_known_stays_dark():
    chart = page(12, 12, (0, slice(1, 3), slice(1, 11)), (1, slice(4, 11), slice(1, 11)))
    known = chart == 0
    filled, owner = fill(np.where(known, 5.0, np.nan)[None], known, chart, 3)
    assert np.isfinite(filled).all()
    assert (filled[0][chart == 1] == 0.0).all()
    assert (owner[chart == 1] == -1).all()


def test_many_maps_are_filled_as_each_alone():
    rng = np.random.default_rng(2)
    chart = (rng.integers(0, 9, (5, 6)) - 1).astype(np.int32).repeat(7, axis=0).repeat(7, axis=1)
    known = (chart >= 0) & (rng.random(chart.shape) < 0.5)
    values = rng.random((3, *chart.shape))
    together, owner = fill(values, known, chart, 3)
    for number in range(3):
        alone, same = fill(values[number : number + 1], known, chart, 3)
        assert np.array_equal(alone[0], together[number])
        assert np.array_equal(same, owner)


def test_the_order_of_equal_neighbours_follows_their_numbers_only():
    # Two charts at the same distance from a pixel, with as many neighbours there: the lower number gets it.
    chart = page(5, 5, (8, slice(0, 5), slice(0, 2)), (2, slice(0, 5), slice(3, 5)))
    _, owner = fill(np.zeros((1, 5, 5)), chart >= 0, chart, 1)
    assert (owner[:, 2] == 2).all()
    _, mirrored = fill(np.zeros((1, 5, 5)), chart >= 0, chart[:, ::-1].copy(), 1)
    assert (mirrored[:, 2] == 2).all()
