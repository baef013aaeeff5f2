"""Runs cases on instruments, judges what they find, and checks that seeds behave."""

import logging
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace

from lumenray.benchmarks.common.machine import describe_machine
from lumenray.engine import VERSION

from .bench import Bench, CannotStateError, Engine, Finding, Instrument, Setup
from .cases import Case, all_cases
from .determinism import LEAST_VALUES, SeedCheck, check_seeds, choose_group, count_random
from .reference import Group, load_groups
from .verdict import Verdict, judge

log = logging.getLogger(__name__)

QUICK_CHECKS = 2
"""Cases whose seeds are checked in the quick subset."""


@dataclass
class Answer:
    """What one instrument made of the groups of a run; each is in ``findings`` or in ``missing``.

    Parameters
    ----------
    instrument : str    Its name.
    findings, verdicts : dict    By group id, in the order of the cases.
    missing : dict of str    Why there is nothing, by group id.
    seconds : float
    """

    instrument: str
    findings: dict[str, Finding] = field(default_factory=dict)
    verdicts: dict[str, Verdict] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    seconds: float = 0.0


@dataclass(frozen=True)
class Run:
    """A run of the suite.

    Parameters
    ----------
    cases : dict of Case    That were run, by id.
    groups : dict of Group    That were asked for, by id, with their own tolerances.
    engine : Answer    Ours.
    peers : dict of Answer    Other programs', by name.
    setups : dict of Setup    By case id, for drawing.
    determinism : tuple of SeedCheck    Of our engine.
    machine : dict    As `describe_machine` gives it.
    version : str    Of the engine.
    seed : int
    error : float or None    Relative standard error that was asked for beyond what the tolerances need. [-]
    is_quick : bool
    seconds : float    All together.
    """

    cases: dict[str, Case]
    groups: dict[str, Group]
    engine: Answer
    peers: dict[str, Answer]
    setups: dict[str, Setup]
    determinism: tuple[SeedCheck, ...]
    machine: dict
    version: str
    seed: int
    error: float | None
    is_quick: bool
    seconds: float

    @property
    def failed(self) -> tuple[str, ...]:
        """Ids of the scored groups that our engine fails, or has no values for."""
        return failed_groups(self.groups, self.engine)


def failed_groups(groups: dict[str, Group], answer: Answer) -> tuple[str, ...]:
    """Ids of the scored groups that an instrument fails, or has no values for."""
    return tuple(
        key
        for key, group in groups.items()
        if not group.is_informative and (key in answer.missing or not answer.verdicts[key].passes)
    )


def choose_cases(wanted: Iterable[str] = (), is_quick: bool = False) -> dict[str, Case]:
    """Cases by id.

    Parameters
    ----------
    wanted : iterable of str    Families and ids of cases; none: all.
    is_quick : bool    Only cases that have groups in the quick subset.

    Raises
    ------
    KeyError    There is no such family or case; carries its name.
    """
    cases = all_cases()
    wanted = tuple(wanted)
    for name in wanted:
        if name not in cases and all(case.family != name for case in cases.values()):
            raise KeyError(name)
    return {
        key: case
        for key, case in cases.items()
        if (not wanted or key in wanted or case.family in wanted) and (case.quick or not is_quick)
    }


def families() -> tuple[str, ...]:
    """Names of the families, in the order of the cases."""
    return tuple(dict.fromkeys(case.family for case in all_cases().values()))


def choose_groups(cases: dict[str, Case], is_quick: bool = False) -> dict[str, Group]:
    """Groups of cases by id; with ``is_quick`` those of the quick subset."""
    return {
        key: group
        for key, group in load_groups().items()
        if group.case in cases and (not is_quick or key in cases[group.case].quick)
    }


def run(
    cases: dict[str, Case],
    *,
    is_quick: bool = False,
    peers: Iterable[Callable[[], Instrument]] = (),
    seed: int = 1,
    error: float | None = None,
    say: Callable[[str], None] | None = None,
) -> Run:
    """Run cases on the engine, and on peers.

    Parameters
    ----------
    cases : dict of Case    As `choose_cases` gives them.
    is_quick : bool    Whether only their quick groups are run.
    peers : iterable of callable    Make the other instruments.
    seed : int
    error : float or None    Relative standard error to reach where the tolerances need less. [-]
    say : callable or None    Told in one line what was done.
    """
    say = say or (lambda line: None)
    start = time.perf_counter()
    groups = choose_groups(cases, is_quick)
    bench = Bench(Engine(), frozenset(groups), seed, error=error)
    engine = answer(bench, cases, groups, say)
    checks = _check_seeds(engine, bench, cases, is_quick, say)
    others = {}
    for make in peers:
        found = _answer_of_peer(make, bench, cases, groups, say)
        others[found.instrument] = found
    return Run(
        cases=cases,
        groups=groups,
        engine=engine,
        peers=others,
        setups=bench.setups,
        determinism=checks,
        machine=describe_machine(),
        version=VERSION,
        seed=seed,
        error=error,
        is_quick=is_quick,
        seconds=time.perf_counter() - start,
    )


