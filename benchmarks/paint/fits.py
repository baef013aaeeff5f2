"""Compositions found again from colours that they were computed to have."""

import time

import numpy as np

from ...engine.paint.fitting import LabReadings, Parameter, fit_paint, with_values
from ...engine.paint.readings import SIX, read_lab
from ...engine.paint.solution import solve
from .makers import interference, mirrors, one_layer

FITS = 10

ERROR = 0.3
"""Standard error that readings are said to have; they are rounded to a tenth."""

COLD = (350.0, 0.06, 8.0)
"""Core [nm], area [1/um] and tilt [deg] that each fit is told of; it looks in bounds about these."""

PLACES = (
    ("layers/0/flakes/0/stack/core/thickness_nm", 175.0, 700.0),
    ("layers/0/flakes/0/amount/area_per_volume_per_um", 0.0075, 0.48),
    ("layers/0/flakes/0/tilt_deg", 1.5, 20.0),
)


def measure(say) -> list[dict]:
    """Truth, what was found, its standard errors, and seconds, of every fit."""
    rng = np.random.default_rng(2026)
    rows = []
    parameters = [Parameter(*place) for place in PLACES]
    for number in range(FITS):
        truth = (
            float(rng.uniform(200.0, 650.0)),
            float(rng.uniform(0.02, 0.2)),
            float(rng.uniform(3.0, 9.0)),
        )
        flakes = [interference(truth[0], 1.6, float(rng.uniform(20.0, 90.0)), truth[1], truth[2])]
        if number % 3 == 2:
            # Some with aluminium among the pearl, of known amount.
            flakes.append(mirrors(0.85, 10.0, 0.02))
        paint = one_layer(flakes, float(rng.uniform(0.0, 0.6)))
        lab = np.round(read_lab(solve(paint), SIX), 1)
        cold = with_values(paint.content, parameters, COLD)
        start = time.perf_counter(), time.process_time()
        found = fit_paint(cold, LabReadings(np.array(SIX), lab, ERROR), parameters, seed=number)
        clock, processors = time.perf_counter() - start[0], time.process_time() - start[1]
        away = np.abs(found.values - truth) / found.errors
        rows.append(
            {
                "truth": truth,
                "found": found.values.tolist(),
                "errors": found.errors.tolist(),
                "sigmas": away.tolist(),
                "recovered": bool((away < 1.0).all()),
                "residual": found.residual,
                "seconds": clock,
                "processor_seconds": processors,
            }
        )
        say(
            f"fit {number + 1}: {'found' if rows[-1]['recovered'] else 'not found'}, {processors:.0f} s of processors"
        )
    return rows
