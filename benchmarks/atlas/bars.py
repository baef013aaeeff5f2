"""What the benchmark of the atlas has to show, and whether it does."""

import numpy as np

from ..common.bars import Bar
from .race import RIVALS
from .scale import MEMORY, growth
from .summary import scene_ratios

CALIBRATION = (0.9, 1.1)
"""Mean of true over stated error, of all scenes and of each at every error that is asked for."""

COVERAGE = (0.93, 0.97)
"""Share of lumels whose 95 % interval holds the truth."""

FORECAST = 0.03
"""Largest median relative error of the first forecast after a twentieth of the time, and of that after two passes."""

FASTER = {"plain_gather": 8.0, "cycles": 100.0, "radiance": 100.0}
"""Least that we have to be faster, on the geometric mean."""

PARTS = {"qmc": (1.5, 4.0), "direct_apart": (1.1, 2.5)}
"""What single parts of the method were worth in the reference system; printed, not demanded."""

DARK = 0.001
"""Most that the dark side may have of the lit one."""

GROWTH = 1.15
"""Largest exponent of the time in the lumels that counts as close to linear."""

EXACT = 0.05
"""Most that a lumel of hard geometry may differ from its exact value, with few samples. [-]"""


def check_bars(result: dict) -> list[Bar]:
    """Judge results of `run.measure`."""
    bars = [
        _between("true over stated error, mean", result["calibration"], *CALIBRATION, 1.0, ""),
        _check_scenes(result["scenes"]),
        _between("95 % intervals that hold", result["coverage_95"], *COVERAGE, 100.0, " %"),
        _most("forecast after two passes, median error", result["forecast_median_error"], FORECAST),
        _most("first forecast, median error", result["rough_forecast_median_error"], FORECAST),
    ]
    for name, least in FASTER.items():
        bars.append(_at_least(f"time of {RIVALS[name]} over ours", result["speedup"][name], least))
    for name, (low, high) in PARTS.items():
        value = result["speedup"][name]
        demand = f"gain by {name.replace('_', ' ')} alone"
        measured = "-" if value is None else f"x {value:.2f}"
        bars.append(Bar(demand, f"told (once x {low:g} to {high:g})", measured, None))
    bars += _check_geometry(result["geometry"])
    bars += _check_scale(result["scale"])
    return bars


def _between(demand: str, value, low: float, high: float, factor: float, unit: str) -> Bar:
    limit = f"{factor * low:g} to {factor * high:g}{unit}"
    if value is None:
        return Bar(demand, limit, "-", None)
    return Bar(demand, limit, f"{factor * value:.3g}{unit}", low <= value <= high)


def _check_scenes(scenes: list[dict]) -> Bar:
    """Judge the scene whose stated errors are farthest from the true ones."""
    demand, limit = (
        "true over stated error, every scene",
        f"{CALIBRATION[0]:g} to {CALIBRATION[1]:g}",
    )
    ratios = scene_ratios(scenes)
    if not ratios:
        return Bar(demand, limit, "-", None)
    low, high = CALIBRATION
    (key, level), ratio = max(ratios.items(), key=lambda row: max(row[1] - high, low - row[1]))
    told = f"{ratio:.2f} at worst ({key}, {100 * level:g} %)"
    return Bar(demand, limit, told, low <= ratio <= high)


def _most(demand: str, value, limit: float) -> Bar:
    if value is None:
        return Bar(demand, f"{100 * limit:g} %", "-", None)
    return Bar(demand, f"{100 * limit:g} %", f"{100 * value:.2g} %", value <= limit)


def _at_least(demand: str, value, least: float) -> Bar:
    if value is None:
        return Bar(demand, f"x {least:g}", "-", None)
    return Bar(demand, f"x {least:g}", f"x {value:.3g}", value >= least)


def _check_geometry(geometry: dict | None) -> list[Bar]:
    if geometry is None:
        return []
    worst = max(geometry["leaks"], key=lambda row: row["dark"])
    bars = [
        Bar(
            "dark side over lit side",
            f"{100 * DARK:g} %",
            f"{100 * worst['dark']:.2g} % ({worst['case']})",
            worst["dark"] < DARK,
        )
    ]
    for row in geometry["seams"]:
        measured = f"{row['step']:.3g} lx, noise {row['noise']:.3g} lx"
        demand = f"step at seams, {100 * row['error']:g} %"
        bars.append(Bar(demand, "its noise", measured, row["step"] <= row["noise"]))
    hard = geometry["hard"]
    bad = [row["case"] for row in hard if "failure" in row or row["not_finite"]]
    measured = f"{len(hard) - len(bad)} of {len(hard)} cases" + (
        f" (not {', '.join(bad)})" if bad else ""
    )
    bars.append(Bar("hard geometry without a number that is none", "all", measured, not bad))
    known = [row for row in hard if row.get("low") is not None]
    if known:
        farthest = max(known, key=lambda row: max(1.0 - row["low"], row["high"] - 1.0))
        off = max(1.0 - farthest["low"], farthest["high"] - 1.0)
        measured = f"{100 * off:.2g} % ({farthest['case']})"
        bars.append(
            Bar("hard geometry, lumel farthest off", f"{100 * EXACT:g} %", measured, off <= EXACT)
        )
    return bars


def _check_scale(scale: dict | None) -> list[Bar]:
    if scale is None:
        return []
    rows = scale["runs"]
    largest = max(rows, key=lambda row: row["lumels"])
    memory = max(row["memory"] for row in rows)
    title = f"memory, {largest['pages']} pages, {largest['triangles'] / 1e6:.1f} M triangles"
    bars = [Bar(title, f"{MEMORY:g} GiB", f"{memory:.1f} GiB", memory <= MEMORY)]
    power = growth(rows)
    if power is not None:
        bars.append(
            Bar("exponent of time in lumels", f"{GROWTH:g}", f"{power:.2f}", power <= GROWTH)
        )
    return bars


TOLERANCES = {"calibration": 0.05, "coverage_95": 0.015, "forecast_median_error": 0.02}
"""How far two runs may differ in these numbers."""

FACTOR = 1.5
"""By how much two runs may differ in ratios of times."""


def compare_results(before: dict, after: dict) -> list[Bar]:
    """Compare the numbers of two runs that both have."""
    bars = []
    for name, tolerance in TOLERANCES.items():
        a, b = before.get(name), after.get(name)
        if a is not None and b is not None:
            measured = f"{a:.3f} before, {b:.3f} now"
            bars.append(Bar(name, f"± {tolerance:g}", measured, abs(a - b) <= tolerance))
    for name, a in before.get("speedup", {}).items():
        b = after["speedup"].get(name)
        if a is not None and b is not None:
            measured = f"x {a:.3g} before, x {b:.3g} now"
            passed = abs(np.log(a / b)) <= np.log(FACTOR)
            bars.append(Bar(f"speedup, {name}", f"×/÷ {FACTOR:g}", measured, bool(passed)))
    return bars
