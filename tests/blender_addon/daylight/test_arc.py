"""The sun's arc: where it begins and ends, its hours, and which time a point of the screen means."""

import numpy as np
import pytest
from blender_skies import new_sky

from lumenray.blender_addon.daylight.arc import (
    compass,
    find_nearest_time,
    lines_above,
    make_arc,
)
from lumenray.blender_addon.daylight.moment import find_day_of, find_moment
from lumenray.engine.errors import SceneError
from lumenray.ui.sun_arc import make_labels, make_lines, read_arc


@pytest.fixture
def world():
    """Return a world in Berlin on 21 June."""
    world = new_sky()
    world.lumenray.time.month = 6
    return world


def arc_of(world):
    moment = find_moment(world, 1)
    return moment, make_arc(moment, is_lifted=world.lumenray.time.use_refraction)


def test_the_arc_passes_the_sun_of_every_moment(world):
    for hour in (6.0, 12.5, 20.25):
        world.lumenray.time.hour = hour
        moment, arc = arc_of(world)
        i = int(np.argmin(abs(arc.seconds - moment.seconds)))
        assert arc.seconds[i] == moment.seconds
        np.testing.assert_allclose(arc.directions[i], moment.towards_sun, atol=1e-9)


def test_it_lies_on_the_horizon_at_rise_and_set(world):
    world.lumenray.time.use_refraction = False
    moment, arc = arc_of(world)
    pairs = lines_above(arc.directions).reshape(-1, 2, 3)
    assert (pairs[..., 2] > -1e-12).all()
    np.testing.assert_allclose(pairs[[0, -1], [0, 1], 2], 0.0, atol=1e-12)
    # The sun's middle is on the horizon some minutes after its upper edge, lifted by the air, was.
    day = find_day_of(moment)
    is_up = arc.directions[:, 2] > 0.0
    first, last = arc.seconds[is_up][[0, -1]]
    assert 0.0 < first - day.rise < 900.0
    assert 0.0 < day.set - last < 900.0


def test_hours_are_those_of_the_clock(world):
    _, arc = arc_of(world)
    assert [text for text, _ in arc.hours] == [str(hour) for hour in range(5, 22)]
    for text, direction in arc.hours:
        world.lumenray.time.hour = float(text)
        np.testing.assert_allclose(direction, find_moment(world, 1).towards_sun, atol=1e-9)


def test_solstices_bound_the_arcs_of_the_year(world):
    heights = [way[:, 2].max() for way in arc_of(world)[1].solstices]
    # At noon the sun stands at 90 degrees less the latitude, more or less 23.44 degrees.
    np.testing.assert_allclose(np.degrees(np.arcsin(heights)), (60.92, 14.04), atol=0.2)
    for month in range(1, 13):
        world.lumenray.time.month = month
        assert heights[1] - 1e-4 < arc_of(world)[1].directions[:, 2].max() < heights[0] + 1e-4


def test_a_polar_night_has_no_line_and_a_polar_day_is_whole(world):
    world.lumenray.place.city = "Tromsø, Norway"
    moment, arc = arc_of(world)
    assert len(lines_above(arc.directions)) == 2 * (len(arc.seconds) - 1)
    assert len(arc.hours) == 24
    world.lumenray.time.month = 12
    moment, arc = arc_of(world)
    assert len(lines_above(arc.directions)) == 0
    assert arc.hours == ()
    # There is something to draw all the same.
    assert all(len(points) == len(colours) for _, points, colours in make_lines(moment, arc))
    assert [text for text, _, _ in make_labels(moment, arc)] == list("NESW")


def test_north_turns_with_the_offset():
    np.testing.assert_allclose(compass(0.0)["N"], (0, 1, 0), atol=1e-12)
    np.testing.assert_allclose(compass(90.0)["E"], (0, 1, 0), atol=1e-12)
    np.testing.assert_allclose(compass(90.0)["N"], (-1, 0, 0), atol=1e-12)


def test_a_point_of_the_screen_means_the_time_next_to_it():
    seconds = np.array([0.0, 100.0, 200.0, 300.0])
    points = np.array([(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (np.nan, np.nan)])
    assert find_nearest_time(seconds, points, np.array([4.0, -3.0])) == pytest.approx(40.0)
    assert find_nearest_time(seconds, points, np.array([12.0, 5.0])) == pytest.approx(150.0)
    assert find_nearest_time(seconds, points, np.array([10.0, 99.0])) == pytest.approx(200.0)
    with pytest.raises(SceneError, match="nothing"):
        find_nearest_time(seconds, np.full((4, 2), np.nan), np.array([0.0, 0.0]))


def test_the_arc_is_shown_where_it_is_asked_for_and_known(world):
    import bpy

    scene = bpy.context.scene
    assert read_arc(scene) is None
    world.lumenray.arc.is_shown = True
    assert read_arc(scene) is not None
    world.lumenray.place.zone = "Nowhere"
    assert read_arc(scene) is None
    scene.world = None
    assert read_arc(scene) is None
