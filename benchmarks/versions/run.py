"""Processor time and errors of the bundled office by this version and by another one, side by side in one run.

Both are asked by their command line, each in processes of its own, in turns. Every job is run with few and with many
samples, so that reading the file, building the scene and fetching kernels can be told from what samples take.
"""

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

from ...engine.errors import LumenrayError
from ...engine.reading.whole_file import write_whole
from ...libraries import scenes
from ..common.bars import Bar
from ..common.document import make_table, tell_demands
from ..common.machine import describe_machine
from ..common.output import write_numbers

JOBS = {"paths": "a picture by full paths", "cells": "a picture by cells"}
"""Methods of pictures, and words for them."""

SIZE = "160x100"
"""Width and height of the pictures. [pixel]"""

SAMPLES = (8, 72)
"""Few and many samples."""

ROUNDS = 3
"""Times that each is run; one more, which is not counted, compiles."""

PATIENCE = 900.0
"""Longest that one run may take. [s]"""

MOST = 1.15
"""Most that samples to the same error may take here, relative to the other version. [-]"""

CALL = "import sys; from lumenray.command_line.main import main; sys.exit(main())"

TEXT = """# Two versions side by side

*Made by `lumenray benchmark versions CHECKOUT`; do not edit by hand.*

The bundled office by this version and by {other}, asked by the command line, in turns. Seconds of the processor, all
of its cores added up: medians of {rounds} runs, after one that compiled. *Start* is what remains where no sample is
taken: Python, reading the file, building the scene, fetching kernels, finding light. *To the same error* is time of
samples times the square of the stated error, relative to the other version. {cpu}, {cores} cores.

"""


def run(checkout: Path, say=None) -> dict:
    """Measure.

    Parameters
    ----------
    checkout    Folder of the other version; its name is that of the package.

    Returns
    -------
    dict    Plain data, for JSON: ``runs`` by job, version ("here", "there") and samples, lists of seconds and errors.

    Raises
    ------
    LumenrayError    There is no such version in the folder, or one of both does not end well.
    """
    say = say or (lambda _line: None)
    folder = checkout.absolute()
    if folder.name != "lumenray" or not (folder / "command_line/main.py").is_file():
        raise LumenrayError(
            f"{folder} is no checkout of Lumenray: a folder 'lumenray' with command_line/main.py is expected"
        )
    versions = {"here": {}, "there": {"PYTHONPATH": str(folder.parent)}}
    runs = {}
    for job in JOBS:
        runs[job] = {version: {} for version in versions}
        for number in range(ROUNDS + 1):
            for samples in SAMPLES:
                for version, variables in versions.items():
                    seconds, error = _ask(variables, job, samples, number)
                    if number:
                        kept = runs[job][version].setdefault(str(samples), [])
                        kept.append({"seconds": seconds, "error": error})
                    say(f"{job}, {samples} samples, {version}: {seconds:.1f} s, error {error:.2%}")
    return {
        "machine": describe_machine(),
        "other": _describe(checkout),
        "runs": runs,
    }


def _ask(variables: dict, job: str, samples: int, seed: int) -> tuple[float, float]:
    """Run a job; returns seconds of the processor and the stated error of the whole."""
    with tempfile.TemporaryDirectory() as name:
        report = Path(name) / "out.json"
        command = [sys.executable, "-c", CALL, "render", str(scenes.scene_path("office"))]
        command += ["--size", SIZE, "--method", job, "--samples", str(samples)]
        command += ["--seed", str(seed), "-o", str(report.with_suffix(".exr"))]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        try:
            made = subprocess.run(
                command,
                capture_output=True,
                timeout=PATIENCE,
                check=False,
                cwd=name,
                env=os.environ | variables,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise LumenrayError(f"A version cannot be asked ({error})") from None
        if made.returncode:
            said = made.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
            raise LumenrayError(f"A version does not end well ({said[-1]})")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        told = json.loads(report.read_text("utf-8"))
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, find_error(told)


def find_error(report: dict) -> float:
    """Return the stated relative error of the first quantity of a report. [-]"""
    return float(report["quantities"][0]["relative_standard_error"])


def _describe(checkout: Path) -> str:
    """Name the other version by its commit."""
    git = shutil.which("git")
    if git is None:
        return "another version"
    made = subprocess.run(
        [
            git,
            "-C",
            str(checkout),
            "log",
            "-1",
            "--format=%h of %cd",
            "--date=format:%Y-%m-%d %H:%M",
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    return f"commit {made.stdout.strip()}" if made.returncode == 0 else "another version"


def split_time(runs: dict) -> tuple[float, float, float]:
    """Part the time of runs with few and many samples.

    Returns
    -------
    start, each, error    What is taken without samples [s], what a sample takes [s], and the stated error of one
                          sample, which falls with the root of their number. [-]
    """
    (few, a), (many, b) = sorted((int(key), value) for key, value in runs.items())
    low, high = (median(each["seconds"] for each in group) for group in (a, b))
    each = (high - low) / (many - few)
    error = median(one["error"] for one in b) * many**0.5
    return low - few * each, each, error


def compare(result: dict, job: str) -> dict:
    """Ratios of this version to the other one: start, a sample, samples to the same error. [-]"""
    here, there = (split_time(result["runs"][job][version]) for version in ("here", "there"))
    return {
        "start": here[0] / there[0],
        "sample": here[1] / there[1],
        "error": here[1] * here[2] ** 2 / (there[1] * there[2] ** 2),
    }


def check_bars(result: dict) -> list[Bar]:
    """Judge by the demand."""
    bars = []
    for job in result["runs"]:
        value = compare(result, job)["error"]
        demand = f"{JOBS[job]} to the same error, of the other version"
        bars.append(Bar(demand, f"{MOST:.0%}", f"{value:.0%}", value <= MOST))
    return bars


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document to a folder, and all numbers to a JSON file if one is named."""
    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    machine = result["machine"]
    text = TEXT.format(
        other=result["other"], rounds=ROUNDS, cpu=machine["cpu"], cores=machine["cores"]
    )
    rows = []
    for job, runs in result["runs"].items():
        here, there = (split_time(runs[version]) for version in ("here", "there"))
        shares = compare(result, job)
        rows.append(
            f"| {JOBS[job]} | {there[0]:.1f} s | {here[0]:.1f} s | {1e3 * there[1]:.0f} ms | {1e3 * here[1]:.0f} ms "
            f"| {there[2]:.1%} | {here[2]:.1%} | {shares['error']:.0%} |"
        )
    head = (
        "| | start, there | start, here | a sample, there | a sample, here "
        "| error of one sample, there | error of one sample, here | to the same error |"
    )
    text += make_table(head, rows, 1) + "\n"
    text += tell_demands(check_bars(result))
    with write_whole(folder / "versions.md", "utf-8") as file:
        file.write(text)
