"""Effect paints: parts that can be run alone, and what they come to."""

from pathlib import Path

import numpy as np

from ...engine.reading.whole_file import write_whole
from ..common.bars import Bar
from ..common.machine import describe_machine
from ..common.output import read_numbers, write_numbers
from ..common.parts import measure_parts
from . import fits, speed, values, walks
from .document import describe
from .reference import entries

PARTS = ("reference", "walks", "tables", "speed", "fit")

CROSS_CHECKS = ("A2i.", "A3i.")
"""Values of a program that loses some light, as whoever listed them says: told, not judged."""

FLOOR = 0.02
"""Added to values of a BRDF where their difference is told relative to them. [1/sr]"""

SIGMAS = 4.0

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
        measured: ``reference_failed``, ``spectral_seconds``, ``rgb_seconds``, ``speedup_monte_carlo``, ``fit_recovered``.

    Raises
    ------
    LumenrayError    There is no such part.
    """
    measures = {
        "reference": lambda tell: judge(values.find_values(tell)),
        "walks": walks.measure,
        "tables": walks.measure_tables,
        "speed": speed.measure,
        "fit": fits.measure,
    }
    made = measure_parts(measures, parts, earlier, say)
    return _sum_up({"machine": describe_machine(), "parts": made})


def judge(found: dict) -> list[dict]:
    """Rows of all reference values: ours, theirs, the difference over what is allowed."""
    rows = []
    for name, entry in entries().items():
        if name not in found:
            rows.append({"id": name, "ratio": None, "verdict": "missing"})
            continue
        own = found[name]
        value, error = own if isinstance(own, tuple) else (own, 0.0)
        value, error = (
            np.atleast_1d(np.asarray(value, float)),
            np.atleast_1d(np.asarray(error, float)),
        )
        want = np.atleast_1d(np.asarray(entry["value"], float))
        allowed = np.full(want.shape, entry.get("tolerance", 0.0))
        if name.startswith("A8.") and name.endswith(".f"):
            allowed = allowed * (want + FLOOR)
        elif name.startswith(("A12.", "A13.", "A15.")):
            allowed = allowed * np.abs(want)
        elif name == "A9.reciprocity":
            # A bound, not a value.
            want = np.zeros(1)
        spread = np.hypot(error, np.asarray(entry.get("error", 0.0), float))
        ratio = float((np.abs(value - want) / np.maximum(allowed + SIGMAS * spread, 1e-15)).max())
        is_judged = not name.startswith(CROSS_CHECKS)
        verdict = "pass" if ratio <= 1.0 else ("FAIL" if is_judged else "apart")
        rows.append(
            {
                "id": name,
                "ours": value.tolist(),
                "reference": want.tolist(),
                "ratio": ratio,
                "verdict": verdict,
            }
        )
    return rows


def _sum_up(result: dict) -> dict:
    """Return results with the figures that demands are made on."""
    parts = result["parts"]
    reference, clock, fitted = (parts.get(name) for name in ("reference", "speed", "fit"))
    failed = None
    if reference is not None:
        failed = [row["id"] for row in reference if row["verdict"] in ("FAIL", "missing")]
    return {
        "reference_failed": failed,
        "spectral_seconds": clock and clock["spectral"]["solve_processor_seconds"],
        "rgb_seconds": clock and clock["rgb"]["solve_processor_seconds"],
        "speedup_monte_carlo": clock and clock["monte_carlo"]["speedup"],
        "fit_recovered": None if fitted is None else sum(row["recovered"] for row in fitted),
        **result,
    }


def check_bars(result: dict) -> list[Bar]:
    """Demands, and whether they are met."""

    def bar(demand, limit, measured, passed):
        return Bar(demand, limit, "-" if measured is None else measured, passed)

    parts, failed = result["parts"], result["reference_failed"]
    bars = [
        bar(
            "reference values apart",
            "none",
            None if failed is None else f"{len(failed)}",
            None if failed is None else not failed,
        )
    ]
    for name, words in (
        ("continuum", "photons in a continuum"),
        ("discs", "photons among thinly sown discs"),
    ):
        rows = parts.get("walks", {}).get(name)
        worst = rows and max(row["sigmas"] for row in rows)
        bars.append(
            bar(
                f"albedo against {words}, 30 compositions",
                f"{SIGMAS:g} standard errors",
                rows and f"{worst:.2g} at most",
                rows and worst <= SIGMAS,
            )
        )
    tables = parts.get("tables")
    for key, words, limit in (
        ("clamped", "T4: light that is clamped", 1e-4),
        ("reciprocity", "T3: reciprocity of tables", 0.02),
        ("energy", "T1: largest total of tables", 1.0 + 1e-6),
        ("furnace", "T2: light that paints without absorption lose", 1e-3),
    ):
        worst = tables and max(row[key] for row in tables)
        bars.append(
            bar(words, f"{limit:.2g}", tables and f"{worst:.2g}", tables and worst <= limit)
        )
    clock = parts.get("speed")
    for value, words, limit in (
        (result["spectral_seconds"], "33 bands, two layers", 0.5),
        (result["rgb_seconds"], "RGB, two layers", 0.1),
        (
            clock and clock["sphere"]["processor_seconds"],
            "sphere of 256 x 256 after a slider's move",
            0.2,
        ),
    ):
        bars.append(
            bar(
                words,
                f"{limit} s",
                value and f"{value:.3f} s of processors",
                value and value <= limit,
            )
        )
    value = result["speedup_monte_carlo"]
    bars.append(
        bar(
            "walks from direction to direction, for the same table at the same error",
            "100 times as long",
            value and f"{value:.3g}",
            value and value >= 100.0,
        )
    )
    found = result["fit_recovered"]
    bars.append(
        bar(
            "fits within one standard error",
            "9 of 10",
            None if found is None else f"{found}",
            None if found is None else found >= 9,
        )
    )
    slowest = parts.get("fit") and max(row["processor_seconds"] for row in parts["fit"])
    bars.append(
        bar(
            "slowest fit",
            "120 s",
            slowest and f"{slowest:.0f} s of processors",
            slowest and slowest <= 120.0,
        )
    )
    return bars


def write_results(result: dict, folder: Path, numbers: Path | None) -> None:
    """Write the document, and all numbers as JSON."""
    text = describe(result, check_bars(result))
    folder.mkdir(parents=True, exist_ok=True)
    with write_whole(folder / "paint.md") as file:
        file.write(text.encode())
    if numbers is not None:
        write_numbers(result, numbers)
