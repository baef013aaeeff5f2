"""Seconds to an error: our bake beside plain gathering, Cycles and Radiance, on the same lumels in one run."""

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...validation.bench import CannotStateError
from ..common.statistics import Reach, seconds_to
from .ours import Judge, Ours, find_judge
from .scenes import AtlasScene
from .stage import Stage

OURS = "Lumenray"

RIVALS = {
    "plain_gather": "Plain gathering",
    "cycles": "Cycles",
    "radiance": "Radiance",
}
"""Names in results, and for people."""

TARGETS = (0.02, 0.01)
"""Relative errors to which programs race. [-]"""

LEVELS = (0.04, 0.02, 0.01)
"""Errors that ours is asked for. [-]"""

SWITCHES = ("qmc", "direct_apart", "adaptive")
"""Parts of our method that are turned off, one at a time, for what they are worth."""

SWITCH_LEVELS = (0.04, 0.02)
"""Errors that are asked for then."""

LEAST_SAMPLES, GROWTH = 16, 4
"""Of plain gathering and Cycles, per lumel; and of a run over that of the run before."""

LEAST_RUNS = 3
"""Of others: fewer tell no slope."""

LONGEST, QUICK_LONGEST = 8.0, 3.0
"""Further runs of others that would take longer are not made. [s]"""

TRIES = 2
"""Times that a run is made, with the same seed; the fastest counts, since what else a machine does only adds to a time."""

OUR_LONGEST = 30.0
"""After a bake of ours that takes longer no finer one is made. [s]"""

SEED = 301


def race(scene: AtlasScene, with_peers: bool, is_quick: bool, say) -> dict:
    """Race on a scene, which must be plain (see `variants.make_plain`).

    Returns
    -------
    dict    ``key``, ``title``, ``lumels``, ``judged``, ``reference_error``; ``first_seconds``: of the very first bake, with
        kernels compiled where the machine's cache has none; ``programs``: by name ``points``: (seconds, error) by run,
        ``work``: what each run was, ``scaled``: by how much the times of the lumels that were computed are multiplied, and
        ``mean``: of the last run over the reference, or ``refusal``; ``switches``: ours without a part, likewise.
    """
    longest = QUICK_LONGEST if is_quick else LONGEST
    ours = Ours(scene)
    first = ours.bake(StopRule(error=LEVELS[0]), SEED - 1)
    judge = find_judge(scene, first.result, say, inner_only=True)
    result = {
        "key": scene.key,
        "title": scene.title,
        "lumels": len(judge.places),
        "judged": len(judge.rows),
        "reference_error": judge.reference.relative_error,
        "first_seconds": first.seconds,
        "programs": {OURS: _run_ours(ours, judge, LEVELS)},
        "switches": {},
    }
    say(f"{scene.key}: ours {_told(result['programs'][OURS])}")
    from ...engine.transport.lux_maps.job import Options

    for name in SWITCHES:
        made = _run_ours(ours, judge, SWITCH_LEVELS, Options(**{name: False}))
        result["switches"][name] = made
        say(f"{scene.key}: without {name} {_told(made)}")
    del ours
    rivals = {"plain_gather": _run_plain}
    if with_peers:
        rivals |= {"cycles": _run_cycles, "radiance": _run_radiance}
    for name, run in rivals.items():
        try:
            made = run(scene, judge, first.result, longest)
        except CannotStateError as error:
            made = {"refusal": str(error)}
        result["programs"][name] = made
        say(f"{scene.key}: {name} {_told(made)}")
    return result


def _run_ours(ours: Ours, judge: Judge, levels, options=None) -> dict:
    # What is compiled for it does not count.
    ours.bake(StopRule(error=levels[0]), SEED, options)
    points, means = [], []
    for level in levels:
        tries = [ours.bake(StopRule(error=level), SEED, options) for _ in range(TRIES)]
        made = min(tries, key=lambda each: each.seconds)
        values = judge.judged.values(made.result)
        points.append((made.seconds, judge.reference.error_of(values)))
        means.append(judge.reference.ratio(values)[0])
        if made.seconds > OUR_LONGEST:
            # The next one would take four times as long; its time follows from those that were run.
            break
    work = [f"{100 * level:g} %" for level in levels[: len(points)]]
    return {"points": points, "work": work, "scaled": 1.0, "mean": means[-1]}


