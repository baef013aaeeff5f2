"""Measures what modelling only what a scene needs saves, and writes the document."""

import time
from pathlib import Path

import numpy as np

from ...engine.reading.whole_file import write_whole
from ..common.bars import Bar
from ..common.document import make_table, tell_demands
from ..common.machine import describe_machine
from ..common.output import read_numbers, write_numbers
from ..common.statistics import geometric_mean, median
from . import bounds, race, starts
from .scenes import BUILDERS, build

SEEDS = 20
"""Runs of each scene, all automatic."""

LEAST_SPEEDUP, LEAST_SLOWEST = 2.0, 0.95
"""Time of everything modelled in full over that of what is needed: geometric mean, and in the worst scene."""

MOST_IMPORT, MOST_EXPLAIN, MOST_ENABLING = 0.1, 3.0, 0.3
"""Times of starting. [s]"""

FEW = 3
"""Scenes that gain most, without which the mean is told, too."""

SURE = 1.645
"""Standard errors beyond which, with 95 %, a true error is over the asked one."""

TEXT = """# What a scene needs

*Made by `lumenray benchmark requirements`; do not edit by hand.*

Twelve scenes, illuminance at 1000 to 2000 sensors to an error of {error:g} %: all automatic, against everything
modelled in full, every decision switched off as by `--model all=off` (with wavelengths, drawn evenly, by full paths on
which roulette begins at the third vertex, as many samples for all sensors, the rays of ray sets everywhere, nothing merged
or left out). Seconds are those of the processors, with kernels made
and the scene compiled, without the second witness, which costs both the same; of runs in full of
more than {longest:g} s and automatic ones of more than {own:g} s, marked by \\*, they are reckoned from the error that was
reached, and the latter, {few} in place of {seeds}, are judged by the error that they state. What a ray file leaves open
between its rays more samples do not lower: it is stated, and no part of this reckoning. *True error*: root mean square of
{seeds} runs over the sensors, over their mean, against the runs in full; *at most* where these may be off by more
themselves.
{cpu}, {cores} cores.

"""


def run(
    seeds: int = SEEDS,
    keys=None,
    count: int = bounds.COUNT,
    earlier: dict | None = None,
    say=None,
    save=None,
) -> dict:
    """Measure.

    Parameters
    ----------
    seeds : int    Runs of each scene, all automatic.
    keys : collection of str or None    Of scenes, see `BUILDERS`; None: all.
    count : int    Random scenes in which bounds are tried.
    earlier : dict or None    Results to go on with: scenes and random rooms that it has are not measured again.
    say, save : callable or None    Told of progress in words, and of the results so far.

    Returns
    -------
    dict    Plain data for JSON.
    """
    say = say or (lambda line: None)
    made = earlier or {"scenes": {}}
    made |= {"machine": describe_machine(), "seeds": seeds}
    for key in keys or BUILDERS:
        if key in made["scenes"]:
            continue
        begin = time.perf_counter()
        row = race.race(build(key), seeds)
        made["scenes"][key] = row
        error, doubt = race.true_error(row)
        say(
            f"{key}: {row['seconds']:.2f} s, in full {row['full_seconds']:.3g} s, true error {100.0 * error:.2f} ± "
            f"{100.0 * doubt:.2f} %; measured in {time.perf_counter() - begin:.0f} s"
        )
        if save is not None:
            save(_sum_up(made))
    if "starts" not in made:
        made["starts"] = starts.measure(say)

    def keep(rows: list[dict], tried: int) -> None:
        made.update(bounds=rows, count=tried)
        if save is not None:
            save(_sum_up(made))

    tried = made.get("count", 0)
    if tried < count:
        keep(bounds.measure(count, say, made.get("bounds", ()), tried, keep), count)
    return _sum_up(made)


def _sum_up(made: dict) -> dict:
    """The results with what is judged by."""
    ratios = [row["full_seconds"] / row["seconds"] for row in made["scenes"].values()]
    # In their own order, whichever were measured anew.
    place = {key: number for number, key in enumerate(BUILDERS)}
    in_order = dict(sorted(made["scenes"].items(), key=lambda each: place.get(each[0], len(place))))
    return made | {
        "scenes": in_order,
        "speedup": geometric_mean(ratios) if ratios else None,
        "slowest": min(ratios, default=None),
        "over_asked": sum(map(_is_over, made["scenes"].values())),
        "bounds_exceeded": sum(row["is_exceeded"] for row in made.get("bounds", ())),
    }


