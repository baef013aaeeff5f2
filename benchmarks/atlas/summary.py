"""The few numbers that a run of the benchmark of the atlas comes to."""

import numpy as np

from ..common.statistics import Reach, geometric_mean, median
from .race import OURS, RIVALS, SWITCHES, TARGETS, reach


def summarise(calibration: list[dict], races: list[dict]) -> dict:
    """Return `calibration`, `coverage_95`, `forecast_median_error`, `rough_forecast_median_error` and `speedup`; None where
    nothing was measured.
    """
    runs = [run for scene in calibration for run in scene["runs"]]
    return {
        "calibration": float(np.mean([run["ratio"] for run in runs])) if runs else None,
        "coverage_95": float(np.mean([run["covered"] for run in runs])) if runs else None,
        "forecast_median_error": median(forecast_errors(calibration, "settled")),
        "rough_forecast_median_error": median(forecast_errors(calibration, "rough")),
        "speedup": {name: speedup(races, name) for name in (*RIVALS, "qmc", "direct_apart")},
    }


def scene_ratios(calibration: list[dict]) -> dict[tuple[str, float], float]:
    """Mean of true over stated error by scene and error that was asked for. [-]"""
    found: dict[tuple[str, float], list[float]] = {}
    for scene in calibration:
        for run in scene["runs"]:
            found.setdefault((scene["key"], run["level"]), []).append(run["ratio"])
    return {key: float(np.mean(ratios)) for key, ratios in found.items()}


def forecast_errors(calibration: list[dict], which: str) -> list[float]:
    """Relative errors of the ``rough`` or ``settled`` forecasts of all bakes, 1 where there was none. [-]"""
    return [
        1.0 if row[which] is None else abs(row[which]["share"] - 1.0)
        for scene in calibration
        for row in scene["forecasts"]
    ]


def speedup(races: list[dict], name: str) -> float | None:
    """Geometric mean over scenes and errors of another program's time over ours."""
    return geometric_mean(
        [
            found
            for scene in races
            for target in TARGETS
            if (found := ratio(scene, name, target)[0]) is not None
        ]
    )


def ratio(scene: dict, name: str, target: float) -> tuple[float | None, str, bool]:
    """Time of a program, or of ours without one of `race.SWITCHES`, over ours.

    Returns
    -------
    (float or None, str, bool)    The ratio, whether it is only a bound (``<`` or ``>``), and whether a time lies beyond the
        runs.
    """
    rows = scene["switches"] if name in SWITCHES else scene["programs"]
    ours = reach(scene["programs"][OURS], target)
    other = reach(rows[name], target) if name in rows else None
    if other is None:
        return None, "", False
    return other.seconds / ours.seconds, _bound(other, ours), other.is_thought_on


def _bound(other: Reach, ours: Reach) -> str:
    """Side on which the ratio of two times is known."""
    mirrored = {"<": ">", ">": "<", "": ""}[ours.bound]
    if other.bound and mirrored and other.bound != mirrored:
        return "?"
    return other.bound or mirrored
