"""Glare rating against closed forms."""

import numpy as np
import pytest

from lumenray.engine.analysis.glare import (
    FlatOpenings,
    Observer,
    guth_position_index,
    projected_areas,
    sight_angles,
    solid_angles,
    unified_glare_rating,
)
from lumenray.engine.errors import SceneError

EYE = Observer(np.array([0.0, 0.0, 1.2]), np.array([0.0, 2.0, 0.0]))
"""Seated, looking along +y."""


def panels(*centres, area=0.36):
    """Openings that shine downwards."""
    normals = np.tile([0.0, 0.0, -1.0], (len(centres), 1))
    return FlatOpenings(np.array(centres), normals, np.full(len(centres), area))


def test_a_source_on_the_line_of_sight_has_the_index_one():
    assert np.allclose(guth_position_index([0.0, 45.0, 90.0], 0.0), 1.0)


def test_the_index_follows_its_formula():
    # ln p at 90 deg to the side and 10 deg off: (35.2 - 28.7001) 0.01 + (21 + 24.0003 - 24.0003) 0.001.
    assert guth_position_index(90.0, 10.0) == pytest.approx(np.exp(0.064999 + 0.021), rel=1e-6)
    # 0 deg, 30 deg off: (35.2 - 1.22) 0.03 + 21e-5 900.
    assert guth_position_index(0.0, 30.0) == pytest.approx(np.exp(1.0194 + 0.189), rel=1e-12)


@pytest.mark.parametrize(("turn", "off"), [(91.0, 20.0), (-1.0, 20.0), (10.0, 90.0), (np.nan, 5.0)])
def test_the_index_is_refused_where_it_is_not_defined(turn, off):
    with pytest.raises(SceneError, match="not below the line of sight"):
        guth_position_index(turn, off)


def test_angles_are_those_of_the_field_of_view():
    points = EYE.position + np.array(
        [(0, 1, 0), (0, 1, 1), (1, 1, 0), (-1, 1, 1), (0, 1, -1), (0, -1, 0)]
    )
    turns, off = sight_angles(EYE, points)
    assert np.allclose(off, [0.0, 45.0, 45.0, np.degrees(np.arctan(np.sqrt(2.0))), 45.0, 180.0])
    assert np.allclose(turns[1:5], [0.0, 90.0, 45.0, 180.0])


def test_angles_turn_with_the_observer():
    # The whole scene turned about a slanted axis.
    axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turn = np.eye(3) + np.sin(0.7) * cross + (1.0 - np.cos(0.7)) * cross @ cross
    points = np.array([(0.5, 4.0, 3.0), (-2.0, 3.0, 2.5)])
    turned = Observer(turn @ EYE.position, turn @ EYE.direction, turn @ EYE.up)
    for got, expected in zip(
        sight_angles(turned, points @ turn.T), sight_angles(EYE, points), strict=True
    ):
        assert np.allclose(got, expected)


def test_an_inclined_line_of_sight_keeps_the_vertical_plane():
    down = Observer(np.zeros(3), np.array([0.0, 1.0, -1.0]))
    turns, off = sight_angles(down, [[0.0, 1.0, 0.0], [np.sqrt(2.0), 1.0, -1.0]])
    assert np.allclose(turns, [0.0, 90.0])
    assert np.allclose(off, [45.0, 45.0])


def test_the_solid_angle_follows_from_distance_and_slope():
    # 3 m along, 4 m up: d = 5 m, cos = 0.8.
    above = panels((0.0, 3.0, 5.2), area=0.5)
    assert projected_areas(EYE, above) == pytest.approx([0.4])
    assert solid_angles(EYE, above) == pytest.approx([0.4 / 25.0])


def test_an_opening_seen_from_behind_fills_no_angle():
    below = panels((0.0, 3.0, 0.2))
    assert solid_angles(EYE, below) == pytest.approx([0.0])


def test_the_rating_is_eight_times_the_decades():
    # 0.25 / 25 * 1000^2 * 0.01 = 100, so the rating is 16; at p = 10 two decades less.
    assert unified_glare_rating(25.0, 1000.0, 0.01, 1.0) == pytest.approx(16.0)
    assert unified_glare_rating(25.0, 1000.0, 0.01, 10.0) == pytest.approx(0.0, abs=1e-12)
    ten = unified_glare_rating(25.0, np.full(10, 1000.0), np.full(10, 0.01), np.ones(10))
    assert ten == pytest.approx(24.0)


def test_a_dark_source_adds_nothing():
    alone = unified_glare_rating(30.0, 5000.0, 0.005, 2.0)
    assert unified_glare_rating(30.0, [5000.0, 0.0], [0.005, 0.1], [2.0, 1.0]) == pytest.approx(
        alone
    )


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ((0.0, 1.0, 1.0, 1.0), "background luminance is 0"),
        ((-3.0, 1.0, 1.0, 1.0), "background luminance is -3"),
        ((np.nan, 1.0, 1.0, 1.0), "background luminance is nan"),
        ((30.0, [1.0, -1.0], [1.0, 1.0], [1.0, 1.0]), "source 2 needs a luminance"),
        ((30.0, 1.0, np.inf, 1.0), "source 1 needs a solid angle"),
        ((30.0, 1.0, 1.0, 0.9), "source 1 needs a position index"),
        ((30.0, [1.0, 2.0], 1.0, 1.0), "found 2, 1 and 1"),
        ((30.0, 0.0, 1.0, 1.0), "no glare to rate"),
        ((30.0, [], [], []), "no glare to rate"),
    ],
)
def test_unusable_values_are_refused_in_words(values, words):
    with pytest.raises(SceneError, match=words):
        unified_glare_rating(*values)


def test_unusable_openings_and_observers_are_refused_in_words():
    with pytest.raises(SceneError, match="point 1 is at the observer's eye"):
        solid_angles(EYE, panels(EYE.position))
    with pytest.raises(SceneError, match="opening 2 needs an area"):
        solid_angles(EYE, FlatOpenings(np.eye(3)[:2], np.eye(3)[:2], [1.0, 0.0]))
    with pytest.raises(SceneError, match="opening 1 has no normal"):
        solid_angles(EYE, FlatOpenings(np.ones((1, 3)), np.zeros((1, 3)), [1.0]))
    with pytest.raises(SceneError, match="point 1 is at the observer's eye"):
        sight_angles(EYE, EYE.position)
    with pytest.raises(SceneError, match="a line of sight"):
        sight_angles(Observer(np.zeros(3), np.array([0.0, 0.0, 1.0])), np.ones((1, 3)))
