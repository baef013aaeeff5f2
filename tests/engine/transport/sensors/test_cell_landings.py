"""Points that stand for where paths meet cells."""

import numpy as np
import pytest

pytestmark = pytest.mark.mitsuba


@pytest.fixture(scope="module")
def make():
    from lumenray.engine.transport import backend

    backend.start(spectral=False)
    from lumenray.engine.transport.sensors.cell_landings import Landings

    def make_landings(sides, column, x, y, amount=None, order=None):
        order = np.zeros(len(x)) if order is None else order
        amount = np.ones(len(x)) if amount is None else amount
        return Landings.of(sides, order, column, x, y, amount)

    return make_landings


def even(count, seed=0):
    return np.random.default_rng(seed).random((2, count))


def test_points_lie_where_the_light_comes_from(make):
    # Three times as much comes from the left third as from all the rest.
    x, y = even(40_000)
    amount = np.where(x < 1 / 3, 6.0, 1.0)
    made = make(2, np.ones(len(x), dtype=int), x, y, amount)
    for half in range(2):
        left = np.mean(made.points[half, 1, :, 0] < 1 / 3)
        assert left == pytest.approx(0.75, abs=0.04)
        assert made.points[half, 1, :, 1].mean() == pytest.approx(0.5, abs=0.02)
    assert made.known.tolist() == [[False, True], [False, True]]


def test_neighbours_in_the_square_are_neighbours_on_the_cell(make):
    x, y = even(40_000)
    points = make(1, np.zeros(len(x), dtype=int), x, y).points[0, 0].reshape(8, 8, 2)
    middles = (np.arange(8) + 0.5) / 8
    assert points[..., 0].mean(axis=1) == pytest.approx(middles, abs=0.05)
    assert points[..., 1].mean(axis=0) == pytest.approx(middles, abs=0.05)


def test_landings_of_one_side_do_not_serve_another(make):
    x, y = even(4000)
    column = np.arange(4000) % 3
    made = make(3, column, 0.1 + 0.3 * column + 0.1 * x, y)
    for side in range(3):
        own = made.points[:, side, :, 0]
        assert (np.abs(own - 0.15 - 0.3 * side) < 0.0501).all()


def test_sensors_at_both_ends_have_their_own_points(make):
    # Those at the near end, with three quarters of the light, see the left half of the cell; the others the right half.
    x, y = even(8000)
    order = np.random.default_rng(3).random(8000)
    near = order < 0.5
    x = np.where(near, 0.5 * x, 0.5 + 0.5 * x)
    made = make(1, np.zeros(8000, dtype=int), x, y, 1.0 + 2.0 * near, order)
    left = (made.points[:, 0, :, 0] < 0.5).mean(axis=1)
    assert left == pytest.approx([1.0, 0.5], abs=0.02)


def test_no_landings_at_all(make):
    made = make(2, np.zeros(0, dtype=int), np.zeros(0), np.zeros(0))
    assert not made.known.any()
    assert make(0, np.zeros(0, dtype=int), np.zeros(0), np.zeros(0)).points.shape[1] == 0
