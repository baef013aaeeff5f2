"""Where sensors stand: the grid of EN 12464-1, borders along outlines, floors of any shape."""

import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.scene.sensor_layout import (
    count_points,
    find_heights,
    find_outline,
    find_spacing,
    lay_line,
    lay_over,
    lay_rectangle,
    relevant_length,
)


def cut(*rectangles):
    """Triangles of rectangles (x0, y0, x1, y1)."""
    made = []
    for x0, y0, x1, y1 in rectangles:
        a, b, c, d = (x0, y0), (x1, y0), (x1, y1), (x0, y1)
        made += [(a, b, c), (a, c, d)]
    return np.array(made, float)


@pytest.mark.parametrize(
    ("length", "spacing"), [(1.0, 0.2), (10.0, 1.0), (100.0, 5.0), (1000.0, 10.0)]
)
def test_the_spacing_is_that_of_the_standard(length, spacing):
    assert find_spacing(length) == pytest.approx(spacing)


@pytest.mark.parametrize(
    ("length", "count"), [(1.0, 5), (2.0, 6), (5.0, 8), (10.0, 10), (100.0, 20)]
)
def test_the_numbers_of_points_are_those_of_the_standards_table(length, count):
    assert count_points((length, length)) == (count, count)


def test_of_a_long_area_the_shorter_side_tells_the_spacing():
    assert relevant_length((10.0, 6.0)) == 10.0
    assert relevant_length((10.0, 5.0)) == 5.0
    # 5 m: 8 points, 0.625 m apart, so that 10 m have 16.
    assert count_points((10.0, 5.0)) == (16, 8)


def test_points_stand_in_the_middles_of_cells_that_fill_what_the_border_leaves():
    points, shape = lay_rectangle((0.0, 0.0), (5.0, 3.0), 0.5, spacing=0.5)
    assert shape == (4, 8)
    np.testing.assert_allclose(points.min(axis=0), 0.75)
    np.testing.assert_allclose(points.max(axis=0), [4.25, 2.25])
    np.testing.assert_allclose(points[1] - points[0], [0.5, 0.0])
    np.testing.assert_allclose(lay_line(3.0, 1.0)[:, 0], [-1.0, 0.0, 1.0])


def test_an_l_shaped_floor_has_its_border_along_the_inner_corner_too():
    floor = cut((0, 0, 6, 2), (0, 2, 2, 6))
    points, cells, shape = lay_over(floor, 0.5, spacing=0.25)
    x, y = points.T
    corner = np.hypot(np.maximum(x - 2.0, 0.0), np.maximum(y - 2.0, 0.0))
    expected = ((y <= 1.5) | (x <= 1.5) | (x < 2.0) & (y < 2.0)) & (corner >= 0.0)
    assert expected.all()
    assert not ((x > 1.5) & (y > 1.5) & (np.hypot(x - 2.0, y - 2.0) < 0.5)).any()
    assert ((x > 1.5) & (y > 1.5)).any()
    assert shape == (20, 20)
    assert len(np.unique(cells)) == len(points) < 400


@pytest.mark.parametrize(
    "floor",
    [
        cut((0, 0, 4, 4)),
        # Faces that share no corner where they meet.
        cut((0, 0, 4, 2), (0, 2, 1, 4), (1, 2, 4, 4)),
        # Upper and lower side of a slab.
        np.concatenate([cut((0, 0, 4, 4)), cut((0, 0, 4, 4))[:, ::-1]]),
    ],
)
def test_only_where_the_surface_ends_is_its_outline(floor):
    outline = find_outline(floor)
    on_side = (np.isclose(outline, 0.0) | np.isclose(outline, 4.0)).all(axis=1).any(axis=1)
    assert on_side.all()
    points, _, shape = lay_over(floor, 0.5, spacing=0.5)
    assert shape == (6, 6)
    assert len(points) == 36


def test_heights_are_those_of_the_uppermost_face():
    low = np.concatenate([cut((0, 0, 2, 2)), np.zeros((2, 3, 1))], axis=2)
    step = np.concatenate([cut((1, 0, 2, 2)), np.full((2, 3, 1), 0.5)], axis=2)
    heights = find_heights(np.array([[0.5, 1.0], [1.5, 1.0]]), np.concatenate([step, low]))
    np.testing.assert_allclose(heights, [0.0, 0.5])


def test_what_gives_no_sensor_is_refused():
    with pytest.raises(SceneError, match="leaves nothing of an area of 1 m by 1 m"):
        lay_rectangle((0.0, 0.0), (1.0, 1.0), 0.5)
    with pytest.raises(SceneError, match="at most 200000"):
        lay_rectangle((0.0, 0.0), (100.0, 100.0), 0.0, 0.01)
    with pytest.raises(SceneError, match="smaller spacing or border"):
        lay_over(np.array([[(0, 0), (2, 0), (0, 2)]], float), 0.7)
