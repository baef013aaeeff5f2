"""What the benchmark asks of our engine: a year of the room with the errors that it states."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ...engine.sky.weather import Weather
from .room import Room


@dataclass(frozen=True, eq=False)
class OurYear:
    """A year by our engine.

    Parameters
    ----------
    illuminance, errors : (sensors, hours) array    Of every record of the weather, 0 in the dark, with stated standard
        errors. [lx]
    seconds : float    The processors' time for all of it, kernels included that were not compiled before. [s]
    metrics : dict    By name, values and stated standard errors, each a (k,) array: of sensors, or one of the room. Of any
        unit.
    """

    illuminance: np.ndarray
    errors: np.ndarray
    seconds: float
    metrics: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)


class YearEngine(Protocol):
    """Our engine of the year."""

    def run(self, room: Room, weather: Weather, samples: int, seed: int) -> OurYear:
        """Compute the year with so many paths of every sensor; the same for the same seed."""
