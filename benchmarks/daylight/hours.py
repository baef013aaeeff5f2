"""Single hours of the room: its scene with the sky and the sun of one record, measured by itself, by whole paths."""

import time
from dataclasses import dataclass

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session
from ...engine.sky.hour import find_daylight_hours, make_hour
from ...engine.sky.solar_position import find_sun
from ...engine.sky.weather import Weather, find_hours
from .room import Room

SEED = 2800
"""To which the number of an hour is added."""


@dataclass(frozen=True, eq=False)
class Hour:
    """Illuminances of the sensors with their stated standard errors [lx], and the processors' time it took [s]."""

    illuminance: np.ndarray
    errors: np.ndarray
    seconds: float


class SingleHours:
    """The room in a session of its own, whose sky and sun are changed from hour to hour."""

    def __init__(self, room: Room, weather: Weather):
        self.room = room
        self.hours = find_hours(weather)
        self.daylight = find_daylight_hours(weather, self.hours)
        self.session = Session()
        self.session.apply(SceneDelta(changed=room.items))
        self._sent: tuple[str, ...] = ()

    def measure(self, index: int, rule: StopRule, number: int = 0) -> Hour:
        """Measure an hour; ``number`` chooses other random numbers."""
        items = tuple(
            each for each in make_hour(self.hours, self.daylight, index) if each is not None
        )
        start = time.process_time()
        if not items:
            nothing = np.zeros(len(self.room.positions))
            return Hour(nothing, nothing, time.process_time() - start)
        names = tuple(each.id for each in items)
        gone = tuple(name for name in self._sent if name not in names)
        self.session.apply(SceneDelta(changed=items, removed=gone))
        self._sent = names
        made = self.session.measure(
            self.room.positions,
            self.room.normals,
            rule,
            seed=SEED + index + 10_000 * number,
            transport="mono",
            method="paths",
        )
        return Hour(made.illuminance, made.standard_error, time.process_time() - start)


def choose_hours(weather: Weather, count: int, seed: int = 5) -> np.ndarray:
    """Return numbers of hours by chance, ascending, of those with light and a sun that is up in their middle."""
    hours = find_hours(weather)
    # The middle itself, which the sun of an hour at dusk is not taken from.
    middles = 3600.0 * (np.round(hours.times / 3600.0 - 0.5) + 0.5)
    is_light = (hours.diffuse_horizontal > 0.0) & np.isfinite(hours.direct_normal)
    is_light &= (find_sun(middles, weather.place).elevation > 1.0) & (
        np.abs(hours.times - middles) < 1.0
    )
    rng = np.random.default_rng(seed)
    return np.sort(rng.permutation(np.flatnonzero(is_light))[:count])
