"""Surfaces and lights of every kind together: no way of computing their light makes samples that are no numbers."""

import numpy as np
import pytest
from every_kind import LIGHTS, SURFACES, room_with
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

GROUPS = 6
"""Rooms over which all kinds are spread: a kernel of all of them takes minutes to compile."""

WORLDS = ("sky", "overcast", "even sky", "picture of a sky", "cloudy", "all-weather sky")
PLACED = tuple(name for name in LIGHTS if name not in WORLDS)


def told_of_measuring(session, transport):
    rng = np.random.default_rng(0)
    rule = StopRule(samples=512)
    places, normals = rng.random((16, 3)), rng.normal(size=(16, 3))
    return session.measure(places, normals, rule, transport=transport, colour=True).provenance.notes


def told_of_a_picture(session, transport):
    frame = np.eye(4)
    frame[:3, 3] = 0.5, 0.5, 0.95
    camera = Camera(frame, Projection.PERSPECTIVE, 48, 48)
    settings = ViewSettings(StopRule(samples=16), illuminance=True, transport=transport)
    return session.render(camera, settings).provenance.notes


def told_of_a_bake(session, transport, method):
    objects = tuple(key for key in session.scene.meshes if key != "glowing")
    order = BakeOrder(
        objects,
        StopRule(samples=32),
        density=20.0,
        method=method,
        transport=transport,
        exitance=True,
    )
    return [each.message for each in session.bake_objects(order).departures]


def assert_nothing_lost(told):
    lost = [words for words in told if "no number" in words]
    assert not lost, lost


@pytest.mark.parametrize("method", ["cells", pytest.param("paths", marks=pytest.mark.slow)])
def test_rooms_of_usual_materials_and_lights_lose_no_samples(method):
    """One surface with a coat once made what is no number of every path that ended on bare paint."""
    session = session_of(*room_with(("matt", "coat", "half a mirror"), ("bulb", "area"), 3))
    assert_nothing_lost(told_of_a_bake(session, "mono", method))


@pytest.mark.slow
@pytest.mark.parametrize("group", range(GROUPS))
def test_no_surface_and_no_light_loses_samples(group, transport):
    lights = (*PLACED[group % 3 :: 3], WORLDS[group % len(WORLDS)])
    session = session_of(*room_with(tuple(SURFACES)[group::GROUPS], lights, 3))
    assert_nothing_lost(told_of_measuring(session, transport))
    assert_nothing_lost(told_of_a_picture(session, transport))
    for method in ("cells", "paths"):
        assert_nothing_lost(told_of_a_bake(session, transport, method))
