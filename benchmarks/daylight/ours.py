"""A year of the room by our engine, with the errors that it states."""

import time
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.daylight.coefficients import DaylightOrder
from ...engine.daylight.light import YearLight
from ...engine.daylight.replicated import MetricEstimate
from ...engine.daylight.study import Question, judge
from ...engine.daylight.year import make_year
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session
from ...engine.sky.solar_position import RADIUS
from ...engine.sky.weather import Weather
from .room import Room


@dataclass(frozen=True, eq=False)
class OurYear:
    """A year by our engine.

    Parameters
    ----------
    illuminance, errors : (sensors, hours) array    Of every record of the weather, 0 in the dark, with stated standard
        errors. [lx]
    seconds : float    The processors' time for them, from the weather on, with kernels that were not compiled before. [s]
    metrics : dict of MetricEstimate    By name, of sensors or of the room; empty where they were not asked for.
    """

    illuminance: np.ndarray
    errors: np.ndarray
    seconds: float
    metrics: dict[str, MetricEstimate] = field(default_factory=dict)


class YearEngine(Protocol):
    """What computes a year."""

    def run(
        self, room: Room, weather: Weather, samples: int, seed: int, has_metrics: bool = False
    ) -> OurYear:
        """Compute the year with so many paths of every sensor; the same for the same seed."""


class Lumenray:
    """Our engine of the year in this process; keeps a session with the last room."""

    def __init__(self):
        self._room: Room | None = None
        self._session: Session | None = None

    def run(
        self, room: Room, weather: Weather, samples: int, seed: int, has_metrics: bool = False
    ) -> OurYear:
        """Compute the year; as of `YearEngine`."""
        if room is not self._room:
            self._room, self._session = room, Session()
            self._session.apply(SceneDelta(changed=room.items))
        start = time.process_time()
        # The ground is a surface of the scene.
        year = make_year(weather, north=0.0, ground_reflectance=0.0)
        order = DaylightOrder(
            year.suns, 2.0 * np.radians(RADIUS), StopRule(samples=samples), seed=seed
        )
        found = self._session.find_daylight(room.positions, room.normals, order, transport="mono")
        light = YearLight(found, year)
        shape = (len(room.positions), len(weather))
        values, errors = (np.zeros(shape, dtype=np.float32) for _ in range(2))
        values[:, year.lit], errors[:, year.lit] = light.illuminance()
        seconds = time.process_time() - start
        metrics = {}
        if has_metrics:
            figures = judge(light, Question(ground_reflectance=0.0))
            metrics = {f"sensors: {name}": each for name, each in figures.sensors.items()}
            metrics |= {f"room: {name}": each for name, each in figures.area.items()}
        return OurYear(values, errors, seconds, metrics)
