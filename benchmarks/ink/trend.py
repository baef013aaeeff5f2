"""Colours of prints by the size of their particles, and what processes and realisations cost."""

import os
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...engine.ink.computed import compute
from ...engine.ink.ensemble import solve_ensemble
from ...engine.ink.plan import make_plan
from ...engine.ink.reader import parse_ink
from ...libraries import inks
from ...libraries.plain_files import read_object

COLOURS = ("cyan", "magenta", "yellow")

SIZES = (0.0, 0.1, 0.2, 0.3, 0.45)
"""Diameters; 0: molecules. [um]"""

TIMED = {"realisations": 24, "columns": 48, "layers": 32}
"""Plan by which processes are timed."""

ROUNDS = 3

LARGEST_FILE = 1 << 20


def measure_trend(say) -> list[dict]:
    """Solve the shipped pigments at 30 % of the volume in every size, as drafts."""
    rows = []
    for colour in COLOURS:
        content = read_object(inks.presets()[f"{colour}_medium"], LARGEST_FILE)
        for size in SIZES:
            say(f"{colour} {size:g} um")
            (pigment,) = content["pigments"]
            own = {
                name: v for name, v in pigment.items() if name not in ("median_um", "log_spread")
            }
            ink = parse_ink(content | {"pigments": [own | {"median_um": size}]})
            made = compute(ink, make_plan(ink, draft=True))
            lab = made.lab
            rows.append(
                {
                    "colour": colour,
                    "size_um": size,
                    "wavelengths_nm": made.printed.wavelengths.tolist(),
                    "reflectance": made.readings.tolist(),
                    "standard_errors": made.standard_errors.tolist(),
                    "lab": lab.tolist(),
                    "lab_error": made.lab_error,
                    "chroma": float(np.hypot(lab[1], lab[2])),
                    "absorbed": float(
                        made.printed.film.absorbed("above")[int(np.argmin(made.readings)), 0]
                    ),
                    "grid_error": made.grid_error,
                    "iterations": made.iterations,
                }
            )
    return rows


def measure_processes(say) -> dict:
    """Time the same job with one process and two, in turns, and with twice the realisations.

    The clock is judged, by the median of the rounds, so nothing else should run. Processor seconds, which others lengthen
    less, tell how much of what is missing to twice is work that two processes do more.
    """
    content = read_object(inks.presets()["cyan_medium"], LARGEST_FILE)
    ink = parse_ink(content)
    plan = replace(make_plan(ink, draft=True), wavelengths=(450.0, 550.0, 650.0), **TIMED)
    rounds = []
    for number in range(ROUNDS):
        say(f"one process and two, round {number + 1} of {ROUNDS}")
        rounds.append([_time(ink, plan, processes) for processes in (1, 2)])
    say("twice the realisations")
    _, twice = _time(ink, replace(plan, realisations=2 * plan.realisations), 1)
    once, both = np.median([[each[1] for each in pair] for pair in rounds], axis=0).tolist()
    return {
        "clock_seconds": [[each[0] for each in pair] for pair in rounds],
        "processor_seconds": {"one": once, "two": both, "twice": twice},
        "gain": float(np.median([one[0] / two[0] for one, two in rounds])),
        "gain_of_processors": 2.0 * once / both,
        "twice_the_realisations": twice / once,
    }


def _time(ink, plan, processes: int) -> tuple[float, float]:
    """Seconds of a job by the clock, and those of the processors in what it started."""
    with tempfile.TemporaryDirectory() as folder:
        start, before = time.perf_counter(), os.times()
        solve_ensemble(ink, plan, Path(folder), processes)
        seconds, after = time.perf_counter() - start, os.times()
    used = after.children_user + after.children_system
    return seconds, used - before.children_user - before.children_system
