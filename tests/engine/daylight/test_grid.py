"""Grids of sensors above floors."""

import numpy as np
import pytest
from small_scenes import box, quad

from lumenray.engine.daylight.grid import lay_grid
from lumenray.engine.errors import SceneError


def test_a_rectangle_is_covered_evenly():
    floor = quad("floor", [1, 2, 0.5], [4, 0, 0], [0, 3, 0], "paint")
    grid = lay_grid([floor], 0.5, 0.8)
    assert len(grid) == 48
    np.testing.assert_allclose(grid[:, 2], 1.3)
    np.testing.assert_allclose(grid.mean(axis=0), [3.0, 3.5, 1.3])
    np.testing.assert_allclose(grid.min(axis=0)[:2], [1.25, 2.25])


def test_what_is_left_over_and_the_margin_lie_at_the_sides():
    floor = quad("floor", [0, 0, 0], [2.2, 0, 0], [0, 2, 0], "paint")
    grid = lay_grid([floor], 0.5, 0.0, margin=0.5)
    np.testing.assert_allclose(np.unique(grid[:, 0].round(9)), [0.85, 1.35])


def test_a_slope_is_followed_and_walls_are_none():
    with pytest.raises(SceneError, match="'wall' is level"):
        lay_grid([quad("wall", [0, 0, 0], [1, 0, 0], [0, 0, 1], "paint")], 0.2, 0.8)
    ramp = quad("ramp", [0, 0, 0], [4, 0, 0.4], [0, 1, 0], "paint")
    grid = lay_grid([ramp], 1.0, 0.0)
    np.testing.assert_allclose(grid[:, 2], 0.1 * grid[:, 0])


def test_a_floor_of_two_levels_has_the_upper_one():
    grid = lay_grid([box(2.0, 2.0, 1.0, inwards=False)], 1.0, 0.0)
    np.testing.assert_allclose(grid[:, 2], 1.0)


@pytest.mark.parametrize("spacing", [0.0001, 50.0])
def test_grids_without_sense_are_refused(spacing):
    with pytest.raises(SceneError, match="'floor'"):
        lay_grid([quad("floor", [0, 0, 0], [4, 0, 0], [0, 4, 0], "paint")], spacing, 0.8)
