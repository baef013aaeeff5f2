"""Forecasts of pictures and of measurements at sensors beside the time that they took."""

from pathlib import Path

import numpy as np

from ...common.bars import Bar
from ...common.document import make_table, tell_demands
from ...common.machine import describe_machine
from ...common.output import write_numbers
from ...common.statistics import median

SECONDS, ROUNDS = 40.0, 5
"""Processor time of a job, about [s], and jobs of each kind in each scene."""

MEDIAN = 0.1
"""Largest median relative error. [-]"""

KINDS = {"picture": "pictures", "sensors": "sensors"}
"""Of jobs, with their names in demands."""

TEXT = """# Forecasts of the time that jobs take

*Made by `lumenray benchmark forecasts`; do not edit by hand.*

To repeat it: `lumenray benchmark forecasts --json out/forecasts.json`; `--scenes`, `--seconds` and `--rounds` make it
shorter.

Pictures of a {shrink}th of the width and of the height, {width} x {height} pixels, of the scenes of the [benchmark of
pictures](pictures.md), and measurements at {sensors} sensors in each of them, down to errors that take about {seconds:g} s
of processor time, added up over the cores. What cells and the like take is part of it, and at sensors the second witness.
The forecast of the whole time is taken after {share:g} % of it, or as soon as there was one (*at*); what is told is the
forecast over what it took. Processor time does not count waiting for others who share the machine. Every job has another
seed; the error that is asked for is told from two shorter ones and two about as long.

Forecasts of lux maps are in the [benchmark of lux maps](atlas.md), those of few sensors that are measured to errors far
below what anybody asks for in the [benchmark of accuracy](accuracy.md).
"""

READING = """The end of a job is by chance itself: it ends when its error, which is estimated, is first what was asked for.
In the picture with glass and caustics, and at sensors above it, bright samples are so rare that they come late or never.
"""


def measure(scenes: tuple[str, ...], seconds: float, rounds: int, say) -> dict:
    """Measure.

    Parameters
    ----------
    scenes : tuple of str    Out of `scenes.BUILDERS` of the benchmark of pictures.
    seconds : float    Processor time of a job, about. [s]
    rounds : int    Jobs of each kind in each scene.
    say : callable    Told in one line what was done.

    Returns
    -------
    dict    Plain data, for JSON: ``median_error`` by kind and of all [-], ``machine``, ``seconds``, ``rounds``, ``scenes``:
        ``key``, ``title`` and what `jobs.measure_scene` gives.
    """
    from ....engine.transport import backend

    # Dr.Jit looks for LLVM when it is loaded, so where that lies is settled first.
    backend.start(spectral=False)
    from ..programs import processor_time
    from ..scenes import build
    from .jobs import measure_scene

    rows = []
    with processor_time():
        for key in scenes:
            scene = build(key)
            made = measure_scene(scene, seconds, rounds, lambda line, k=key: say(f"{k}: {line}"))
            rows.append({"key": key, "title": scene.title, **made})
    return {
        "median_error": summarise(rows),
        "machine": describe_machine(),
        "seconds": seconds,
        "rounds": rounds,
        "scenes": rows,
    }


def summarise(scenes: list[dict]) -> dict:
    """Median relative errors by kind, and of ``all``; a forecast that was not made is off by all. [-]"""
    errors = {kind: [_error_of(row) for scene in scenes for row in scene[kind]] for kind in KINDS}
    return {kind: median(each) for kind, each in errors.items()} | {
        "all": median([value for each in errors.values() for value in each])
    }


def check_bars(result: dict) -> list[Bar]:
    """Judge results of `measure`."""
    bars = []
    for kind, name in {"all": "pictures and sensors", **KINDS}.items():
        error = result["median_error"][kind]
        demand = f"forecast after a tenth of the time, median error, {name}"
        limit = f"{100 * MEDIAN:g} %"
        if error is None:
            bars.append(Bar(demand, limit, "-", None))
        else:
            bars.append(Bar(demand, limit, f"{100 * error:.2g} %", error <= MEDIAN))
    return bars


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document to a folder, and all numbers to a JSON file if one is named."""
    from ..scenes import SENSORS, SIZE
    from .jobs import SHRINK, TAKEN_AT

    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    machine = result["machine"]
    text = TEXT.format(
        shrink=SHRINK,
        width=SIZE[0] // SHRINK,
        height=SIZE[1] // SHRINK,
        sensors=SENSORS[0] * SENSORS[1],
        seconds=result["seconds"],
        share=100 * TAKEN_AT,
    )
    parts = [
        text,
        f"## Machine\n\n{machine['cpu']}, {machine['cores']} cores, {machine['memory_gib']} GiB, {machine['system']}; "
        f"Python {machine['python']}, Mitsuba {machine['mitsuba']}, Lumenray {machine['lumenray']}.\n",
        tell_demands(check_bars(result)),
        "## Forecast over true time\n",
        READING,
        make_table(
            "| scene | job | error, % | took, s | forecast over true | median error |",
            [row for scene in result["scenes"] for row in _tell(scene)],
            2,
        ),
    ]
    (folder / "forecasts.md").write_text("\n".join(parts), encoding="utf-8")


def _tell(scene: dict) -> list[str]:
    rows = []
    for kind in KINDS:
        made = scene[kind]
        took = float(np.median([row["seconds"] for row in made]))
        told = ", ".join(
            "none" if row["share"] is None else f"{row['share']:.2f} (at {100 * row['at']:.0f} %)"
            for row in made
        )
        off = 100.0 * median([_error_of(row) for row in made])
        rows.append(
            f"| {scene['title']} | {kind} | {100 * made[0]['target']:.2g} | {took:.3g} | {told} | {off:.0f} % |"
        )
    return rows


def _error_of(row: dict) -> float:
    return 1.0 if row["share"] is None else abs(row["share"] - 1.0)
