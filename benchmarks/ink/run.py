"""Dense pigment layers: parts that can be run alone, and what they come to."""

from pathlib import Path

import numpy as np

from ...engine.reading.whole_file import write_whole
from ..common.bars import Bar
from ..common.machine import describe_machine
from ..common.output import read_numbers, write_numbers
from ..common.parts import measure_parts
from . import series, shipped, trend, values
from .document import describe, draw_series, draw_trend

PARTS = ("reference", "dense", "trend", "series", "presets", "processes")

SIGMAS = 4.0

BOUNDS = ("C3.reciprocity",)
"""Values that are bounds: what is found has to be below the tolerance."""

TIGHT = {"C2.slab": 1e-8, "C2.ls": 1e-6, "C2.multilayer": 2e-4, "C3.reciprocity": 1e-10}
"""Tolerances in place of those that are stated: of `C2.multilayer`, of what two grids extrapolate to."""

__all__ = ["PARTS", "check_bars", "read_results", "run", "write_results"]


def read_results(path: Path) -> dict:
    """Read the numbers of an earlier run; as `read_numbers`."""
    return read_numbers(path, {"machine", "parts", "reference_failed"})


def run(parts=None, say=lambda text: None, earlier: dict | None = None) -> dict:
    """Measure.

    Parameters
    ----------
    parts : iterable of str or None    Which of `PARTS`; None: all.
    say : callable    Told of every step.
    earlier : dict or None    Results that are gone on with: without ``parts`` those that they lack are measured.

    Returns
    -------
    dict    Plain data, for JSON: ``machine``, ``parts``, and the figures that demands are made on, None where they were not
        measured: ``reference_failed``, ``convergence_order``, ``energy_error``, ``two_process_gain``.

    Raises
    ------
    LumenrayError    There is no such part.
    """
    measures = {
        "reference": _measure_reference,
        "dense": lambda tell: judge(values.find_dense(tell), is_dense=True),
        "trend": trend.measure_trend,
        "series": series.measure_series,
        "presets": shipped.measure_presets,
        "processes": trend.measure_processes,
    }
    made = measure_parts(measures, parts, earlier, say)
    return _sum_up({"machine": describe_machine(), "parts": made})


def judge(found: dict, is_dense: bool) -> list[dict]:
    """Rows of reference values: ours, theirs, the difference over what is allowed."""
    rows = []
    for name, entry in values.entries().items():
        if name.startswith(("C9.", "C10.")) != is_dense:
            continue
        if name not in found:
            rows.append({"id": name, "ratio": None, "verdict": "missing"})
            continue
        own, error = found[name]
        own, want = (np.atleast_1d(np.asarray(each, float)) for each in (own, entry["value"]))
        tolerance = next(
            (v for key, v in TIGHT.items() if name.startswith(key)), entry["tolerance"]
        )
        allowed = np.full(want.shape, tolerance)
        if name.startswith(("C4.ls", "C7.", "C10.")):
            allowed = tolerance * np.abs(want) if not name.startswith("C7.") else want * 1e-6
        if name in BOUNDS:
            want = np.zeros(1)
        spread = np.hypot(error, np.asarray(entry.get("error", 0.0), float))
        ratio = float((np.abs(own - want) / (allowed + SIGMAS * spread)).max())
        rows.append(
            {
                "id": name,
                "ours": own.tolist(),
                "reference": want.tolist(),
                "ratio": ratio,
                "verdict": "pass" if ratio <= 1.0 else "FAIL",
            }
        )
    return rows


def _measure_reference(say) -> dict:
    rows = judge(values.find_values(say), is_dense=False)
    say("convergence")
    errors = [abs(values.energy_error(is_absorbing)) for is_absorbing in (False, True)]
    return {"rows": rows, "order": values.convergence_order(), "energy_error": max(errors)}


def _sum_up(result: dict) -> dict:
    parts = result["parts"]
    reference, dense, clock = (parts.get(name) for name in ("reference", "dense", "processes"))
    failed = None
    if reference is not None or dense is not None:
        rows = [*(reference["rows"] if reference else []), *(dense or [])]
        failed = [row["id"] for row in rows if row["verdict"] != "pass"]
    return {
        "reference_failed": failed,
        "convergence_order": reference and reference["order"],
        "energy_error": reference and reference["energy_error"],
        "two_process_gain": clock and clock["gain"],
        **result,
    }


def check_bars(result: dict) -> list[Bar]:
    """Demands, and whether they are met."""

    def bar(demand, limit, measured, passed):
        return Bar(demand, limit, "-" if measured is None else measured, passed)

    failed, order, energy, gain = (
        result[name]
        for name in ("reference_failed", "convergence_order", "energy_error", "two_process_gain")
    )
    clock = result["parts"].get("processes")
    linear = clock and clock["twice_the_realisations"]
    presets = result["parts"].get("presets")
    unsolved = presets and [row["name"] for row in presets if row["problem"]]
    return [
        bar(
            "reference values apart",
            "none",
            None if failed is None else f"{len(failed)}",
            None if failed is None else not failed,
        ),
        bar(
            "order in the grid's step",
            "2",
            order and f"{order:.3f}",
            order and abs(order - 2.0) < 0.1,
        ),
        bar("energy", "1e-8", energy and f"{energy:.1g}", energy and energy <= 1e-8),
        bar("two processes", "1.8 times one", gain and f"{gain:.2f}", gain and gain >= 1.8),
        bar(
            "twice the realisations",
            "twice the time, 15 % apart at most",
            linear and f"{linear:.2f}",
            linear and abs(linear / 2.0 - 1.0) <= 0.15,
        ),
        bar(
            "presets that cannot be solved",
            "none",
            presets and (", ".join(unsolved) or "none"),
            presets and not unsolved,
        ),
    ]


def write_results(result: dict, folder: Path, numbers: Path | None) -> None:
    """Write the document with its picture, and all numbers as JSON."""
    text = describe(result, check_bars(result))
    folder.mkdir(parents=True, exist_ok=True)
    with write_whole(folder / "ink.md") as file:
        file.write(text.encode())
    if "trend" in result["parts"]:
        draw_trend(result["parts"]["trend"]).save(folder / "ink_sizes.png")
    if "series" in result["parts"]:
        draw_series(result["parts"]["series"]).save(folder / "ink_series.png")
    if numbers is not None:
        write_numbers(result, numbers)
