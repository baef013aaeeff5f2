"""Four kinds of job, whose costs are measured and which are simulated."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.baking.order import BakeOrder
from ...engine.cluster import session
from ...engine.cluster.chunks import Grain
from ...engine.cluster.session import ClusterSession
from ...engine.daylight.coefficients import DaylightOrder
from ...engine.scene.camera import Camera, Projection
from ...engine.views import ViewSettings
from ..common.pieces import rigid_frame
from .room import SIDE, build_room, place_sensors

PIXELS = (1280, 800)

DENSITY = 20.0
"""Of lux maps. [1/m]"""

SUNS, SUN_ANGLE = 60, 0.0093
"""Suns of the year, and the diameter of their disk. [rad]"""

LONG, SHORT = 10, 4
"""Chunks' worth of samples in measured jobs."""

SEED = 1


@dataclass(frozen=True)
class Kind:
    """A kind of job.

    Parameters
    ----------
    name : str
    grain : Grain    How its session cuts it.
    length : int    Of the measured job, in samples of the first chunks. With `LONG` the ninth and last chunk has twice as
        many as the others, which tells what a chunk takes beside its samples.
    build : callable    Gives the items of the scene.
    run : callable    ``run(session, rule)`` has workers do it.
    """

    name: str
    grain: Grain
    length: int
    build: Callable[[], tuple]
    run: Callable[[ClusterSession, StopRule], object]


def make_kinds() -> tuple[Kind, ...]:
    """Sensors, lux maps, a picture (whose chunks take long) and daylight, in the same room; without the second witness."""
    sensors = session.grain_of(SIDE**2, session.FEWEST_OF_SENSOR, session.SENSOR_STEP)
    sky = session.grain_of(SIDE**2, session.FEWEST_OF_SKY, session.SKY_STEP)
    pixels = session.grain_of(PIXELS[0] * PIXELS[1], session.FEWEST_OF_PIXEL, session.PIXEL_STEP)
    return (
        Kind("sensors", sensors, LONG, build_room, _measure),
        Kind("lux maps", session.LUX_GRAIN, LONG, build_room, _bake),
        Kind("picture", pixels, SHORT, build_room, _render),
        Kind("daylight", sky, LONG, lambda: build_room("-y"), _find_daylight),
    )


def _measure(door: ClusterSession, rule: StopRule):
    return door.measure(*place_sensors(), rule, SEED, method="paths", witness=False)


def _bake(door: ClusterSession, rule: StopRule):
    order = BakeOrder(("room", "block"), rule, density=DENSITY, seed=SEED, witness=False)
    return door.bake_objects(order)


def _render(door: ClusterSession, rule: StopRule):
    frame = rigid_frame((0.5, 2.0, 1.6), (1.0, 0.0, -0.1))
    camera = Camera(frame, Projection.PERSPECTIVE, *PIXELS, 1.6, 1.0)
    return door.render(camera, ViewSettings(rule, SEED, method="paths"))


def _find_daylight(door: ClusterSession, rule: StopRule):
    height = np.linspace(0.1, 1.0, SUNS)
    azimuth = np.linspace(-1.2, 1.2, SUNS)
    suns = [np.cos(height) * np.sin(azimuth), -np.cos(height) * np.cos(azimuth), np.sin(height)]
    order = DaylightOrder(np.stack(suns, axis=1), SUN_ANGLE, rule, seed=SEED)
    return door.find_daylight(*place_sensors(), order)
