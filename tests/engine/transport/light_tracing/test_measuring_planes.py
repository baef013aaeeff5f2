"""Maps on planes that take no part in light: what is traced from the lights never lands there, and yet they have it all."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake, lamp, lumel_places, pierced_box
from glass_scenes import GLASS, ball
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.scene.light import Output, Quantity, SunLight
from lumenray.engine.scene.material import Glossy, Material
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.session import Session

pytestmark = pytest.mark.mitsuba

HOLE = 0.1
SILVER = Material("silver", "silver", Glossy(Constant(0.9), 0.0))


def plane(height, size, material="paint", **more):
    """Square that looks up, in the middle of a room of 1 m, or of 3 m."""
    side = 3.0 if height > 0.6 else 1.0
    low = 0.5 * (side - size)
    return quad("plane", (low, low, height), (size, 0, 0), (0, size, 0), material, **more)


def shine():
    direction = np.array([0.1, 0.05, -1.0]) / np.linalg.norm([0.1, 0.05, -1.0])
    output = Output(Quantity.ILLUMINANCE, 1e5)
    return SunLight("sun", "sun", output, direction, np.radians(0.53)), -1e5 * direction[2]


@pytest.mark.parametrize("objects", [("plane",), ("room", "plane")])
def test_a_plane_has_the_sun_that_falls_on_a_small_part_of_it(objects):
    sun, lux = shine()
    ghost = replace(plane(0.5, 0.8), meets_light=False)
    made = bake((paint(0.0), pierced_box(HOLE), ghost, sun), objects, 256)
    told = made.maps[objects.index("plane")]
    expected = lux * HOLE**2 / 0.8**2
    assert abs(told.mean - expected) < 4.5 * told.mean_standard_error + 0.01 * expected
    assert told.mean_standard_error < 0.1 * expected


@pytest.mark.parametrize("radius", [0.0, 0.01])
@pytest.mark.slow
def test_a_plane_has_the_light_of_a_lamp_in_a_glass_ball(radius):
    room = replace(box(3, 3, 3), id="room", name="room")
    around = ball("bulb", 0.03, (1.5, 1.5, 1.6), "glass", 96)
    ghost = replace(plane(0.8, 1.0), meets_light=False)
    items = (paint(0.5), GLASS, room, around, lamp((1.5, 1.5, 1.6), 1000.0, radius), ghost)
    made = bake(items, ("plane",), 256, density=4.0)
    told = made.maps[0]
    places, _ = lumel_places(made, told, ghost)
    up = np.broadcast_to([0.0, 0.0, 1.0], places.shape)
    sensors = session_of(*items).measure(places, up, StopRule(samples=1 << 12))
    expected = float(np.mean(sensors.illuminance))
    error = float(np.mean(sensors.standard_error)) / np.sqrt(len(places))
    allowed = 4.5 * np.hypot(told.mean_standard_error, error) + 0.01 * expected
    # The middle of a lumel stands for it, which is right within so much here.
    assert abs(told.mean - expected) < allowed, (told.mean, expected)
    assert told.mean_standard_error < 0.05 * expected


def test_a_mirror_has_the_sun_that_falls_on_a_small_part_of_it():
    sun, lux = shine()
    made = bake(
        (paint(0.0), SILVER, pierced_box(HOLE), plane(0.5, 0.8, "silver"), sun), ("plane",), 256
    )
    expected = lux * HOLE**2 / 0.8**2
    told = made.maps[0]
    assert abs(told.mean - expected) < 4.5 * told.mean_standard_error + 0.01 * expected


def test_a_plane_is_told_to_have_no_second_witness():
    sun, _ = shine()
    ghost = replace(plane(0.5, 0.8), meets_light=False)
    session = Session()
    session.apply(SceneDelta(changed=(paint(0.3), pierced_box(HOLE), ghost, sun)))
    made = session.bake_objects(BakeOrder(("plane",), StopRule(samples=64), density=6.0))
    assert made.balance["emitted"]["value"] > 0.0
    assert any("no light path meets 'plane'" in each for each in made.maps[0].provenance.decisions)
