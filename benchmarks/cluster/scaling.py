"""Jobs by up to a thousand workers, simulated with what was measured on a cluster of this machine."""

import itertools
from collections.abc import Callable
from dataclasses import asdict, replace

from ...engine.accuracy.stopping import StopRule
from ...engine.cluster.chunks import Chunk, Grain, cut
from ...engine.cluster.hosts import LocalCluster
from ..common.machine import OtherLoad
from .costs import JobCosts, measure_costs, measure_post, run_job
from .kinds import SEED, make_kinds
from .simulation import Line, SimulatedCrew, Tail, run_chunks

COUNTS = (10, 20, 50, 100, 200, 500, 1000)

HOURS = (1, 24)
"""Sizes of jobs: for how long one worker would compute. [h]"""

HALF, GOOD = 0.5, 0.8
"""Efficiencies up to which numbers of workers are told."""

LINE = Line(10e9, 1e-3)

SLOW_LINE = Line(1e9, 1e-3)

LARGE_SCENE = 500_000_000
"""Parcel of a scene of some ten million triangles. [byte]"""

TAIL = Tail(0.01)

FAST = 16.0
"""Workers of so many threads."""

SOME = 100
"""Workers in a study of what matters, beside the most there are."""


def measure_scaling(say: Callable[[str], None]) -> dict:
    """Measure what four kinds of job cost, and simulate them.

    Returns
    -------
    dict    ``others`` (share of the processors that others had while it was measured), ``post``, ``costs`` by kind,
        ``checks`` of the simulation, ``curves``, ``levers``; plain data.
    """
    kinds = make_kinds()
    costs, checks, load = {}, [], OtherLoad()
    with LocalCluster(1, threads=1) as cluster:
        post = measure_post(cluster)
        say(f"an errand without work takes {1e3 * post.round_trip:.1f} ms")
        one = {}
        for kind in kinds:
            costs[kind.name], one[kind.name] = measure_costs(cluster, kind, post)
            say(f"{kind.name}: one worker, {one[kind.name]:.1f} s")
        cluster.add_worker()
        for kind in kinds:
            samples = kind.length * kind.grain.least
            # Workers that come anew make kernels.
            run_job(cluster, kind, 2 * kind.grain.least)
            _, two, _ = run_job(cluster, kind, samples)
            own = costs[kind.name]
            for workers, seconds in ((1, one[kind.name]), (2, two)):
                crew = _crew(workers, own, post)
                foretold = run_chunks(crew, _chunks(own.grain, samples))
                checks.append(
                    {
                        "kind": kind.name,
                        "workers": workers,
                        "seconds": seconds,
                        "simulated": foretold,
                    }
                )
            say(f"{kind.name}: two workers, {two:.1f} s")
    # Processes that were waited for count as ours.
    others = load.share()
    curves = []
    for own, hours, workers in itertools.product(costs.values(), HOURS, COUNTS):
        curves.append({"hours": hours} | simulate(own, post, workers, samples_of(own, hours), LINE))
    say("numbers of workers simulated")
    levers = [
        row
        for own in costs.values()
        for workers, hours in ((SOME, HOURS[0]), (COUNTS[-1], HOURS[-1]))
        for row in try_levers(own, post, workers, hours)
    ]
    say("what matters simulated")
    return {
        "others": others,
        "post": asdict(post),
        "costs": {name: asdict(own) for name, own in costs.items()},
        "checks": checks,
        "curves": curves,
        "levers": levers,
    }


def samples_of(costs: JobCosts, hours: float) -> int:
    """Samples of a value that take one worker so long in chunks of the longest kind."""
    grain = costs.grain
    count = 3600.0 * hours / costs.work(grain.most) * grain.most
    return max(round(count / grain.step), 1) * grain.step


def simulate(
    costs: JobCosts,
    post,
    workers: int,
    samples: int,
    line: Line,
    **options,
) -> dict:
    """Simulate a job.

    Returns
    -------
    dict    ``seconds`` that it takes, ``efficiency``: time of one worker that only computes over that and their number, and
        ``held``: answers that wait here at most.
    """
    crew = _crew(workers, costs, post, line, **options)
    chunks = _chunks(costs.grain, samples)
    alone = costs.begin + sum(costs.work(chunk.samples) for chunk in chunks)
    seconds = run_chunks(crew, chunks)
    return {
        "kind": costs.name,
        "workers": workers,
        "chunks": len(chunks),
        "seconds": seconds,
        "efficiency": alone / (workers * seconds),
        "held": crew.most_held,
    }


def try_levers(costs: JobCosts, post, workers: int, hours: float) -> list[dict]:
    """Change one thing at a time, and tell what that does to the efficiency."""
    grain, samples = costs.grain, samples_of(costs, hours)
    free = replace(post, here=0.0, here_byte=0.0)
    fast = {name: getattr(costs, name) / FAST for name in ("begin", "fixed", "pace")}
    quarter = max(grain.most // 4 // grain.step * grain.step, grain.least)
    trials = {
        "as it is": {},
        "line of 1 Gbit/s": {"line": SLOW_LINE},
        "scene of 500 MB": {"costs": replace(costs, scene_bytes=LARGE_SCENE)},
        "merging takes no time": {"costs": replace(costs, take=0.0, end=0.0)},
        "errands take no time here": {"post": free, "own_time": lambda: 0.0},
        "scheduler takes no time": {"post": replace(post, scheduler=0.0, scheduler_byte=0.0)},
        "chunks never grow": {"costs": _with_grain(costs, grain.least, grain.least)},
        "all chunks of the longest": {"costs": _with_grain(costs, grain.most, grain.most)},
        "longest chunks a quarter": {"costs": _with_grain(costs, grain.least, quarter)},
        "longest chunks four times": {"costs": _with_grain(costs, grain.least, 4 * grain.most)},
        "one chunk of 100 is late": {"tail": TAIL},
        "workers without kernels": {"is_cold": True},
        f"workers {FAST:g} times as fast": {"costs": replace(costs, **fast)},
    }
    rows = []
    for name, changes in trials.items():
        given = {"costs": costs, "post": post, "line": LINE} | changes
        row = simulate(workers=workers, samples=samples, **given)
        rows.append({"lever": name, "hours": hours} | row)
    return rows


def reaches(curve: list[dict], efficiency: float) -> int | None:
    """Most workers that are at least as efficient, None where the fewest are not."""
    fit = [row["workers"] for row in curve if row["efficiency"] >= efficiency]
    return max(fit) if fit else None


def _with_grain(costs: JobCosts, least: int, most: int) -> JobCosts:
    return replace(costs, grain=Grain(least, most, costs.grain.step))


def _crew(workers: int, costs: JobCosts, post, *line, **options) -> SimulatedCrew:
    names = tuple(f"{number:04}" for number in range(workers))
    return SimulatedCrew(names, costs, post, *line, seed=SEED, **options)


def _chunks(grain: Grain, samples: int) -> list[Chunk]:
    return list(cut(StopRule(samples=samples), SEED, grain))
