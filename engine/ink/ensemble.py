"""Realisations of a layer in several processes, kept as they come, and how far their mean is off.

What is solved lies in a folder named by the hash of all that it follows from: the film's description without its substrate,
the plan without the number of realisations, and the version of the method. So a job that was ended goes on where it was, to
the same bits; more realisations add to those that there are; and what was solved once is not solved again.
"""

import hashlib
import io
import json
import math
import time
import zipfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ..reading.kept_folder import kept_folder
from ..reading.whole_file import write_whole
from .composition import Ink
from .crew import Task, run_tasks
from .plan import Plan

METHOD = 3
"""Version of what is solved; another one has a folder of its own."""

PROBED_BANDS = 3
"""Bands that are solved on a grid of twice the step too, in the first realisation."""


@dataclass(frozen=True)
class Progress:
    """How far a job is.

    Parameters
    ----------
    done, total : int    Units: one realisation in one band.
    seconds : float    So far.
    left : float    Forecast; infinite while nothing is known. [s]
    """

    done: int
    total: int
    seconds: float
    left: float


@dataclass(frozen=True, eq=False)
class Ensemble:
    """What realisations scatter.

    Parameters
    ----------
    units : dict of (int, int) to dict    By realisation and band, as of `realisation.solve_unit`.
    coarse : dict of int to dict    By band, the first realisation on the grid of twice the step.
    solved : int    Units that were solved now; the rest was there.
    """

    units: dict
    coarse: dict
    solved: int


def film_content(ink: Ink) -> dict:
    """What of a description changes the film: not its names, nor what it lies on."""
    names = {"name", "description", "source", "solution"}
    content = {name: value for name, value in ink.content.items() if name not in names}
    substrate = ink.content["substrate"]
    kept = {name: substrate[name] for name in ("contact_index",) if name in substrate}
    return content | {"name": "film", "substrate": {"reflectance": 0.0} | kept}


def key_of(ink: Ink, plan: Plan) -> str:
    """SHA-256 of all that a film's realisations follow from, in hexadecimal."""
    stated = asdict(plan)
    del stated["realisations"]
    text = json.dumps([METHOD, film_content(ink), stated], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def default_folder() -> Path:
    """Where solved films are kept for this user."""
    return kept_folder("ink")


def solve_ensemble(
    ink: Ink,
    plan: Plan,
    folder: Path | None = None,
    processes: int = 1,
    report: Callable[[Progress], None] = lambda progress: None,
    do_tasks: Callable = run_tasks,
) -> Ensemble:
    """Solve all realisations that are not there yet.

    Parameters
    ----------
    folder : Path or None    Where they are kept; None: `default_folder`.
    report : callable    Told after each, and while they last; what it raises ends the job, and what was solved stays.
    do_tasks : callable    Does them, as of `crew.run_tasks`.

    Raises
    ------
    SceneError, EngineLost    As of `crew.run_tasks`.
    FileFormatError    The folder cannot be written.
    """
    place = (folder or default_folder()) / key_of(ink, plan)
    tasks = _tasks(plan)
    held = {task: _load(place / _name(task)) for task in tasks}
    missing = [task for task in tasks if held[task] is None]
    start = time.monotonic()
    total, solved = len(tasks), 0

    def tell() -> None:
        rest, seconds = len(missing) - solved, time.monotonic() - start
        pace = seconds / solved if solved else math.inf
        report(Progress(total - rest, total, seconds, pace * rest if rest else 0.0))

    tell()
    if missing:
        order = {"content": film_content(ink), "plan": asdict(plan)}
        running = do_tasks(order, missing, processes)
        try:
            for result in running:
                if result is not None:
                    task, data = result
                    with write_whole(place / _name(task)) as file:
                        file.write(data)
                    held[task] = _parse(data)
                    solved += 1
                tell()
        finally:
            running.close()
    units = {task[:2]: held[task] for task in tasks if not task[2]}
    coarse = {task[1]: held[task] for task in tasks if task[2]}
    return Ensemble(units, coarse, solved)


def probed_bands(plan: Plan) -> list[int]:
    """Bands by which the error of the grid is told."""
    count = len(plan.wavelengths)
    return sorted({round(k) for k in np.linspace(0, count - 1, min(PROBED_BANDS, count))})


def _tasks(plan: Plan) -> list[Task]:
    """All units; those of one realisation together, as its particles are packed once."""
    bands = range(len(plan.wavelengths))
    tasks = [(k, band, False) for k in range(plan.realisations) for band in bands]
    if plan.columns > 2:
        tasks += [(0, band, True) for band in probed_bands(plan)]
    return tasks


def _name(task: Task) -> str:
    realisation, band, is_coarse = task
    return f"{realisation}_{band}{'_coarse' if is_coarse else ''}.npz"


def _load(path: Path):
    """What a file holds; None where there is none, or a damaged one, which is solved again."""
    try:
        return _parse(path.read_bytes())
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile):
        return None


def _parse(data: bytes) -> dict[str, np.ndarray]:
    with np.load(io.BytesIO(data), allow_pickle=False) as held:
        return {name: held[name] for name in held.files}
