"""Isolux lines of a field that is known exactly, and the time that a slider of light groups takes."""

import time

import numpy as np

from ...engine.accuracy.group_sum import GroupSum
from ...engine.analysis.contours import find_contours

LUMEL, SIZE = 0.125, (96, 72)
"""Side of a lumel [m], and how many the map has across and along."""

HEIGHT, INTENSITY, FOOT = 2.5, 1000.0, (5.0, 4.0)
"""Of a lamp over the map, and the point below it. [m, cd]"""

LEVELS = (10.0, 20.0, 30.0, 50.0, 75.0, 100.0, 150.0)
"""Of the lines. [lx]"""

GROUPS, LUMELS, MOVES = 20, 4_000_000, 12
"""Light groups, lumels, and how often a slider is moved."""


def measure() -> dict[str, float]:
    """Largest distance of isolux lines from the exact circles, and the time from a slider to mean and extremes.

    Returns
    -------
    dict    ``isolux_lumels`` [lumel]; ``slider_ms``: median of processor time. [ms]
    """
    return {"isolux_lumels": measure_lines(), "slider_ms": 1e3 * measure_slider()}


def measure_lines() -> float:
    """Largest distance of the lines below a lamp from the circles that they should be. [lumel]"""
    x, y = (LUMEL * (np.arange(count) + 0.5) for count in SIZE)
    square = HEIGHT**2 + (x[None] - FOOT[0]) ** 2 + (y[:, None] - FOOT[1]) ** 2
    field = INTENSITY * HEIGHT / square**1.5
    largest = 0.0
    for level, paths in find_contours(x, y, field, LEVELS):
        radius = np.sqrt((INTENSITY * HEIGHT / level) ** (2.0 / 3.0) - HEIGHT**2)
        away = np.hypot(*(np.concatenate(paths) - FOOT).T)
        largest = max(largest, float(np.abs(away - radius).max()))
    return largest / LUMEL


def measure_slider(groups: int = GROUPS, lumels: int = LUMELS, moves: int = MOVES) -> float:
    """Processor time from a group's new level to the sum, its variance, mean and extremes. [s]"""
    rng = np.random.default_rng(1)
    values = rng.random((groups, lumels), dtype=np.float32)
    made = GroupSum(values, 0.01 * values)
    levels = np.ones(groups)
    made.set_levels(levels)
    made.describe()
    seconds = []
    for move in range(moves):
        levels[move % groups] = 0.5
        start = time.process_time()
        made.set_levels(levels)
        made.describe()
        seconds.append(time.process_time() - start)
    return float(np.median(seconds))
