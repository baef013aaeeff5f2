"""C37: illuminances under surroundings from a picture."""

import numpy as np

from lumenray.engine.scene.light import ImageWorld
from lumenray.engine.scene.sensor import SensorKind
from lumenray.engine.scene.texture import ImageTexture

from ..bench import Bench, Finding, Findings
from ..reference import Group
from .registry import case

LUMINANCE = 1000.0
"""Of the bright rows. [cd/m2]"""

REACH = np.radians(22.5)
"""Angle of the cap from its axis, and of the band from the horizon. [rad]"""

TILT = np.radians(60.0)
"""From the zenith to the middle of the cap that is turned towards +x. [rad]"""

TOWARDS_X = np.array(
    [
        [np.cos(TILT), 0.0, -np.sin(TILT)],
        [0.0, 1.0, 0.0],
        [np.sin(TILT), 0.0, np.cos(TILT)],
    ]
)
"""From the world's directions to those of the turned picture."""


@case("C37", "Surroundings from a picture", "daylight", quick=("C37.cap16", "C37.ramp"))
def pictures(bench: Bench) -> Findings:
    """A cap and a band in rows of pixels, over planes of every kind."""
    for key, group in bench.groups("C37").items():
        yield _measure(bench, group, _world(key.removeprefix("C37.")))


def _world(name: str) -> ImageWorld:
    rows = 256 if name == "cap256" else 16
    # The middles of rows, from the nadir up.
    height = np.pi * ((np.arange(rows) + 0.5) / rows - 0.5)
    is_band = name in {"band", "sphere"}
    bright = np.abs(height) < REACH if is_band else height > 0.5 * np.pi - REACH
    pixels = np.tile(np.where(bright, 1.0, 0.0)[:, None, None], (1, 2 * rows, 3))
    image = ImageTexture(
        pixels.astype(np.float32), interpolation="linear" if name == "ramp" else "closest"
    )
    return ImageWorld(image, LUMINANCE, TOWARDS_X if name == "turned" else np.eye(3))


def _measure(bench: Bench, group: Group, world: ImageWorld) -> Finding:
    kind = SensorKind.SPHERICAL if group.id == "C37.sphere" else SensorKind.PLANAR
    return bench.measure_group((world,), group, kind=kind)
