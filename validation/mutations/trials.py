"""Groups of the quick subset run against a fault, each fault in a process of its own.

What the engine keeps (kernels, registered plug-ins, integrals) would carry a fault on.
"""

import multiprocessing
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field

from ..bench import Bench, Engine
from ..cases import all_cases
from ..reference import load_groups
from ..runner import run_case
from ..verdict import judge
from .faults import Mutation

PATIENCE = 120.0
"""Longest time for one group: a fault may leave so much noise that no number of samples is enough. [s]"""


class BrokenOffError(Exception):
    """Groups could not be run to their end; the text says why."""


@dataclass(frozen=True)
class Trial:
    """What one group said.

    Parameters
    ----------
    group : str    Its id.
    passes : bool
    used : float    Largest part of its tolerance that a value's error takes. [-]
    seconds : float
    """

    group: str
    passes: bool
    used: float
    seconds: float


@dataclass
class Outcome:
    """What became of a mutation.

    Parameters
    ----------
    mutation : Mutation
    found_by : list of Trial    Groups that pass without the fault and fail with it.
    asked : int    Groups that were run.
    seconds : float
    fault : str    Why it could not be tried; empty: it could.
    """

    mutation: Mutation
    found_by: list[Trial] = field(default_factory=list)
    asked: int = 0
    seconds: float = 0.0
    fault: str = ""

    @property
    def is_caught(self) -> bool:
        """Whether a group has found it."""
        return bool(self.found_by)

    @property
    def worst(self) -> float:
        """Largest error in multiples of the tolerance; 0 if nothing was found."""
        return max((trial.used for trial in self.found_by), default=0.0)


def quick_groups() -> tuple[str, ...]:
    """Ids of the scored groups of the quick subset."""
    groups = load_groups()
    return tuple(
        key for case in all_cases().values() for key in case.quick if not groups[key].is_informative
    )


def examine(mutation: Mutation | None, groups: Iterable[str]) -> Iterator[Trial]:
    """Run groups in their order, in this process, with a fault or without any."""
    with ExitStack() as stack:
        if mutation is not None:
            stack.enter_context(mutation.injected())
        engine = Engine()
        for key in groups:
            case = all_cases()[load_groups()[key].case]
            for found in run_case(case, Bench(engine, frozenset({key}))):
                verdict = judge(found)
                yield Trial(key, verdict.passes, verdict.used, found.seconds)


def examine_apart(
    mutation: Mutation | None, groups: Sequence[str], stops: bool = False
) -> list[Trial]:
    """As `examine`, in a process of its own.

    Parameters
    ----------
    stops : bool    Whether to end at the first group that fails.

    Raises
    ------
    BrokenOffError    The process ended early, or a group took longer than `PATIENCE`.
    """
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(
        target=_send_trials, args=(theirs, mutation, tuple(groups)), daemon=True
    )
    process.start()
    theirs.close()
    trials: list[Trial] = []
    try:
        while len(trials) < len(groups):
            if not ours.poll(PATIENCE):
                raise BrokenOffError(f"{groups[len(trials)]} takes longer than {PATIENCE:.0f} s")
            message = ours.recv()
            if isinstance(message, str):
                raise BrokenOffError(f"{groups[len(trials)]}: {message}")
            trials.append(message)
            if stops and not message.passes:
                break
    except EOFError:
        raise BrokenOffError(f"the process ended in {groups[len(trials)]}") from None
    finally:
        process.kill()
        process.join()
        ours.close()
    return trials


def _send_trials(connection, mutation: Mutation | None, groups: Sequence[str]) -> None:
    """Send trials, and what broke them off."""
    from lumenray.engine.transport import backend

    # Putting a fault in loads modules that load Dr.Jit, which looks for LLVM then.
    backend.start(spectral=False)
    try:
        for trial in examine(mutation, groups):
            connection.send(trial)
    except Exception as error:
        connection.send(f"{type(error).__name__}: {error}")


class Baseline:
    """Which groups pass without a fault; each is run once, when it is asked for."""

    def __init__(self):
        self._passes: dict[str, bool] = {}

    def failing(self, groups: Iterable[str]) -> list[str]:
        """Those of the groups that fail although nothing is wrong."""
        groups = tuple(dict.fromkeys(groups))
        if new := [key for key in groups if key not in self._passes]:
            self._passes |= {t.group: t.passes for t in examine_apart(None, new)}
        return [key for key in groups if not self._passes[key]]


def run(
    mutations: Sequence[Mutation], everything: bool, say: Callable[[str], None]
) -> list[Outcome]:
    """Try mutations one by one.

    Parameters
    ----------
    everything : bool    Whether all groups of the quick subset are run for each, not only until one fails.
    say : callable    Told in one line what was done.

    Raises
    ------
    BrokenOffError    A group that a mutation is likely to be found by fails without it, or could not be run.
    ValueError    It is not in the quick subset.
    """
    quick = quick_groups()
    likely = dict.fromkeys(key for mutation in mutations for key in mutation.likely)
    if strange := [key for key in likely if key not in quick]:
        raise ValueError(f"not in the quick subset: {', '.join(strange)}")
    baseline = Baseline()
    if failing := baseline.failing(quick if everything else likely):
        raise BrokenOffError(f"without a fault these fail already: {', '.join(failing)}")
    say(f"without a fault {len(quick if everything else likely)} groups pass")
    outcomes = []
    for mutation in mutations:
        outcomes.append(_try(mutation, quick, everything, baseline))
        say(_progress(outcomes[-1]))
    return outcomes


def _try(mutation: Mutation, quick: Sequence[str], everything: bool, baseline: Baseline) -> Outcome:
    start = time.perf_counter()
    made = Outcome(mutation)
    left = list(dict.fromkeys([*mutation.likely, *quick]))
    try:
        while left and (everything or not made.is_caught):
            trials = examine_apart(mutation, left, not everything)
            del left[: len(trials)]
            made.asked += len(trials)
            failed = [trial for trial in trials if not trial.passes]
            wrong = baseline.failing(trial.group for trial in failed)
            made.found_by += [trial for trial in failed if trial.group not in wrong]
    except BrokenOffError as error:
        # A fault that breaks the program off is none of physics; it is told, and the others are tried.
        made.fault = str(error)
    made.seconds = time.perf_counter() - start
    return made


def _progress(outcome: Outcome) -> str:
    head = f"{outcome.mutation.name:<26} {outcome.seconds:6.1f} s  "
    if outcome.fault:
        return f"{head}BROKE OFF: {outcome.fault}"
    if not outcome.is_caught:
        return f"{head}SURVIVES {outcome.asked} groups"
    found = ", ".join(trial.group for trial in outcome.found_by)
    return f"{head}caught by {found}: {multiple(outcome.worst)} of tolerance"


def multiple(used: float) -> str:
    """Multiple of a tolerance with three digits."""
    return f"{used:.3g}" if used < 1000.0 else f"{used:.0f}"
