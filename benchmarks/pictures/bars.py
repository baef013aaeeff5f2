"""What the benchmark of pictures has to show, and whether it does."""

from ..common.bars import Bar
from .programs import BEFORE, CYCLES
from .summary import RIVALS

FASTER = {CYCLES: 25.0, BEFORE: 6.0}
"""Least that we have to be faster, on the geometric mean."""

LEAST = 3.0
"""Least that we have to be faster than Cycles in any scene."""

BIAS = 0.5
"""Most that a block may be off, of the mean luminance. [%]"""

CALIBRATION = (0.9, 1.1)
"""Stated over true error, in every scene."""

TITLES = {CYCLES: "Cycles", BEFORE: "plain paths of ours"}


def check_bars(result: dict) -> list[Bar]:
    """Judge results of `run.measure`."""
    speedup = result["speedup"]
    bars = [
        _at_least(f"time of {TITLES[name]} over ours", speedup[name], FASTER[name])
        for name in RIVALS
    ]
    scenes = {key: row[CYCLES] for key, row in speedup["scenes"].items() if row[CYCLES] is not None}
    worst = min(scenes, key=scenes.get, default=None)
    told = "" if worst is None else f" ({worst})"
    bars.append(_at_least("the same in the worst scene", scenes.get(worst), LEAST, told))
    bars.append(_most("bias of the worst block beyond noise", result["bias_percent"], BIAS))
    bars.append(_check_calibration(result["calibration_scenes"]))
    return bars


def _at_least(demand: str, value, least: float, told: str = "") -> Bar:
    if value is None:
        return Bar(demand, f"x {least:g}", "-", None)
    return Bar(demand, f"x {least:g}", f"x {value:.3g}{told}", value >= least)


def _most(demand: str, value, limit: float) -> Bar:
    if value is None:
        return Bar(demand, f"{limit:g} %", "-", None)
    return Bar(demand, f"{limit:g} %", f"{value:.2g} %", value <= limit)


def _check_calibration(scenes: dict) -> Bar:
    """Judge the scene whose stated errors are farthest from the true ones."""
    low, high = CALIBRATION
    demand, limit = "stated over true error, every scene", f"{low:g} to {high:g}"
    known = {key: value for key, value in scenes.items() if value is not None}
    if not known:
        return Bar(demand, limit, "-", None)
    key = max(known, key=lambda each: max(known[each] - high, low - known[each]))
    measured = f"{known[key]:.2f} at worst ({key})"
    return Bar(demand, limit, measured, low <= known[key] <= high)
