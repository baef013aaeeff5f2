"""Strands and balls as triangles: as wide and as large as round ones on the mean, whatever their number."""

import numpy as np
import pytest
from small_scenes import paint, session_of

from lumenray.blender_addon.sync import strands as made_of
from lumenray.blender_addon.sync.strands import Strands, balls, smoothed, tubes, usable
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import Output, Quantity, SunLight
from lumenray.engine.scene.mesh import Mesh

RADIUS, LENGTH = 0.02, 1.5


def straight(count=1, direction=(0.0, 0.0, 1.0), points=4):
    """Strands of equal length side by side."""
    direction = np.array(direction) / np.linalg.norm(direction)
    along = np.linspace(0.0, LENGTH, points)[:, None] * direction
    places = (np.arange(count)[:, None, None] * [0.1, 0.0, 0.0] + along).reshape(-1, 3)
    radii = np.full(len(places), RADIUS)
    return Strands(places, radii, np.full(count, points), np.arange(count))


def corners_of(made):
    return made.vertices[made.triangles].astype(float)


def areas(made):
    a, b, c = corners_of(made).transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


@pytest.mark.parametrize("most", [1 << 18, 100, 40, 24])
def test_tubes_have_the_surface_of_round_ones_however_many_sides(most, monkeypatch):
    monkeypatch.setattr(made_of, "SIDES", tuple((n, most) for n in (16, 8, 6, 4, 3)))
    made = tubes(straight(direction=(0.3, 0.5, 1.0)))
    assert len(made.triangles) <= most
    # A body without dents is seen with a quarter of its surface on the mean: so this is the width, too.
    assert areas(made).sum() == pytest.approx(2.0 * np.pi * RADIUS * LENGTH, rel=1e-5)
    assert made.note == ""


def test_normals_point_away_from_the_axis_and_faces_lie_by_them():
    made = tubes(straight(direction=(1.0, 2.0, -0.5)))
    corners, axis = corners_of(made), np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5])
    away = corners - (corners @ axis)[..., None] * axis
    away /= np.linalg.norm(away, axis=-1, keepdims=True)
    np.testing.assert_allclose(made.corner_normals, away, atol=1e-3)
    a, b, c = corners.transpose(1, 0, 2)
    assert ((np.cross(b - a, c - a) * made.corner_normals.mean(axis=1)).sum(axis=1) > 0.0).all()


def test_tubes_do_not_twist_along_a_helix():
    turn = np.linspace(0.0, 6.0 * np.pi, 200)
    helix = np.stack([np.cos(turn), np.sin(turn), 0.1 * turn], axis=1)
    made = tubes(Strands(helix, np.full(200, RADIUS), np.array([200]), np.zeros(1, int)))
    length = np.linalg.norm(np.diff(helix, axis=0), axis=1).sum()
    assert areas(made).sum() == pytest.approx(2.0 * np.pi * RADIUS * length, rel=2e-3)


def test_smooth_strands_run_through_their_points_and_straight_ones_stay():
    assert len(smoothed(straight()).points) == 4
    corner = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (2, 1, 0)], float)
    bent = Strands(corner, np.array([0.1, 0.2, 0.3, 0.4]), np.array([4]), np.array([2]))
    made = smoothed(bent)
    assert made.counts.tolist() == [13]
    np.testing.assert_allclose(made.points[::4], corner)
    np.testing.assert_allclose(made.radii[::2], np.linspace(0.1, 0.4, 7))
    # Catmull and Rom: halfway (-a + 9 b + 9 c - d) / 16.
    np.testing.assert_allclose(
        made.points[6], (9 * (corner[1] + corner[2]) - corner[0] - corner[3]) / 16
    )


