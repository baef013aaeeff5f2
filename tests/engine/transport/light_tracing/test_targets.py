"""Targets of traced light: spheres hold all triangles and part what stands apart."""

import numpy as np
import pytest
from glass_scenes import ball
from small_scenes import quad

pytestmark = pytest.mark.mitsuba


def test_spheres_hold_all_triangles_and_part_what_stands_apart():
    from lumenray.engine.transport.light_tracing.targets import plant

    def cut(corners, place=(0.0, 0.0, 500.0), limit=64):
        spheres, counts = plant(corners).cut(np.array([place]), np.array([False]), limit)
        return spheres[0][counts[0]]

    rng = np.random.default_rng(2)
    centres = rng.uniform(-50.0, 50.0, (20, 3))
    corners = (centres[:, None, None] + rng.normal(0.0, 0.2, (20, 300, 3, 3))).reshape(-1, 3, 3)
    for limit in (1, 7, 64):
        spheres = cut(corners, limit=limit)
        assert len(spheres) <= limit
        away = np.linalg.norm(corners[:, None] - spheres[None, :, None, :3], axis=3).max(axis=2)
        assert (away <= spheres[:, 3]).any(axis=1).all()
    assert len(spheres) >= 20
    assert (spheres[:, 3] ** 2).sum() < 20 * 2.0**2
    # The order of the triangles says nothing.
    np.testing.assert_array_equal(spheres, cut(corners[rng.permutation(len(corners))]))
    # What is close is parted first.
    near = centres[np.linalg.norm(centres[:, None] - centres, axis=2).sum(axis=1).argmax()]
    few = cut(corners, near + np.array([0.0, 0.0, 3.0]), limit=6)
    reach = np.linalg.norm(few[:, :3] - near, axis=1)
    assert few[reach.argmin(), 3] < 2.0
    # Large triangles are parted too: a strip of two, seen from anywhere, is no ball.
    strip = quad("s", (0, 0, 0), (20, 0, 0), (0, 1, 0), "glass")
    assert (cut(strip.vertices[strip.triangles])[:, 3] ** 2).sum() < 0.25 * 10.0**2
    # A ball gains nothing by being parted, be it of many triangles or very many; those are known by their boxes.
    for rings in (24, 200):
        whole = ball("b", 1.0, (0, 0, 0), "glass", rings)
        assert cut(whole.vertices[whole.triangles])[:, 3] == pytest.approx([1.06], rel=0.05)


def test_a_single_sphere_is_never_parted():
    """The square of a radius may differ in the last digit from that of an array: scenes ended in a crash."""
    from lumenray.engine.transport.light_tracing.targets import SphereTree

    for radius in 0.5 + 7.5 * np.random.default_rng(4).random(2000):
        least = np.array([np.nextafter(radius**2, 0.0)])
        tree = SphereTree(np.array([[0.0, 0.0, 0.0, radius]]), np.array([[-1, -1]]), least)
        spheres, counts = tree.cut(np.zeros((2, 3)), np.array([False, True]), 4)
        assert spheres.shape == (2, 1, 4) and counts.all()
