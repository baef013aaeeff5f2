"""Who gets more samples: where the square of the error over samples times cost is largest, within the budget."""

import numpy as np
import pytest

from lumenray.engine.transport.pictures.allocation import SPREAD, TILE, Allocation

FIRST, SECOND = 0, 3
SIZES = [(32, 24), (8, 8), (13, 21), (1, 1), (9, 1), (3, 40)]


def begun(width=32, height=24, costs=None):
    """Allocation whose pixels have one sample of each kind, by default two kinds at 2.5 and 1."""
    made = Allocation(width, height, costs or {FIRST: 2.5, SECOND: 1.0})
    made.extend(made.begin())
    return made


def squares_of(allocation, values):
    """The same squares for all pixels of a tile, from those of tiles by kind."""
    return {kind: np.asarray(each, float)[allocation.tile] for kind, each in values.items()}


def even(allocation, value=1.0):
    count = len(allocation.size)
    return squares_of(allocation, {kind: np.full(count, value) for kind in allocation.costs})


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_tiles_hold_every_pixel_once_and_are_no_larger_than_their_side(width, height):
    made = Allocation(width, height, {FIRST: 1.0})
    assert made.size.sum() == width * height
    assert made.size.min() > 0
    assert made.size.max() <= TILE**2
    tile = made.tile.reshape(height, width)
    for number in range(len(made.size)):
        y, x = np.nonzero(tile == number)
        assert np.ptp(x) < TILE
        assert np.ptp(y) < TILE


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_one_sample_of_each_kind_counts_as_one(width, height):
    made = begun(width, height)
    assert made.samples == pytest.approx(1.0)
    made.extend(made.begin())
    assert made.samples == pytest.approx(2.0)


