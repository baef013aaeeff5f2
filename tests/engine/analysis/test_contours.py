"""Lines of equal value against curves that are known exactly, and the values that lines are drawn of."""

import numpy as np
import pytest

from lumenray.engine.analysis.contours import choose_levels, find_contours, place_label

HEIGHT = 2.5


def illuminance(x, y):
    """Of a lamp of 1000 cd at (2, 3) m, on the floor below it. [lx]"""
    return 1000.0 * HEIGHT / (HEIGHT**2 + (x - 2.0) ** 2 + (y - 3.0) ** 2) ** 1.5


@pytest.mark.parametrize("level", [20.0, 50.0, 100.0, 150.0])
def test_isolux_lines_are_within_a_lumel_of_the_exact_circles(level):
    lumel = 0.125
    x, y = lumel * (np.arange(80) + 0.5), lumel * (np.arange(64) + 0.5)
    ((_, paths),) = find_contours(x, y, illuminance(x[None], y[:, None]), [level])
    radius = np.sqrt((1000.0 * HEIGHT / level) ** (2.0 / 3.0) - HEIGHT**2)
    points = np.concatenate(paths)
    assert np.abs(np.hypot(*(points - [2.0, 3.0]).T) - radius).max() < 0.1 * lumel
    # Nothing of a circle is left out: every part of it within the map has a point near by.
    turn = np.linspace(0.0, 2.0 * np.pi, 721)
    circle = np.stack([2.0 + radius * np.cos(turn), 3.0 + radius * np.sin(turn)], axis=1)
    inside = ((circle > [x[0], y[0]]) & (circle < [x[-1], y[-1]])).all(axis=1)
    away = np.linalg.norm(circle[inside][:, None] - points[None], axis=2).min(axis=1)
    assert away.max() < lumel


def test_no_line_passes_where_nothing_is_known():
    x = y = np.arange(10.0)
    values = np.tile(x, (10, 1))
    values[4:6] = np.nan
    ((_, paths),) = find_contours(x, y, values, [4.5])
    points = np.concatenate(paths)
    np.testing.assert_allclose(points[:, 0], 4.5)
    assert not ((points[:, 1] > 3.0) & (points[:, 1] < 6.0)).any()
    assert len(paths) == 2


def test_a_row_of_sensors_has_no_lines():
    assert find_contours([0.0, 1.0], [0.0], [[1.0, 3.0]], [2.0]) == [(2.0, [])]


@pytest.mark.parametrize(
    ("low", "high", "levels"),
    [
        (310.0, 540.0, [350.0, 400.0, 450.0, 500.0]),
        (0.0, 100.0, [20.0, 40.0, 60.0, 80.0]),
        (1.2, 40.0, [1.5, 3.0, 7.5, 15.0, 30.0]),
        (5.0, 5.0, []),
    ],
)
def test_levels_are_round(low, high, levels):
    assert choose_levels([low, high, np.nan], 5) == pytest.approx(levels)


def test_labels_stand_half_way_along_a_line():
    np.testing.assert_allclose(place_label(np.array([[0, 0], [1, 0], [1, 5]], float)), [1, 2])
