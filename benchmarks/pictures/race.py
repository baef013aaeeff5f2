"""Error over time of all programs in a scene, in turn, so that what slows the machine down meets all alike."""

from dataclasses import dataclass, field

import numpy as np

from ..common.statistics import Reach
from .programs import Made, Program
from .statistics import COARSEST, TARGETS, Reference, error_of_pair, seconds_to

GROWTH = 2
"""Samples of a run over those of the run before."""

TRIES = 2
"""Pictures of every run, of other seeds: the fastest counts, since what else a machine does only adds to a time, and the
error of all."""

BELIEVED = 8
"""Samples per pixel from which stated errors are judged, as pictures do not stop by those of fewer."""

FINER = 8
"""Samples of a picture of the reference over those of the longest run at most, where there is time left for them."""

ENOUGH = 0.7 * min(TARGETS)
"""Error below which no finer run is made. [-]"""

FIRST_SEED, REFERENCE_SEED = 1_000, 900_000


@dataclass(eq=False)
class Runner:
    """A program on its way.

    Parameters
    ----------
    program : Program
    budget : float    Time that its pictures may take, those of the reference included. [s]
    """

    program: Program
    budget: float
    runs: list[tuple[int, list[Made]]] = field(default_factory=list)
    spent: float = 0.0

    @property
    def next_samples(self) -> int:
        """Of the next run."""
        return self.runs[-1][0] * GROWTH if self.runs else self.program.least

    @property
    def may_go_on(self) -> bool:
        """Whether a finer run, and a reference of as much work, fit into the budget."""
        if len(self.runs) < 2:
            return True
        before, last = (min(made.seconds for made in run) for _, run in self.runs[-2:])
        # What is learned once is paid once.
        expected = min(max(last + GROWTH * (last - before), last), GROWTH * last)
        if self.spent + 2 * TRIES * expected > self.budget:
            return False
        return self.pair_error > ENOUGH

    @property
    def pair_error(self) -> float:
        """Error of the last run, by its own pictures alone. [-]"""
        first, second = (made.luminance for made in self.runs[-1][1][:2])
        return error_of_pair(first, second)

    def climb(self) -> None:
        """Make the next run."""
        samples = self.next_samples
        made = [
            self.program.render(samples, FIRST_SEED * (len(self.runs) + 1) + number)
            for number in range(TRIES)
        ]
        self.spent += sum(each.seconds for each in made)
        self.runs.append((samples, made))

    def find_reference(self) -> Reference:
        """Make two pictures of other seeds, which count together, with at least as many samples as the last run."""
        samples, last = self.runs[-1]
        seconds = min(made.seconds for made in last)
        finer = FINER
        while finer > 1 and self.spent + 2 * finer * seconds > self.budget:
            finer //= GROWTH
        samples *= finer
        halves = [self.program.refer(samples, REFERENCE_SEED + number) for number in range(2)]
        return Reference(*(made.luminance for made in halves))


def race(programs: list[Program], budget: float, say) -> tuple[dict, dict[str, list]]:
    """Let programs race.

    Returns
    -------
    rows : dict    By name of the program: ``samples``, ``seconds``, ``errors``: by run; ``stated``: by run, None where the
        program states none; ``reference_error`` [-]; ``mean``: luminance, and ``mean_error`` [cd/m2].
    pictures : dict of str to list of `Made`    One of each run.
    """
    runners = [Runner(program, budget) for program in programs]
    for program in programs:
        # Kernels are made now, those of cells by the second picture, and nothing counts.
        for samples in (program.least, GROWTH * program.least):
            program.render(samples, 1)
    while any(runner.may_go_on for runner in runners):
        for runner in runners:
            if runner.may_go_on:
                runner.climb()
                samples, made = runner.runs[-1]
                seconds = min(each.seconds for each in made)
                say(
                    f"{runner.program.name}: {samples} samples, about {100 * runner.pair_error:.1f} % in {seconds:.2f} s"
                )
    rows = {runner.program.name: _row(runner) for runner in runners}
    pictures = {runner.program.name: [made[0] for _, made in runner.runs] for runner in runners}
    return rows, pictures


def _row(runner: Runner) -> dict:
    reference = runner.find_reference()
    variances = [
        [reference.variance_of(each.luminance) for each in made] for _, made in runner.runs
    ]
    # Of what is below the reference's own noise nothing better is known.
    errors = [float(np.sqrt(max(np.mean(each), 0.01 * reference.variance))) for each in variances]
    stated = [
        None
        if made[0].stated is None
        else float(np.sqrt(np.mean([each.stated**2 for each in made])))
        for _, made in runner.runs
    ]
    halves = [float(half.mean()) for half in (reference.first, reference.second)]
    return {
        "samples": [samples for samples, _ in runner.runs],
        "seconds": [min(each.seconds for each in made) for _, made in runner.runs],
        "errors": errors,
        "stated": stated,
        "reference_error": float(np.sqrt(reference.variance)),
        "mean": float(np.mean(halves)),
        # Pixels are independent of each other.
        "mean_error": float(
            0.5
            * np.sqrt(((reference.first - reference.second).astype(np.float64) ** 2).sum())
            / reference.first.size
        ),
    }


def reach(row: dict | None, target: float) -> Reach | None:
    """Time of a program to an error; None where it did not run."""
    if row is None or "refusal" in row:
        return None
    return seconds_to(row["samples"], row["seconds"], row["errors"], target)


def calibration_of(row: dict) -> list[float]:
    """Stated over true errors of the runs that somebody would use. [-]"""
    rows = zip(row["samples"], row["stated"], row["errors"], strict=True)
    return [
        stated / true
        for samples, stated, true in rows
        if stated is not None and samples >= BELIEVED and true <= COARSEST
    ]


def pair_at_equal_time(pictures: dict[str, list[Made]], names: tuple[str, str]) -> list[Made]:
    """The pictures of two programs whose times are nearest to the longest that both have."""
    made = [pictures[name] for name in names]
    time = min(each[-1].seconds for each in made)
    return [min(each, key=lambda one: abs(np.log(one.seconds / time))) for each in made]
