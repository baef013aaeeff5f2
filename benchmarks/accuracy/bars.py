"""What the benchmark of accuracy has to show, and whether it does."""

import math
import statistics

from ..common.bars import Bar
from .programs import OURS, PEERS
from .statistics import Figure, ratio_to, slope_of, tell_ratio

SLOPE = -0.45
"""Flattest slope of ours: plain Monte Carlo has -0.5."""

HONESTY = 1.25
"""Most that the true error may be of the stated one, and the other way round."""

FORECAST = 2.0
"""Most that a forecast may be of the true time left, and the other way round."""

TYPICAL = 0.2
"""Largest median error of the whole time that is foretold. [-]"""

LATE = 0.5
"""Share of the whole time after which a first forecast is none. [-]"""

TARGET = 0.003
"""Relative error that others must not reach sooner."""


def check_bars(result: dict) -> list[Bar]:
    """Judge results of `accuracy.run`."""
    made = []
    for name in OURS:
        rows = {scene["key"]: scene["programs"][name] for scene in result["scenes"]}
        slopes = {key: slope_of(row) for key, row in rows.items()}
        made.append(_within(f"slope, {name}", f"{SLOPE:g} at most", slopes, -math.inf, SLOPE))
    shares = {
        f"{scene['key']}, {row['work']} samples": Figure(row["share"], "", row["spread"])
        for scene in result["scenes"]
        for row in scene["honesty"]
    }
    limit = f"{1 / HONESTY:.2f} to {HONESTY:.2f}"
    made.append(_within("true over stated error", limit, shares, 1.0 / HONESTY, HONESTY))
    made += [_check_forecasts(result), _check_typical_forecast(result)]
    made += [_check_peer(result, name) for name in PEERS]
    return made


def _within(demand: str, limit: str, figures: dict[str, Figure], low: float, high: float) -> Bar:
    """Judge figures by name; within its spread a figure cannot be told from a limit."""
    known = {key: figure for key, figure in figures.items() if not figure.bound}
    if not known:
        return Bar(demand, limit, "-", None)

    def excess(key: str) -> float:
        return max(known[key].value - high, low - known[key].value)

    passed = all(excess(key) <= (known[key].spread or 0.0) for key in known)
    worst = max(known, key=excess)
    figure = known[worst]
    spread = "" if figure.spread is None else f" ± {figure.spread:.2f}"
    return Bar(demand, limit, f"{figure.value:.2f}{spread} at worst ({worst})", passed)


def _check_forecasts(result: dict) -> Bar:
    shares = [
        row["forecast"] / row["left"]
        for scene in result["scenes"]
        for row in scene["forecasts"]
        if row["forecast"] is not None
    ]
    limit = f"x {1 / FORECAST:g} to {FORECAST:g}"
    if not shares:
        return Bar("forecast over true time left", limit, "-", None)
    measured = f"x {min(shares):.2f} to {max(shares):.2f}"
    passed = min(shares) >= 1.0 / FORECAST and max(shares) <= FORECAST
    return Bar("forecast over true time left", limit, measured, passed)


def _check_typical_forecast(result: dict) -> Bar:
    """Judge the whole time as it was foretold, of which a part had passed already."""
    errors = [_miss(row) for scene in result["scenes"] for row in scene["forecasts"]]
    demand, limit = "forecast of the whole time, median error", f"{100 * TYPICAL:g} %"
    if not errors:
        return Bar(demand, limit, "-", None)
    typical = statistics.median(errors)
    return Bar(demand, limit, f"{100 * typical:.2g} %", typical <= TYPICAL)


def _miss(row: dict) -> float:
    """Error of a forecast, relative to the whole time; 1 where it came too late to be of use, or never."""
    if row["forecast"] is None or row["seconds"] - row["left"] > LATE * row["seconds"]:
        return 1.0
    return abs(row["forecast"] - row["left"]) / row["seconds"]


def _check_peer(result: dict, name: str) -> Bar:
    """Judge by the scene in which the other program does best."""
    found = []
    for scene in result["scenes"]:
        row = scene["programs"].get(name)
        if row is not None and "refusal" not in row:
            figure = ratio_to(scene["programs"][OURS[0]], row, TARGET)
            if figure.bound != "?":
                found.append((figure, scene["key"]))
    demand = f"time of {name} to {100 * TARGET:g} % over ours"
    if not found:
        return Bar(demand, "x 1 at least", "-", None)
    least, key = min(found, key=lambda pair: pair[0].value)
    # Within its spread a ratio cannot be told from 1.
    passed = least.value * math.exp(least.spread or 0.0) >= 1.0
    if (least.bound == ">" and not passed) or (least.bound == "<" and passed):
        passed = None
    return Bar(demand, "x 1 at least", f"{tell_ratio(least)} ({key})", passed)