def test_samples_count_by_their_cost():
    made = begun(costs={FIRST: 3.0, SECOND: 1.0})
    more = np.zeros(len(made.size), dtype=np.int64)
    made.extend({FIRST: more, SECOND: more + 4})
    # One sample is 3 + 1; 4 more of the cheap kind are one more.
    assert made.samples == pytest.approx(2.0)
    half = more.copy()
    half[: len(half) // 2] = 1
    assert made.mean({FIRST: half, SECOND: more}) == pytest.approx(0.375)


def test_samples_go_where_one_more_lowers_the_error_most():
    made = begun()
    tiles = np.arange(len(made.size))
    rng = np.random.default_rng(1)
    # Alike all around, so that what a tile borrows of its neighbours changes nothing.
    level = {FIRST: 5.0, SECOND: 1.0}
    added = made.choose(
        squares_of(made, {k: np.full(len(tiles), v) for k, v in level.items()}), 0.7
    )
    # 5 / 2.5 is more than 1 / 1, and all of the first cost 2.5 / 3.5 of a sample.
    assert not added[SECOND].any()
    assert 0 < added[FIRST].sum() < len(tiles)
    for _ in range(20):
        values = {kind: rng.random(len(tiles)) ** 4 for kind in made.costs}
        added = made.choose(squares_of(made, values), 0.5)
        pixels = squares_of(made, values)
        worth = {
            kind: made._spread(pixels[kind]) / (made.counts[kind] * cost)
            for kind, cost in made.costs.items()
        }
        taken = np.concatenate([worth[kind][added[kind] > 0] for kind in worth])
        left = np.concatenate([worth[kind][added[kind] == 0] for kind in worth])
        assert taken.min() >= left.max()


def test_doubling_by_need_comes_to_the_allocation_of_least_variance():
    """Neyman: for variances v over N at costs c, the samples are as the root of v / c; doublings meet it within two."""
    made = begun(64, 64, {FIRST: 2.5, SECOND: 1.0})
    count = len(made.size)
    # Two halves of the picture, far from each other but for one column of tiles.
    is_right = np.arange(count) % 8 >= 4
    variance = {FIRST: np.where(is_right, 64.0, 1.0), SECOND: np.where(is_right, 4.0, 0.25)}
    while made.samples < 512:
        now = {kind: variance[kind] / made.counts[kind] for kind in made.costs}
        made.extend(made.choose(squares_of(made, now), 0.5 * made.samples))
    inner = np.isin(np.arange(count) % 8, (0, 1, 6, 7))
    best = {kind: np.sqrt(variance[kind] / cost) for kind, cost in made.costs.items()}
    over = np.concatenate([made.counts[kind][inner] / best[kind][inner] for kind in made.costs])
    assert over.max() / over.min() <= 4.0


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_a_budget_is_kept_but_for_the_first_choice(width, height):
    made = begun(width, height)
    rng = np.random.default_rng(2)
    for _ in range(12):
        values = {kind: rng.random(len(made.size)) for kind in made.costs}
        budget = float(rng.choice([0.0, 0.1, 0.5, 1.0, 100.0]))
        added = made.choose(squares_of(made, values), budget)
        assert sum(each.sum() for each in added.values()) > 0, "a pass must bring the end nearer"
        if sum(np.count_nonzero(each) for each in added.values()) > 1:
            assert made.mean(added) <= budget * (1.0 + 1e-9)
        for kind, each in added.items():
            assert np.isin(each / made.counts[kind], (0, 1)).all()
        made.extend(added)


@pytest.mark.parametrize(("width", "height"), SIZES)
@pytest.mark.parametrize("samples", [1.5, 3.5, 50.0, 300.0, 500.0])
def test_what_is_left_of_samples_is_given_but_for_one_of_a_tile(width, height, samples):
    made = begun(width, height)
    rng = np.random.default_rng(4)
    passes = 0
    while made.samples < samples:
        values = {kind: rng.random(len(made.size)) ** 4 for kind in made.costs}
        left = samples - made.samples
        added = made.choose(squares_of(made, values), min(made.samples, left), left)
        single = max(made.costs.values()) * made.size.max() / len(made.tile) / 3.5
        assert made.mean(added) <= left * (1.0 + 1e-9) + single
        made.extend(added)
        passes += 1
    assert passes < 60


def test_all_are_doubled_where_the_budget_allows_it():
    made = begun()
    added = made.choose(even(made, 0.0), made.samples)
    assert all((added[kind] == made.counts[kind]).all() for kind in made.costs)


def test_a_tile_that_starves_comes_first_whatever_its_error():
    made = begun()
    more = np.full(len(made.size), 2 * SPREAD, dtype=np.int64)
    more[5] = 0
    made.extend({FIRST: more.copy(), SECOND: more.copy()})
    values = {kind: np.where(np.arange(len(more)) == 5, 0.0, 1.0) for kind in made.costs}
    pixels = squares_of(made, values)
    added = made.choose(pixels, 0.01 * made.samples)
    assert added[FIRST][5] == added[SECOND][5] == 1


def test_no_tile_and_no_kind_is_left_far_behind():
    """Not even where all that it has found is nothing: what is rare would be missed for ever."""
    made = begun()
    values = {kind: np.zeros(len(made.size)) for kind in made.costs}
    values[FIRST][7] = 1.0
    for _ in range(40):
        made.extend(made.choose(squares_of(made, values), 0.5 * made.samples))
    # Half of it before the last pass, which adds a half, and once more as counts are doubled or not.
    first, second = made.counts[FIRST], made.counts[SECOND]
    assert 3 * SPREAD * first.min() >= first @ made.size / len(made.tile)
    assert 3 * SPREAD**2 * second.min() >= made.samples


def test_a_kind_that_has_a_floor_keeps_it_in_every_tile():
    made = Allocation(32, 24, {FIRST: 2.5, SECOND: 1.0}, {SECOND: 0.25})
    made.extend(made.begin())
    values = {kind: np.zeros(len(made.size)) for kind in made.costs}
    values[FIRST] += np.arange(len(made.size))
    for _ in range(30):
        made.extend(made.choose(squares_of(made, values), 0.5 * made.samples))
        # As it was before the pass, which adds a half.
        assert 1.6 * made.counts[SECOND].min() >= 0.25 * made.samples
    assert made.counts[SECOND].max() <= 2.0 * 0.25 * made.samples


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_units_hold_every_new_sample_of_every_pixel_once(width, height):
    made = begun(width, height)
    rng = np.random.default_rng(3)
    seen = {kind: [{0} for _ in made.tile] for kind in made.costs}
    for _ in range(5):
        values = {kind: rng.random(len(made.size)) ** 6 for kind in made.costs}
        added = made.choose(squares_of(made, values), 0.6 * made.samples)
        for kind, more in added.items():
            units = made.units(kind, more)
            if units is None:
                assert not more.any()
                continue
            assert (np.diff(units.lumel) >= 0).all(), "sums are made of runs of a pixel's units"
            for lanes in (1, 50, 1 << 20):
                parts = list(units.split(lanes))
                for name in ("lumel", "first"):
                    whole = np.concatenate([getattr(part, name) for part in parts])
                    assert (whole == getattr(units, name)).all()
            for pixel, first in zip(units.lumel, units.first, strict=True):
                numbers = set(range(first, first + units.samples))
                assert not numbers & seen[kind][pixel], "no sample is taken twice"
                seen[kind][pixel] |= numbers
        made.extend(added)
        for kind in made.costs:
            each = made.of_pixels(kind)
            assert [len(numbers) for numbers in seen[kind]] == each.tolist()
            assert [max(numbers) + 1 for numbers in seen[kind]] == each.tolist()


def test_what_is_foreseen_of_even_pixels_falls_as_one_over_the_samples():
    made = Allocation(32, 24, {FIRST: 2.5})
    made.extend(made.begin())
    made.extend(made.begin())
    now = even(made, 0.04)
    assert made.foresee(now, now, 0.05) == made.samples == 2.0
    for share in (0.5, 0.25, 1.0 / 64.0):
        assert made.foresee(now, now, 0.04 * share) == pytest.approx(2.0 / share, rel=1e-6)


@pytest.mark.parametrize("goal", [0.3, 0.03, 0.003])
def test_what_is_foreseen_is_what_choices_come_to(goal):
    made = begun(64, 64)
    rng = np.random.default_rng(5)
    variance = {kind: rng.random(len(made.size)) ** 6 for kind in made.costs}

    def now():
        return squares_of(made, {kind: variance[kind] / made.counts[kind] for kind in made.costs})

    def left():
        return sum(each.mean() for each in now().values())

    goal *= left()
    foreseen = made.foresee(now(), now(), goal)
    while left() > goal:
        made.extend(made.choose(now(), 0.1 * made.samples))
    # Choices see how their neighbours have fallen meanwhile, and are a little better.
    assert 0.9 * made.samples < foreseen < 1.25 * made.samples


def test_errors_that_do_not_count_draw_samples_that_are_foreseen():
    """What steers by illuminance takes samples that lower the error of the luminance little."""
    made = begun()
    errors, squares = even(made, 0.02), even(made, 0.02)
    squares[SECOND] = squares[SECOND] * 16.0
    alone, both = made.foresee(errors, errors, 0.01), made.foresee(squares, errors, 0.01)
    assert both > 1.1 * alone
