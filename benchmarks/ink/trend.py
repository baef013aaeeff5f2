"""Colours of prints by the size of their particles, and what processes and realisations cost."""

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

SIZES = (0.0, 0.1, 0.2, 0.3)
"""Diameters; 0: molecules. Where a layer of larger ones is clear, waves run along it for long, minutes a band. [um]"""

TIMED = {"realisations": 4, "columns": 48, "layers": 32}
"""Plan by which processes are timed."""

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
                    "wavelengths_nm": made.printed.wavelengths,
                    "reflectance": made.readings,
                    "standard_errors": made.standard_errors,
                    "lab": lab,
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
    """Time the same job by the clock with one process and two, and with twice the realisations."""
    content = read_object(inks.presets()["cyan_medium"], LARGEST_FILE)
    ink = parse_ink(content)
    plan = replace(make_plan(ink, draft=True), wavelengths=(450.0, 550.0, 650.0), **TIMED)
    seconds = {}
    for name, processes, realisations in (("one", 1, 4), ("two", 2, 4), ("twice", 1, 8)):
        say(f"{processes} processes, {realisations} realisations")
        with tempfile.TemporaryDirectory() as folder:
            start = time.perf_counter()
            solve_ensemble(ink, replace(plan, realisations=realisations), Path(folder), processes)
            seconds[name] = time.perf_counter() - start
    return {
        "seconds": seconds,
        "gain": seconds["one"] / seconds["two"],
        "twice_the_realisations": seconds["twice"] / seconds["one"],
    }
