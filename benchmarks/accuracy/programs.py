"""Runs of Lumenray and of other programs: more and more work on a scene, the error and the time of each run."""

import time
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...validation.bench import CannotStateError, Engine, Instrument, Query
from .scenes import ExactScene

OURS = ("Lumenray mono", "Lumenray spectral")
"""Our ways of computing; ratios refer to the first."""

PEERS = ("Radiance", "Cycles")

GROWTH = 4
"""Work of a run over that of the run before."""

FEWEST_AMOUNTS = 3
"""Amounts of work of a program that are measured however slow the machine is: a slope takes so many."""

LEAST_SAMPLES, MOST_SAMPLES = 16, 1 << 26
"""Per sensor; the least is one for each of the groups whose spread is the stated error."""

LEAST_RAYS, MOST_RAYS = 1 << 10, 1 << 27
"""Of a run of another program, all sensors together."""

STRETCH = 1.1
"""Work of Radiance in a round over that in the round before: it takes no seed, but other numbers of rays are others."""

FIRST_SEED = 101
"""Those of the rounds count on from it; the run before the rounds has one of its own."""


@dataclass(frozen=True)
class Made:
    """Result of a run: illuminances, their stated standard errors, and the time it took."""

    values: np.ndarray
    stated: np.ndarray
    seconds: float


class Program(Protocol):
    """What is measured.

    Parameters
    ----------
    name : str
    unit : str    What its work is counted in.
    least, most : int    Work.
    is_ours : bool
    """

    name: str
    unit: str
    least: int
    most: int
    is_ours: bool

    def run(self, scene: ExactScene, work: int, number: int) -> Made:
        """Do so much work; ``number`` -1 and up chooses other random numbers. Raises `CannotStateError`."""


class Lumenray:
    """Our engine with one kind of transport, in this process, with its scene kept from run to run."""

    unit, is_ours = "samples per sensor", True
    least, most = LEAST_SAMPLES, MOST_SAMPLES

    def __init__(self, transport: str):
        self.name, self.transport = f"Lumenray {transport}", transport
        self.engine = Engine()

    def run(self, scene: ExactScene, work: int, number: int, progress=None, error=None) -> Made:
        """Measure with so many samples, or to a relative standard error."""
        rule = StopRule(samples=work) if error is None else StopRule(error=error)
        start = time.perf_counter()
        made = self.engine.stage(scene.items).measure(
            scene.positions,
            scene.normals,
            rule,
            seed=FIRST_SEED + number,
            transport=self.transport,
            progress=progress,
        )
        seconds = time.perf_counter() - start
        return Made(made.illuminance, made.standard_error, seconds)


class Peer:
    """Another program as the validation suite runs it; ``setting``: its attribute that says how much work is done."""

    least, most, is_ours = LEAST_RAYS, MOST_RAYS, False

    def __init__(self, instrument: Instrument, setting: str):
        self.name, self.unit = instrument.name, setting
        self.instrument, self._setting = instrument, setting

    def run(self, scene: ExactScene, work: int, number: int) -> Made:
        stretch = STRETCH**number if self.unit == "rays" and number >= 0 else 1.0
        setattr(self.instrument, self._setting, round(work * stretch))
        query = Query(scene.positions, scene.normals, np.ones(len(scene.exact)))
        start = time.perf_counter()
        made = self.instrument.measure(scene.items, query, FIRST_SEED + number)
        return Made(made.values, made.errors, time.perf_counter() - start)

    def close(self) -> None:
        """End what the program leaves running."""
        if hasattr(self.instrument, "close"):
            self.instrument.close()


def find_peers(say) -> list[Peer]:
    """Return the other programs that are installed."""
    from ...validation.peers.cycles import Cycles
    from ...validation.peers.radiance import Radiance

    found = []
    for make, setting in ((Radiance, "rays"), (Cycles, "paths")):
        try:
            found.append(Peer(make(), setting))
        except CannotStateError as error:
            say(f"{make.__name__} is left out: {error}")
    return found


def measure_scene(
    scene: ExactScene, programs: list[Program], rounds: int, longest: float, say
) -> dict:
    """Measure a scene with all programs.

    Parameters
    ----------
    scene : ExactScene
    programs : list of Program
    rounds : int    Each has every program in turn, so that what slows the machine down meets all alike.
    longest : float    Runs that would compute longer are not made, but for the first few amounts. [s]
    say : callable

    Returns
    -------
    dict    By name of the program: ``unit``, ``is_ours``, ``work`` (k,), ``first_seconds``: of the very first run,
        ``seconds`` and ``errors`` (rounds, k): times, and root mean squares over the sensors of relative errors; or only
        ``refusal``: why there is nothing.
    """
    made: dict[str, dict] = {}
    for program in programs:
        try:
            work, first = _climb(scene, program, longest)
        except CannotStateError as error:
            made[program.name] = {"refusal": str(error)}
            say(f"{scene.key}: {program.name}: {error}")
            continue
        made[program.name] = {
            "unit": program.unit,
            "is_ours": program.is_ours,
            "work": work,
            "first_seconds": first,
            "seconds": [],
            "errors": [],
        }
    for number in range(rounds):
        for program in programs:
            row = made[program.name]
            if "refusal" in row:
                continue
            if program.is_ours:
                # The other kind of transport ran meanwhile, and Mitsuba has to change over.
                program.run(scene, program.least, number)
            runs = [program.run(scene, work, number) for work in row["work"]]
            row["seconds"].append([run.seconds for run in runs])
            row["errors"].append([_root_mean_square(run.values / scene.exact - 1) for run in runs])
        say(f"{scene.key}: round {number + 1} of {rounds}")
    return made


def _climb(scene: ExactScene, program: Program, longest: float) -> tuple[list[int], float]:
    """Find the amounts of work, and compile what each needs. Returns the time of the first run too."""
    work, kept, before, first = program.least, [], None, None
    while work <= program.most:
        run = program.run(scene, work, -1)
        if first is None:
            first = shortest = run.seconds
        if before is not None and np.array_equal(before, run.values):
            # So little work is below the program's own least: it did the same again.
            kept.pop()
        kept.append(work)
        before = run.values
        if GROWTH * (run.seconds - shortest) > longest:
            # What took long may have been a kernel that was compiled.
            run = program.run(scene, work, -1)
        shortest = min(shortest, run.seconds)
        if len(kept) >= FEWEST_AMOUNTS and GROWTH * (run.seconds - shortest) > longest:
            break
        work *= GROWTH
    return kept, first


def _root_mean_square(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
