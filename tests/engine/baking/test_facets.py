"""Smooth shading of facets, and what it leaves unknown about means."""

import numpy as np
import pytest
from glass_scenes import ball
from small_scenes import box, paint

from lumenray.engine.baking.facets import find_facet_loss, tell_facet_loss
from lumenray.engine.scene.light import Output, Quantity, SunLight, UniformWorld


def test_what_a_facet_loses_is_what_its_normals_lean_away():
    """All normals of a quad lean by twenty degrees; those of flat shading do not."""
    from dataclasses import replace

    room = box(2.0, 2.0, 2.0)
    assert find_facet_loss(room) == 0.0
    flat = np.cross(
        room.vertices[room.triangles[:, 1]] - room.vertices[room.triangles[:, 0]],
        room.vertices[room.triangles[:, 2]] - room.vertices[room.triangles[:, 0]],
    )
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    aside = np.roll(np.abs(flat), 1, axis=1)
    tilt = np.radians(20.0)
    leaning = np.repeat((np.cos(tilt) * flat + np.sin(tilt) * aside)[:, None], 3, axis=1)
    bent = replace(room, corner_normals=leaning.astype(np.float32))
    assert find_facet_loss(bent) == pytest.approx(1.0 - np.cos(tilt), rel=1e-5)
    (told,) = tell_facet_loss("room", find_facet_loss(bent))
    assert "known to 6 % only" in told.message


@pytest.mark.parametrize("rings", [4, 8, 16])
def test_balls_lose_by_the_square_of_their_facets(rings):
    """Normals over a patch of side a on a unit sphere lean by a^2 / 6 on the mean square: half of that is lost."""
    loss = find_facet_loss(ball("ball", 1.0, np.zeros(3), "paint", rings))
    assert loss == pytest.approx((np.pi / rings) ** 2 / 12.0, rel=0.25)


@pytest.mark.mitsuba
@pytest.mark.parametrize("rings", [4, 8])
@pytest.mark.parametrize("is_sun", [True, False])
@pytest.mark.slow
def test_the_error_of_a_mean_over_facets_holds_what_smooth_shading_changes(rings, is_sun):
    from baking_rooms import bake_in
    from small_scenes import session_of

    shape = ball("ball", 1.0, np.zeros(3), "paint", rings)
    light = UniformWorld(100.0)
    true = 100.0 * np.pi
    if is_sun:
        down = np.array([0.0, 0.0, -1.0])
        light = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), down, np.radians(0.53))
        corners = 2 * rings
        outline = 0.5 * corners * np.sin(2.0 * np.pi / corners)
        true = 1000.0 * outline / shape.areas().sum()
    made = bake_in(session_of(paint(0.5), shape, light), ("ball",), 256, density=6.0).maps[0]
    off = abs(made.mean - true)
    assert off > 0.001 * true
    assert off < made.mean_standard_error
