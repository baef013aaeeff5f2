"""Whether the stated errors of maps are the true ones, and how good the forecast of their time is."""

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.accuracy.student import t_quantile
from ...engine.baking.order import BakeResult
from .ours import Judge, Made, Ours, find_judge
from .scenes import AtlasScene

LEVELS = (0.02, 0.01)
"""Relative standard errors that are asked for. [-]"""

SEEDS, QUICK_SEEDS = 4, 2
"""Bakes at every level."""

FORECAST_SECONDS, QUICK_FORECAST_SECONDS = 60.0, 4.0
"""About how long the bakes take whose forecasts are judged. [s]"""

FORECAST_AT = 0.05
"""Share of a bake's time after which its first forecast is taken. [-]"""

PASSES_SEEN = 2
"""Marks, of the pilot and of a first pass, after which a forecast rests on passes alone."""

FORECASTS, QUICK_FORECASTS = 2, 1
"""Bakes of every scene whose forecast is judged."""

LONGEST = 30.0
"""A finer level is left out where its bakes would take longer. [s]"""

CONFIDENCE = 0.95
"""Of the intervals that are held against references."""

FIRST_SEED = 201


def measure_scene(scene: AtlasScene, is_quick: bool, say) -> dict:
    """Bake a scene at all levels.

    Returns
    -------
    dict    ``key``, ``title``, ``lumels``, ``judged``, ``cut``, ``reference_error`` [-], ``runs``: see `judge_run`, and
        ``forecasts``: see `judge_forecast`.
    """
    ours = Ours(scene)
    seeds = QUICK_SEEDS if is_quick else SEEDS
    # Kernels are compiled now, and the layout is found.
    first = ours.bake(StopRule(error=LEVELS[0]), FIRST_SEED - 1)
    judge = find_judge(scene, first.result, say)
    runs, seconds = [], {}
    for level in LEVELS:
        if seconds and 4.0 * float(np.median(seconds[LEVELS[0]])) > LONGEST:
            break
        for number in range(seeds):
            made = ours.bake(StopRule(error=level), FIRST_SEED + number)
            seconds.setdefault(level, []).append(_sampling_seconds(made))
            runs.append(judge_run(judge, made, level, FIRST_SEED + number))
        say(f"{scene.key}: {100 * level:g} %: true over stated {_ratios(runs, level)}")
    wanted = QUICK_FORECAST_SECONDS if is_quick else FORECAST_SECONDS
    last = list(seconds)[-1]
    target = last * float(np.sqrt(np.median(seconds[last]) / wanted))
    forecasts = []
    for number in range(QUICK_FORECASTS if is_quick else FORECASTS):
        made = ours.bake(StopRule(error=target), FIRST_SEED + 50 + number)
        forecasts.append(judge_forecast(made.result, target))
    for name in ("rough", "settled"):
        shares = [row[name] and round(row[name]["share"], 3) for row in forecasts]
        say(f"{scene.key}: {name} forecast over true {shares}")
    return {
        "key": scene.key,
        "title": scene.title,
        "lumels": len(judge.places),
        "judged": len(judge.rows),
        "cut": judge.cut,
        "reference_error": judge.reference.relative_error,
        "runs": runs,
        "forecasts": forecasts,
    }


def judge_run(judge: Judge, made: Made, level: float, seed: int) -> dict:
    """Compare a bake with the reference.

    Returns
    -------
    dict    ``level``, ``seed``, ``seconds``; ``stated``: its relative error for everything; ``stated_here`` and ``true``:
        for the judged lumels; ``ratio`` of these; ``covered``: share of the judged lumels whose 95 % interval holds the
        reference; ``mean``: of the judged lumels over the reference; ``replicates``.
    """
    values, errors = judge.judged.values(made.result), judge.judged.errors(made.result)
    page = made.result.pages[0]
    reference = judge.reference
    true, stated = reference.error_of(values), reference.stated(errors)
    return {
        "level": level,
        "seed": seed,
        "seconds": made.seconds,
        "stated": made.result.relative_standard_error,
        "stated_here": stated,
        "true": true,
        "ratio": true / stated,
        "covered": covered_share(values - reference.values, errors, reference.errors, page.freedom),
        "mean": reference.ratio(values)[0],
        "replicates": page.replicates,
    }


def covered_share(differences, errors, reference_errors, freedom: float) -> float:
    """Share of lumels whose interval of 95 % holds the reference.

    The reference's own error is small and widens the interval by its share.
    """
    half = t_quantile(0.5 + 0.5 * CONFIDENCE, freedom)
    return float((np.abs(differences) <= half * np.hypot(errors, reference_errors)).mean())


def judge_forecast(result: BakeResult, target: float) -> dict:
    """Compare forecasts made early with the time that the bake took.

    Returns
    -------
    dict    ``target`` [-], ``seconds``: that it took; ``rough`` and ``settled``: the first forecast after a twentieth of the
        time, and that after two passes, which have shown how fast the error falls. Each a dict of ``at``: share of the time
        when it was made, ``forecast``: of the whole [s], and ``share``: forecast over true; None where there was none.
    """
    marks = result.history.marks
    total = marks[-1].seconds
    told = [mark for mark in marks[:-1] if mark.forecast is not None]
    made = {"target": target, "seconds": total}
    for name, own in (
        ("rough", [mark for mark in told if mark.seconds >= FORECAST_AT * total]),
        ("settled", [mark for mark in told if mark in marks[PASSES_SEEN:] and mark.samples > 0.0]),
    ):
        made[name] = None
        if own:
            at, forecast = own[0].seconds, own[0].forecast
            made[name] = {"at": at / total, "forecast": forecast, "share": forecast / total}
    return made


def _sampling_seconds(made: Made) -> float:
    return max(made.seconds - made.result.history.setup_seconds, 1e-3)


def _ratios(runs: list[dict], level: float) -> str:
    return ", ".join(f"{row['ratio']:.2f}" for row in runs if row["level"] == level)
