"""How long a paint takes, and what walks from direction to direction would take for the same table."""

import time

import numpy as np

from ...engine import llvm
from ...engine.paint.solution import Resolution, solve
from ...engine.paint.sphere import paint_sphere
from ...engine.paint.tabulation import (
    FLOOR,
    LOWEST,
    PREVIEW,
    STANDARD,
    compute,
    random_directions,
    tabulate,
)
from ...engine.scattering.data.table import direction_of, evaluate_table
from .makers import interference, make_paint, mirrors

RUNS = 7

GRAINS = {"medium": {"extinction_per_um": 0.05, "albedo": 0.9, "asymmetry": 0.5}}

PREVIEW_BANDS = (450.0, 550.0, 610.0)

PREVIEW_RESOLUTION = Resolution(16, 16)

PAIRS, WALKS = 192, 4096
"""Directions at which a walk is judged, and how many walks each gets."""

AT_ONCE = 4
"""Wavelengths that a renderer follows in one walk, said to cost no more than one."""

BAND = 550.0
"""Of the walks. [nm]"""

TESTED = 10_000
"""Pairs of directions by which the error of a table is told."""


def two_layers():
    """A pearl coat over a metallic base with pigment."""
    layers = [
        (20, [interference(448, 1.5, 12, 0.17)], [], 1.45),
        (15, [mirrors(0.8, 6, 0.2)], [GRAINS], 1.45),
    ]
    return make_paint(layers, 0.3)


def measure(say) -> dict:
    """Seconds, the least of several runs, warm: by the clock, and of processors, which others do not lengthen."""
    paint = two_layers()
    found = {}
    for name, options, step in (
        ("spectral", {}, STANDARD),
        ("rgb", {"wavelengths": PREVIEW_BANDS, "resolution": PREVIEW_RESOLUTION}, PREVIEW),
    ):
        solved = _least(lambda options=options: solve(paint, **options))
        solution = solve(paint, **options)
        tabulated = _least(lambda solution=solution, step=step: tabulate(solution, step))
        found[name] = {
            "solve_seconds": solved[0],
            "solve_processor_seconds": solved[1],
            "seconds": solved[0] + tabulated[0],
            "processor_seconds": solved[1] + tabulated[1],
            "values": tabulate(solution, step).values.size,
        }
        say(f"{name}: {solved[1]:.3f} s of processors")
    number = iter(range(1000))

    def slide():
        """Draw the sphere of a paint whose sliders all moved: nothing kept from the one before serves."""
        share = 1.0 + 0.01 * next(number)
        layers = [
            (
                20,
                [interference(448 * share, 1.5, 12, 0.17 * share, 3 * share)],
                [],
                1.45 * share**0.1,
            ),
            (15, [mirrors(0.8, 6 * share, 0.2)], [GRAINS], 1.45 * share**0.1),
        ]
        paint_sphere(make_paint(layers, 0.3))

    seconds = _least(slide)
    found["sphere"] = {"seconds": seconds[0], "processor_seconds": seconds[1]}
    say(f"sphere: {seconds[1]:.3f} s of processors")
    found["monte_carlo"] = _compare(paint, found["spectral"])
    say(f"Monte Carlo: {found['monte_carlo']['speedup']:.3g} times as long")
    return found


def _least(function) -> tuple[float, float]:
    """Least of several runs after a first, by the clock and of processors. [s]"""
    function()
    rows = []
    for _ in range(RUNS):
        start = time.perf_counter(), time.process_time()
        function()
        rows.append((time.perf_counter() - start[0], time.process_time() - start[1]))
    return tuple(float(each) for each in np.min(rows, axis=0))


def _compare(paint, spectral: dict) -> dict:
    """What walks from direction to direction would take for the same table at the same error."""
    # Dr.Jit looks for LLVM once, as it is imported.
    llvm.settle()
    from .direction_walk import estimate

    made = compute(paint, is_polarised=False)
    table = made.table
    number = int(np.argmin(np.abs(table.wavelengths - BAND)))
    rng = np.random.default_rng(7)
    wi, wo, count = _nodes_of(table, rng)
    walked = estimate(paint, BAND, wi, wo, WALKS, 1)
    true = made.solution.evaluate(wi, wo)[:, number]
    pairs = random_directions(rng, TESTED), random_directions(rng, TESTED)
    direct = made.solution.evaluate(*pairs)
    error = float(
        np.sqrt((((evaluate_table(table, *pairs) - direct) / (direct + FLOOR)) ** 2).mean())
    )
    away = (walked.values - true) / np.sqrt(walked.variances / walked.walks)
    needed = float((walked.variances / (true + FLOOR) ** 2).mean()) / error**2
    one = needed * count * walked.seconds_each
    whole = one * len(table.wavelengths) / AT_ONCE
    return {
        "walk_seconds": walked.seconds_each,
        "error": error,
        "walks_of_each": needed,
        "directions": count,
        "mean_square_sigmas": float((away**2).mean()),
        "seconds_of_one_walk_for_all_bands": one,
        "seconds": whole,
        "speedup_of_one_walk_for_all_bands": one / spectral["processor_seconds"],
        "speedup": whole / spectral["processor_seconds"],
    }


def _nodes_of(table, rng):
    """Some pairs of directions at which a table has values above the horizon, and how many there are."""
    axes = np.meshgrid(table.incidences, table.radials, table.azimuths, indexing="ij")
    incidence, radial, azimuth = (each.ravel() for each in axes)
    wo = direction_of(incidence, radial, azimuth)
    above = np.flatnonzero(wo[:, 2] > LOWEST)
    chosen = rng.choice(above, PAIRS, replace=False)
    incidence = incidence[chosen]
    wi = np.stack([np.sin(incidence), np.zeros(PAIRS), np.cos(incidence)], axis=1)
    return wi, wo[chosen], len(above)