def test_pointed_tips_and_points_that_say_nothing_leave_no_empty_triangles():
    points = np.array(
        [(0, 0, 0), (0, 0, 0), (0, 0, 1), (0, 0, 2), (5, 5, 5), (6, 6, np.nan), (7, 7, 7)]
    )
    radii = np.array([0.1, 0.1, 0.1, 0.0, 0.1, 0.1, 0.1])
    strands = Strands(points, radii, np.array([4, 1, 2]), np.array([0, 1, 2]))
    assert usable(strands).counts.tolist() == [3]
    made = tubes(strands)
    assert (areas(made) > 0.0).all()
    # A cylinder and a cone.
    expected = np.pi * (0.2 + 0.1 * np.hypot(1.0, 0.1))
    assert areas(made).sum() == pytest.approx(expected, rel=5e-3)
    assert tubes(strands.chosen(np.zeros(3, bool))) is None
    thin = Strands(points, 0.0 * radii, strands.counts, strands.slots)
    assert tubes(thin) is None


def test_too_many_strands_are_fewer_and_wider_and_told(monkeypatch):
    monkeypatch.setattr(made_of, "SIDES", ((3, 100),))
    made = tubes(straight(40))
    assert len(made.triangles) <= 100
    assert made.note.startswith("40 strands are too many: one of 8 is there, 8 times")
    assert areas(made).sum() == pytest.approx(40 * 2.0 * np.pi * RADIUS * LENGTH, rel=1e-5)
    assert set(made.slots.tolist()) == {0, 8, 16, 24, 32}


@pytest.mark.parametrize("most", [1 << 18, 200, 30])
def test_balls_have_the_surface_of_spheres(most, monkeypatch):
    monkeypatch.setattr(made_of, "SUBDIVISIONS", tuple((n, most) for n in (2, 1, 0)))
    made = balls(np.array([(1.0, 2.0, 3.0), (0.0, np.inf, 0.0)]), np.array([0.5, 1.0]))
    assert areas(made).sum() == pytest.approx(np.pi, rel=1e-5)
    away = corners_of(made) - [1.0, 2.0, 3.0]
    away /= np.linalg.norm(away, axis=-1, keepdims=True)
    np.testing.assert_allclose(made.corner_normals, away, atol=1e-4)
    a, b, c = corners_of(made).transpose(1, 0, 2)
    assert (np.cross(b - a, c - a) * away[:, 0]).sum(axis=1).min() > 0.0


def test_too_many_points_are_fewer_and_larger_and_told(monkeypatch):
    monkeypatch.setattr(made_of, "SUBDIVISIONS", ((0, 100),))
    made = balls(np.arange(30.0).reshape(10, 3), np.full(10, 0.1))
    assert made.note.startswith("10 points are too many: one of 2")
    assert areas(made).sum() == pytest.approx(10 * 4.0 * np.pi * 0.01, rel=1e-5)
    assert balls(np.zeros((0, 3)), np.zeros(0)) is None


@pytest.mark.mitsuba
@pytest.mark.parametrize("slant", [0.0, 0.7])
def test_strands_shade_as_much_as_round_ones(slant):
    """Parallel strands 0.1 apart under a sun let 1 - 2 r / d of its light through, d their distance across it."""
    made = tubes(straight(41, direction=(0.0, 1.0, 0.0), points=2))
    strands = Mesh(
        "strands", "strands", made.vertices.astype(float), made.triangles, ("black",),
        np.zeros(len(made.triangles), np.int32), corner_normals=made.corner_normals,
    )  # fmt: skip
    down = np.array([-np.sin(slant), 0.0, -np.cos(slant)])
    light = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), down, 0.0)
    session = session_of(strands, paint(0.0, "black"), light)
    count = 4000
    # Evenly over 20 of the distances, in the middle of all.
    x = 1.0 + 2.0 * (np.arange(count) + 0.5) / count - 0.5 * np.tan(slant)
    places = np.stack([x, np.full(count, 0.5 * LENGTH), np.full(count, -0.5)], axis=1)
    made = session.measure(places, np.tile([0.0, 0.0, 1.0], (count, 1)), StopRule(samples=4))
    share = made.illuminance.mean() / (1000.0 * np.cos(slant))
    assert share == pytest.approx(1.0 - 2.0 * RADIUS / (0.1 * np.cos(slant)), abs=4e-3)