def _is_over(row: dict) -> bool:
    """Whether true errors are over the asked one, or over what runs state that ended before, beyond what chance may do."""
    error, doubt = race.true_error(row)
    allowed = race.ERROR
    if row.get("is_reckoned"):
        allowed = max(allowed, float(np.sqrt(np.mean(np.square(row["stated"])))))
    return error - SURE * doubt > allowed


def check_bars(result: dict) -> list[Bar]:
    """Judge by the demands."""
    begun = result.get("starts") or {}
    over, exceeded = result["over_asked"], result["bounds_exceeded"]
    has_scenes, has_bounds = bool(result["scenes"]), bool(result.get("count"))
    return [
        _ratio_bar(
            "everything in full over what is needed, geometric mean of times",
            LEAST_SPEEDUP,
            result["speedup"],
        ),
        _ratio_bar("the same in the worst scene", LEAST_SLOWEST, result["slowest"]),
        Bar(
            "scenes whose true error is over the asked one",
            "none",
            f"{over}" if has_scenes else "",
            over == 0 if has_scenes else None,
        ),
        Bar(
            "simplifications over their bounds in random scenes",
            "none",
            f"{exceeded}" if has_bounds else "",
            exceeded == 0 if has_bounds else None,
        ),
        _time_bar("import lumenray", MOST_IMPORT, begun.get("import_seconds")),
        _time_bar("explain of the office", MOST_EXPLAIN, begun.get("explain_seconds")),
        _time_bar(
            "enabling in a real Blender, of the processor",
            MOST_ENABLING,
            begun.get("enabling_seconds"),
        ),
    ]


def _ratio_bar(demand: str, limit: float, value: float | None) -> Bar:
    measured = "" if value is None else f"x {value:.2f}"
    return Bar(demand, f"at least x {limit:g}", measured, None if value is None else value >= limit)


def _time_bar(demand: str, limit: float, value: float | None) -> Bar:
    measured = "" if value is None else f"{value:.3g} s"
    return Bar(demand, f"at most {limit:g} s", measured, None if value is None else value <= limit)


def read_results(path: Path) -> dict:
    """Read the numbers of an earlier run."""
    return read_numbers(path, {"scenes"})


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document to a folder, and all numbers to a JSON file if one is named."""
    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    machine = result["machine"]
    text = TEXT.format(
        error=100.0 * race.ERROR,
        longest=race.LONGEST,
        own=race.OWN_LONGEST,
        few=race.FEW_SEEDS,
        seeds=result["seeds"],
        cpu=machine["cpu"],
        cores=machine["cores"],
    )
    text += f"{_tell_race(result)}\n{_tell_decisions(result)}\n"
    if result.get("count"):
        text += bounds.tell(result["bounds"], result["count"])
    if result.get("starts"):
        text += starts.tell(result["starts"])
    with write_whole(folder / "requirements.md", "utf-8") as file:
        file.write(text + tell_demands(check_bars(result)))


def _tell_race(result: dict) -> str:
    rows = []
    for row in result["scenes"].values():
        error, doubt = race.true_error(row)
        own, full = ("\\*" if row.get(key) else "" for key in ("is_reckoned", "is_full_reckoned"))
        bound = "at most " if race.is_hidden(row) else ""
        rows.append(
            f"| {row['title']} | {_tell(row['seconds'])}{own} | {_tell(row['full_seconds'])}{full} | "
            f"x {row['full_seconds'] / row['seconds']:.3g} | {bound}{100.0 * error:.2f} ± {100.0 * doubt:.2f} | "
            f"{100.0 * max(row['stated']):.2f} |"
        )
    head = "| scene | what is needed [s] | in full [s] | ratio | true error [%] | stated, at most [%] |"
    told = f"## Time to {100.0 * race.ERROR:g} %\n\n{make_table(head, rows)}"
    ratios = sorted(row["full_seconds"] / row["seconds"] for row in result["scenes"].values())
    if len(ratios) > FEW:
        mean, rest = geometric_mean(ratios), geometric_mean(ratios[:-FEW])
        told += (
            f"\nGeometric mean x {mean:.3g}; median x {median(ratios):.3g}; "
            f"geometric mean without the {FEW} scenes that gain most x {rest:.3g}.\n"
        )
    return told


def _tell(seconds: float) -> str:
    return f"{seconds:.2f}" if seconds < 10.0 else f"{seconds:.3g}"


def _tell_decisions(result: dict) -> str:
    told = "".join(
        f"- **{row['title']}**: {'; '.join(row['decisions'])}.\n"
        for row in result["scenes"].values()
    )
    return f"## What was decided\n\n{told}"
