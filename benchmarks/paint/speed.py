"""How long a paint takes, by the clock and by processors, and what Monte Carlo would take for the same table."""

import time

import numpy as np

from ...engine.paint.photon_walk import walk
from ...engine.paint.solution import Resolution, solve
from ...engine.paint.tabulation import PREVIEW, STANDARD, tabulate
from .makers import interference, make_paint, mirrors

RUNS = 7

PREVIEW_BANDS = (450.0, 550.0, 610.0)

PREVIEW_RESOLUTION = Resolution(16, 16)

PHOTONS = 60_000


def two_layers():
    """A pearl coat over a metallic base with pigment."""
    grains = {"medium": {"extinction_per_um": 0.05, "albedo": 0.9, "asymmetry": 0.5}}
    layers = [
        (20, [interference(448, 1.5, 12, 0.17)], [], 1.45),
        (15, [mirrors(0.8, 6, 0.2)], [grains], 1.45),
    ]
    return make_paint(layers, 0.3)


def measure(say) -> dict:
    """Seconds, the least of several runs, warm; beside them the processors' seconds of the same run."""
    paint = two_layers()
    found = {}
    for name, options, step in (
        ("spectral", {}, STANDARD),
        ("rgb", {"wavelengths": PREVIEW_BANDS, "resolution": PREVIEW_RESOLUTION}, PREVIEW),
    ):
        rows = []
        for _ in range(RUNS):
            start = time.perf_counter(), time.process_time()
            solution = solve(paint, **options)
            middle = time.perf_counter(), time.process_time()
            table = tabulate(solution, step)
            end = time.perf_counter(), time.process_time()
            rows.append((*np.subtract(middle, start), *np.subtract(end, start)))
        solved, solved_cpu, whole, whole_cpu = np.min(rows, axis=0)
        found[name] = {
            "solve_seconds": solved,
            "solve_processor_seconds": solved_cpu,
            "seconds": whole,
            "processor_seconds": whole_cpu,
            "values": table.values.size,
        }
        say(f"{name}: {solved:.3f} s solved, {whole:.3f} s with its table")
    start = time.process_time()
    made = walk(paint, 550.0, np.radians(45.0), PHOTONS, 1)
    each = (time.process_time() - start) / PHOTONS
    table = tabulate(solve(paint, [550.0], is_polarised=False), STANDARD)
    found["monte_carlo"] = _cost_of_photons(table, each, found["spectral"]["processor_seconds"])
    found["monte_carlo"]["photons_per_second"] = 1.0 / each
    del made
    say(f"Monte Carlo: {found['monte_carlo']['speedup']:.3g} times as long")
    return found


def _cost_of_photons(table, each: float, seconds: float) -> dict:
    """Time of photons for the mean of each cell of a table to be known to 4 %, if all bands went in one walk.

    Of cells that hold less than a thousandth of the light nothing is asked.
    """
    incidence, radial, azimuth = table.incidences, table.radials, table.azimuths
    middle = 0.5 * (radial[1:] + radial[:-1])
    solid = 2.0 * np.sin(middle)[:, None] * np.diff(radial)[:, None] * np.diff(azimuth)
    values = table.values[0, :, :-1, :-1, 0]
    share = values * solid * np.cos(np.minimum(middle, 1.2))[:, None]
    share = np.where(share > 1e-3, share, np.inf)
    # Of each incidence the least of what counts, the median over incidences.
    least = np.median(share.reshape(len(incidence), -1).min(axis=1))
    photons = 1.0 / (0.04**2 * least)
    whole = photons * len(incidence) * each
    return {"cell_share": float(least), "seconds": float(whole), "speedup": float(whole / seconds)}