def _run_plain(scene: AtlasScene, judge: Judge, _result, longest: float) -> dict:
    from .gather import PlainGather

    stage = Stage(scene)
    gather = PlainGather(stage, judge.judged)
    scale = len(judge.places) / len(judge.rows)
    points, work, samples, last = [], [], LEAST_SAMPLES, 0.0
    while len(points) < LEAST_RUNS or GROWTH * last <= longest:
        if not points or samples <= LEAST_SAMPLES * GROWTH**2:
            # Each length of a launch is a kernel of its own.
            gather.run(samples, SEED)
        values, last = _fastest(lambda samples=samples: gather.run(samples, SEED))
        points.append((scale * last, judge.reference.error_of(values)))
        work.append(f"{samples} samples")
        samples *= GROWTH
    return {
        "points": points,
        "work": work,
        "scaled": scale,
        "mean": judge.reference.ratio(values)[0],
    }


def _run_cycles(scene: AtlasScene, judge: Judge, result, longest: float) -> dict:
    from .cycles import CyclesBake

    cycles = CyclesBake(scene, result)
    judged = judge.judged
    try:
        # Loading, building and one sample: not the bake's own.
        start_up = _fastest(lambda: cycles.run(1))[1]
        points, work, samples, last = [], [], LEAST_SAMPLES, 0.0
        while len(points) < LEAST_RUNS or GROWTH * last <= longest:
            page, seconds = _fastest(lambda samples=samples: cycles.run(samples))
            last = max(seconds - start_up, 1e-3)
            values = page[judged.y, judged.x]
            points.append((last, judge.reference.error_of(values)))
            work.append(f"{samples} samples")
            samples *= GROWTH
    finally:
        cycles.close()
    return {
        "points": points,
        "work": work,
        "scaled": 1.0,
        "start_up": start_up,
        "mean": judge.reference.ratio(values)[0],
    }


def _fastest(run):
    """The fastest of a few equal runs. ``run``: gives its answer and its seconds."""
    return min((run() for _ in range(TRIES)), key=lambda made: made[1])


def _run_radiance(scene: AtlasScene, judge: Judge, _result, longest: float) -> dict:
    """Run both ways; the better one races."""
    from .radiance import CACHED, EXACT, RadianceRace

    made = {}
    for name, settings, rows in (
        ("exact", EXACT, judge.rows),
        ("cached", CACHED, np.arange(len(judge.places))),
    ):
        places = judge.places.take(rows)
        # Neighbouring places share the cache, so all lumels are asked for where there is one.
        scale = len(judge.places) / len(rows)
        mine = np.searchsorted(rows, judge.rows)
        radiance = RadianceRace(scene, places)
        points, work, last = [], [], 0.0
        try:
            for setting in settings:
                if len(points) >= LEAST_RUNS and GROWTH * last > longest:
                    break
                answer = radiance.run(setting, GROWTH * longest)
                if answer is None:
                    break
                values, last = answer
                mean = judge.reference.ratio(values[mine])[0]
                points.append((scale * last, judge.reference.error_of(values[mine])))
                work.append(" ".join(setting.options))
        finally:
            radiance.close()
        if not points:
            continue
        made[name] = {
            "points": points,
            "work": work,
            "scaled": scale,
            "mean": mean,
        }
    if not made:
        raise CannotStateError(
            f"rtrace takes longer than {GROWTH * longest:g} s for its least work"
        )
    return {"ways": made}


def reach(row: dict, target: float) -> Reach | None:
    """Time of a program to an error, by the better of its ways; None where it did not run."""
    if "refusal" in row:
        return None
    found = [seconds_to(way["points"], target) for way in ways_of(row).values()]
    # What is only a lower bound does not beat what is known.
    return min(found, key=lambda each: (each.bound == ">", each.seconds))


def ways_of(row: dict) -> dict[str, dict]:
    """Runs of a program by name of its way, one of an empty name where there is but one."""
    return row.get("ways", {"": row})


def _told(row: dict) -> str:
    if "refusal" in row:
        return row["refusal"]
    return "; ".join(
        ", ".join(f"{100 * error:.2f} % in {seconds:.2f} s" for seconds, error in way["points"])
        for way in ways_of(row).values()
    )
