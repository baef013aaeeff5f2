"""Kernels that pictures of the office need, with an empty cache and with what a process before has left in it."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from ...engine.errors import LumenrayError
from ...engine.reading.whole_file import write_whole
from ..common.bars import Bar
from ..common.document import make_table, tell_demands
from ..common.machine import describe_machine
from ..common.output import write_numbers
from .trials import TRIALS

SIZE, SAMPLES = (160, 100), 4
"""Width and height of the pictures [pixel], and samples of each."""

PATIENCE = 1800.0
"""Longest that one process may take. [s]"""

MOST_SECONDS = 2.0
"""Longest that building the kernels of the first picture may take. [s]"""

EDITS = ("a panel dimmed", "a bulb moved", "the walls painted")

TRIED = """## What was tried

Full paths with kernels that are there, each trial in a process of its own, the fastest of three pictures. *All*: processor
time; *beside*: share of the time that passes outside of kernels, which is all that replaying frozen launches could save;
*functions*: of the largest kernel, among them every code shape that a packet may have to go through one after the other.

"""

SORTED = """Rays that the first surfaces have scattered, followed to their ends in one launch: as they come, sorted by what
they meet next, as kernels that sort between bounces would have them, and in no order at all. Sorting itself takes
{sorting:.3f} s more, once for every bounce.

"""

TEXT = """# Kernels

*Made by `lumenray benchmark kernels`; do not edit by hand.*

Dr.Jit writes what a picture does as a few large kernels, which LLVM compiles when they are met first; from then on they lie
in a cache on disk. Pictures of the bundled office, {width} x {height} pixels, {samples} samples, one after the other in one
process: with an empty cache, and in a new process with what the first has left. *Kernels*: those that were in no cache;
*building*: time that LLVM took for them, on one processor; *all*: processor time of the step; *lines*, *functions*: of the
largest kernel that was built. {cpu}, {cores} cores.

"""


def run(size=SIZE, samples: int = SAMPLES, say=None) -> dict:
    """Measure.

    Returns
    -------
    dict    Plain data for JSON: ``cold`` and ``warm``, each as of `builds.measure`; ``trials``: by name, as of
        `trials.measure`, or with ``refusal``.
    """
    say = say or (lambda line: None)
    made = {"machine": describe_machine(), "size": list(size), "samples": samples}
    with tempfile.TemporaryDirectory() as cache:
        for name in ("cold", "warm"):
            made[name] = _measure(cache, "builds", *size, samples)
            total = sum(step["built"] for step in made[name].values())
            say(f"kernels: {name}, {total} built")
        made["trials"] = {}
        for name in TRIALS:
            made["trials"][name] = told = _measure(cache, "trials", name, *size, samples)
            say(f"kernels: {name}, {told.get('refusal') or format(told['seconds'], '.2f') + ' s'}")
    return made


def _measure(cache: str, module: str, *words) -> dict:
    command = [sys.executable, "-m", f"{__package__}.{module}", *map(str, words)]
    environment = {**os.environ, "DRJIT_CACHE_DIR": cache}
    try:
        told = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=PATIENCE, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise LumenrayError(f"the pictures could not be made ({error})") from None
    if told.returncode:
        said = told.stderr.strip().splitlines() or ["no message"]
        raise LumenrayError(f"the pictures could not be made ({said[-1]})")
    return json.loads(told.stdout.strip().splitlines()[-1])


def _tell_trials(trials: dict) -> str:
    """Sections of what was tried."""
    usual, rows = trials["as it is"], []
    for name, told in trials.items():
        if "refusal" in told:
            rows.append(f"| {name} | {told['refusal']} | | | | | |")
            continue
        rows.append(
            f"| {name} | {told['lanes']} | {told['functions']} | {told['build_seconds']:.1f} s | {told['seconds']:.2f} s | "
            f"{told['seconds'] / usual['seconds']:.2f} | {100.0 * told['beside']:.0f} % |"
        )
    head = "| trial | lanes | functions | building | all | relative | beside |"
    text = f"{TRIED}{make_table(head, rows)}\n"
    if "orders" in usual:
        first = next(iter(usual["orders"].values()))
        rows = [
            f"| {name} | {seconds:.2f} s | {seconds / first:.2f} |"
            for name, seconds in usual["orders"].items()
        ]
        table = make_table("| order | all | relative |", rows)
        text += f"{SORTED.format(sorting=usual['sorting'])}{table}\n"
    return text


def check_bars(result: dict) -> list[Bar]:
    """Judge by the demands."""
    cold, warm = result["cold"], result["warm"]
    first = sum(step["build_seconds"] for name, step in cold.items() if name not in EDITS)
    edits = sum(cold[name]["built"] for name in EDITS)
    again = sum(step["built"] for step in warm.values())
    return [
        Bar(
            "building for the first pictures",
            f"{MOST_SECONDS:g} s",
            f"{first:.1f} s",
            first <= MOST_SECONDS,
        ),
        Bar("kernels built for edits", "none", str(edits), edits == 0),
        Bar("kernels built by the next process", "none", str(again), again == 0),
    ]


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document to a folder, and all numbers to a JSON file if one is named."""
    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    machine = result["machine"]
    text = TEXT.format(
        width=result["size"][0],
        height=result["size"][1],
        samples=result["samples"],
        cpu=machine["cpu"],
        cores=machine["cores"],
    )
    for name, title in (("cold", "With an empty cache"), ("warm", "In the next process")):
        rows = [
            f"| {step} | {told['built']} | {told['build_seconds']:.1f} s | {told['seconds']:.1f} s | "
            f"{told['largest']} | {told['functions']} |"
            for step, told in result[name].items()
        ]
        head = "| step | kernels | building | all | lines | functions |"
        text += f"## {title}\n\n{make_table(head, rows)}\n"
    text += _tell_trials(result["trials"])
    text += tell_demands(check_bars(result))
    with write_whole(folder / "kernels.md", "utf-8") as file:
        file.write(text)
