"""Bright spots that paths ask: found where they matter, and left out where they do not."""

import numpy as np
import pytest
from baking_rooms import lamp
from small_scenes import box, paint, session_of

pytestmark = pytest.mark.mitsuba

NEAR = (1e-2, 1.4, 1.3)
"""1 cm off the wall x = 0."""


def look_for_spots(*lamps):
    """Spots in a room of 3 m, as places on its floor see it. (n, 6)"""
    from lumenray.engine.transport.light_tracing.bright_spots import find_spots

    session = session_of(box(3, 3, 3), paint(0.5), *lamps)
    places = np.random.default_rng(1).uniform(0.1, 2.9, (4096, 3))
    places[:, 2] = 0.0
    normals = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (len(places), 1))
    with session._engine("auto") as scene:
        spots = find_spots(scene, scene.local(places), normals)
        spots[:, :3] += scene.origin
    return spots


def test_the_spot_of_a_lamp_at_a_wall_is_as_wide_as_its_distance():
    """K is 54 / (32 pi h^2) of a lamp at the distance h in a room of 54 m2: 5400."""
    spots = look_for_spots(lamp(NEAR, 1000.0, 0.0))
    assert len(spots) == 1
    assert spots[0, :3] == pytest.approx([0.0, *NEAR[1:]], abs=3e-3)
    assert spots[0, 3] == pytest.approx(1e-2, rel=0.1)


def test_spots_of_which_little_light_comes_are_left_out():
    """One of sixty alike lamps has a part of 5400 / 60^2 of the mean square; from 41 on it would matter."""
    others = [
        lamp(
            (0.5 + 0.5 * (n % 5), 0.5 + 0.5 * (n // 5 % 5), 1.2 + 0.3 * (n // 25)),
            1000.0,
            0.0,
            f"lamp {n}",
        )
        for n in range(59)
    ]
    spots = look_for_spots(lamp(NEAR, 1000.0, 0.0), *others)
    assert len(spots) == 0


def test_the_only_bright_spot_among_many_lamps_is_found():
    """With 20 times the flux of each of 19 others it has half of all light: a quarter of 5400 of the mean square."""
    others = [lamp((0.5 + 0.1 * n, 1.5, 1.5), 1000.0, 0.0, f"lamp {n}") for n in range(19)]
    spots = look_for_spots(lamp(NEAR, 20000.0, 0.0), *others)
    assert len(spots) == 1
    assert spots[0, :3] == pytest.approx([0.0, *NEAR[1:]], abs=3e-3)
