"""The few numbers that a run of the benchmark of pictures comes to."""

import numpy as np

from ..common.statistics import geometric_mean
from .programs import BEFORE, CYCLES, OURS
from .race import calibration_of, reach
from .statistics import TARGETS

RIVALS = (CYCLES, BEFORE)


def summarise(scenes: list[dict]) -> dict:
    """Return ``speedup``: geometric means of others' times over ours by program, and ``scenes``: those of each scene;
    ``bias_percent``: of the worst block, beyond noise; ``calibration``: mean of stated over true errors;
    ``calibration_scenes``. None where nothing was measured.
    """
    speedups = {scene["key"]: {name: speedup([scene], name) for name in RIVALS} for scene in scenes}
    calibration = {scene["key"]: scene_calibration(scene) for scene in scenes}
    known = [value for value in calibration.values() if value is not None]
    biases = [scene["bias"]["worst"] for scene in scenes if scene["bias"] is not None]
    return {
        "speedup": {name: speedup(scenes, name) for name in RIVALS} | {"scenes": speedups},
        "bias_percent": max(biases, default=None),
        "calibration": float(np.mean(known)) if known else None,
        "calibration_scenes": calibration,
    }


def scene_calibration(scene: dict) -> float | None:
    """Mean of stated over true errors of our runs in a scene, None where all were too coarse. [-]"""
    ratios = calibration_of(scene["programs"][OURS])
    return float(np.mean(ratios)) if ratios else None


def speedup(scenes: list[dict], name: str) -> float | None:
    """Geometric mean over scenes and errors of another program's time over ours."""
    found = (ratio(scene, name, target)[0] for scene in scenes for target in TARGETS)
    return geometric_mean([value for value in found if value is not None])


def ratio(scene: dict, name: str, target: float) -> tuple[float | None, str, bool]:
    """Time of another program to an error over ours.

    Returns
    -------
    (float or None, str, bool)    The ratio, whether it is only a bound (``<`` or ``>``, ``?`` where nothing is known), and
        whether a time is extended beyond the runs.
    """
    ours = reach(scene["programs"][OURS], target)
    other = reach(scene["programs"].get(name), target)
    if other is None:
        return None, "", False
    mirrored = {"<": ">", ">": "<", "": ""}[ours.bound]
    bound = other.bound or mirrored
    if other.bound and mirrored and other.bound != mirrored:
        return None, "?", False
    return other.seconds / ours.seconds, bound, other.is_thought_on or ours.is_thought_on
