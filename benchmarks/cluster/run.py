"""Measures what befalls results with workers, how much more of them do, and what thousands would; writes the document."""

from pathlib import Path

from ...engine.reading.whole_file import write_whole
from ..common.bars import Bar
from ..common.document import BEARABLE_LOAD
from ..common.machine import describe_machine
from ..common.output import read_numbers, write_numbers
from ..common.parts import measure_parts
from .chart import draw_curves
from .document import describe
from .equality import measure_efficiency, measure_harm
from .scaling import measure_scaling

PARTS = ("harm", "efficiency", "scaling")

RUNS, REPEATS = 50, 3
"""Runs with harm, and runs by each number of workers."""

SAMPLES = 1 << 20
"""Of each sensor."""

WORKERS = (1, 2)

LEAST_EFFICIENCY = 0.9
"""Of two workers."""

LARGEST_ERROR = 0.1
"""Of times that are simulated."""

__all__ = ["PARTS", "check_bars", "read_results", "run", "write_results"]


def read_results(path: Path) -> dict:
    """Read the numbers of an earlier run; as `read_numbers`."""
    return read_numbers(path, {"machine", "parts", "efficiency_2"})


def run(
    parts=None,
    runs: int = RUNS,
    workers: tuple[int, ...] = WORKERS,
    repeats: int = REPEATS,
    samples: int = SAMPLES,
    say=lambda text: None,
    earlier: dict | None = None,
    elsewhere: dict | None = None,
) -> dict:
    """Measure.

    Parameters
    ----------
    parts : iterable of str or None    Which of `PARTS`; None: all.
    runs : int    With harm.
    workers : tuple of int    Numbers of them, whose efficiency is measured.
    repeats : int    By each of them.
    samples : int    Of each sensor.
    say : callable    Told of every step.
    earlier : dict or None    Results that are gone on with: without ``parts`` those that they lack are measured.
    elsewhere : dict or None    Results of another machine, whose efficiency is told too.

    Returns
    -------
    dict    Plain data, for JSON: ``machine``, ``parts``, ``elsewhere``, and the figures that demands are made on, None where
        they were not measured: ``runs``, ``equal``, ``efficiency_2``.

    Raises
    ------
    LumenrayError    There is no such part, or a machine has too few processors.
    """
    measures = {
        "harm": lambda say: measure_harm(runs, samples, say),
        "efficiency": lambda say: measure_efficiency(workers, repeats, samples, say),
        "scaling": measure_scaling,
    }
    made = measure_parts(measures, parts, earlier, say)
    harm, efficiency = made.get("harm"), made.get("efficiency")
    other = elsewhere["parts"].get("efficiency") if elsewhere else (earlier or {}).get("elsewhere")
    return {
        "runs": harm and len(harm["rows"]),
        "equal": harm and sum(row["is_equal"] for row in harm["rows"]),
        "efficiency_2": efficiency and _efficiency_of(efficiency, 2),
        "machine": describe_machine(),
        "parts": made,
        "elsewhere": other,
    }


def check_bars(result: dict) -> list[Bar]:
    """Demands, and whether they are met."""
    runs, equal, efficiency = (result[name] for name in ("runs", "equal", "efficiency_2"))
    parts = result["parts"]
    measured = [each for each in (parts.get("efficiency"), result["elsewhere"]) if each]
    checks = parts["scaling"]["checks"] if "scaling" in parts else []
    worst = max((abs(row["simulated"] / row["seconds"] - 1.0) for row in checks), default=None)
    load = parts.get("efficiency", {}).get("others")
    return [
        Bar(
            "results with the same bits, with harm",
            f"all of {runs}" if runs else "all",
            f"{equal}" if runs else "-",
            equal == runs if runs else None,
        ),
        Bar(
            "results with the same bits, by all numbers of workers",
            "all",
            "all" if all(each["is_equal"] for each in measured) else "not all",
            all(each["is_equal"] for each in measured) if measured else None,
        ),
        Bar(
            "efficiency of two workers",
            f"at least {LEAST_EFFICIENCY:g}",
            "-" if efficiency is None else f"{efficiency:.2f}{_doubt(load)}",
            None if efficiency is None else efficiency >= LEAST_EFFICIENCY,
        ),
        Bar(
            "times of one and two workers, simulated, off by",
            f"at most {LARGEST_ERROR:.0%}",
            "-" if worst is None else f"{worst:.1%}{_doubt(parts['scaling']['others'])}",
            None if worst is None else worst <= LARGEST_ERROR,
        ),
    ]


def write_results(result: dict, folder: Path, numbers: Path | None) -> None:
    """Write the document with its chart, and all numbers as JSON."""
    folder.mkdir(parents=True, exist_ok=True)
    if "scaling" in result["parts"]:
        draw_curves(result["parts"]["scaling"]["curves"], folder / "cluster.png")
    with write_whole(folder / "cluster.md") as file:
        file.write(describe(result, check_bars(result)).encode())
    write_numbers(result, numbers)


def _efficiency_of(part: dict, workers: int) -> float | None:
    own = [row["efficiency"] for row in part["rows"] if row["workers"] == workers]
    return own[0] if own else None


def _doubt(load: float | None) -> str:
    if load is None or load <= BEARABLE_LOAD:
        return ""
    return f" (others had {load:.0%} of the processors)"