def run_case(case: Case, bench: Bench) -> Iterator[Finding]:
    """Findings of a case, with the groups' own tolerances and the time that each took.

    Raises
    ------
    CannotStateError    The instrument has no means for the rest of the case.
    ValueError    The case gives what was not asked for, or of another size.
    """
    wanted = bench.groups(case.id)
    start = time.perf_counter()
    for found in case.run(bench):
        key = found.group.id
        if key not in wanted:
            raise ValueError(f"{case.id} gives {key}, which was not asked for or was there already")
        del wanted[key]
        if not found.values.shape == found.errors.shape == found.group.values.shape:
            raise ValueError(
                f"{key} has {found.values.shape} values and {found.errors.shape} errors, "
                f"expected {found.group.values.shape}"
            )
        # The bench may have asked for more than the tolerance needs; judged is by the tolerance.
        now = time.perf_counter()
        yield replace(found, group=load_groups()[key], seconds=now - start)
        start = time.perf_counter()


def answer(
    bench: Bench, cases: dict[str, Case], groups: dict[str, Group], say: Callable[[str], None]
) -> Answer:
    """Ask an instrument for all groups of cases. A case that breaks off is told, and the next one goes on."""
    made = Answer(bench.instrument.name)
    begin = time.perf_counter()
    for case in cases.values():
        reason = "the case gives no values for it"
        try:
            for found in run_case(case, bench):
                key = found.group.id
                made.findings[key] = found
                made.verdicts[key] = judge(found)
                say(_progress(made.instrument, made.verdicts[key], found.seconds))
        except CannotStateError as error:
            reason = f"{made.instrument} cannot be asked: {error}"
        except Exception as error:
            # One broken case must not cost the hours of the others; its groups count as failed.
            log.exception("%s broke off", case.id)
            reason = f"broke off with {type(error).__name__}: {error}"
        left = [k for k, g in groups.items() if g.case == case.id and k not in made.findings]
        made.missing |= dict.fromkeys(left, reason)
        if left:
            say(f"{made.instrument} {case.id}: {len(left)} groups without values: {reason}")
    made.seconds = time.perf_counter() - begin
    return made


def peer_makers() -> tuple[Callable[[], Instrument], ...]:
    """Makers of the other programs."""
    from .peers.cycles import Cycles
    from .peers.radiance import Radiance

    return Radiance, Cycles


def _answer_of_peer(make, bench, cases, groups, say) -> Answer:
    try:
        peer = make()
    except (CannotStateError, ImportError) as error:
        reason = f"{make.__name__} is not there: {error}"
        say(reason)
        return Answer(make.__name__, missing=dict.fromkeys(groups, reason))
    return answer(Bench(peer, bench.wanted, bench.seed, error=bench.error), cases, groups, say)


def _check_seeds(engine: Answer, bench: Bench, cases, is_quick: bool, say) -> tuple:
    """Check one random group of every case, or of the cheapest two."""
    chosen = [
        (case, found)
        for case in cases.values()
        if (found := choose_group(engine.findings.values(), case.id)) is not None
    ]
    if is_quick:
        enough = [pair for pair in chosen if count_random(pair[1]) >= LEAST_VALUES]
        chosen = sorted(enough, key=lambda pair: pair[1].seconds)[:QUICK_CHECKS]
    checks = []
    for case, found in chosen:
        checks.append(_check(case, found, bench))
        say(f"seeds {checks[-1].sentence}")
    return tuple(checks)


def _check(case: Case, found: Finding, bench: Bench) -> SeedCheck:
    key = found.group.id

    def measure(seed: int) -> Finding:
        alone = Bench(bench.instrument, frozenset({key}), seed, error=bench.error)
        return next(run_case(case, alone))

    try:
        return check_seeds(found, measure, bench.seed)
    except Exception as error:
        # As in `answer`: told, counted as failed, and the run goes on.
        log.exception("%s could not be repeated", key)
        return SeedCheck(key, False, None, 0, f"{type(error).__name__}: {error}")


def _progress(name: str, verdict: Verdict, seconds: float) -> str:
    word = ("passes" if verdict.passes else "FAILS") if verdict.is_scored else "informative"
    line = (
        f"{name} {verdict.group.id:<24} {100.0 * verdict.largest:7.3f} % "
        f"{verdict.used:6.2f} of tolerance {seconds:7.1f} s  {word}"
    )
    return "\n    ".join([line, *(verdict.faults if verdict.is_scored else ())])
