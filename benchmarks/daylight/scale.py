"""How long a year takes at many sensors."""

import os
import time

from ...engine.sky.weather import Weather
from .ours import YearEngine
from .room import make_room
from .year import relative_error

COLUMNS, ROWS = 100, 100
"""Sensors along the room's width and depth."""

SAMPLES = 1 << 10
"""Paths of every sensor."""


def measure_scale(
    engine: YearEngine,
    weather: Weather,
    say=lambda text: None,
    columns: int = COLUMNS,
    rows: int = ROWS,
    samples: int = SAMPLES,
) -> dict:
    """Time a year at so many sensors.

    Returns
    -------
    dict    ``sensors``, ``samples``, ``cores``, ``minutes`` by the clock, ``processor_minutes``, and ``error``: the stated
        one, as `year.relative_error` has it.
    """
    room = make_room(columns, rows)
    engine.run(make_room(2, 2), weather, samples, seed=1)
    start = time.perf_counter()
    made = engine.run(room, weather, samples, seed=2)
    minutes = (time.perf_counter() - start) / 60.0
    lit = made.illuminance.any(axis=0)
    say(f"scale: {len(room.positions)} sensors take {minutes:.1f} minutes")
    return {
        "sensors": len(room.positions),
        "samples": samples,
        "cores": os.cpu_count(),
        "minutes": minutes,
        "processor_minutes": made.seconds / 60.0,
        "error": relative_error(made.illuminance[:, lit], made.errors[:, lit]),
    }
