"""From runs to what is told: error over time, times to an error, their ratios, slopes, each with its spread."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...engine.accuracy.student import t_quantile

LEAST_SPREAD = 0.05
"""Spread of a ratio of times that is stated at least: clocks of processors change."""

DECADE = 10.0
"""Errors up to so many times larger or smaller than a target take part in finding the work that it takes."""

SLOPE_RANGE = (1e-4, 0.3)
"""Relative errors that take part in slopes: below, the reference values' own errors begin to count."""


@dataclass(frozen=True)
class Curve:
    """Error over time of a program in a scene, all rounds together.

    Parameters
    ----------
    work : (k,) float64 array
    seconds : (k,) float64 array    Medians.
    errors : (k,) float64 array    Root mean squares, relative. [-]
    low, high : (k,) float64 array    Smallest and largest error of a round. [-]
    resolution : float    Times this short cannot be told from start-up. [s]
    """

    work: np.ndarray
    seconds: np.ndarray
    errors: np.ndarray
    low: np.ndarray
    high: np.ndarray
    resolution: float

    @property
    def is_timed(self) -> np.ndarray:
        """Which times can be told from start-up. (k,)"""
        return self.seconds > self.resolution


@dataclass(frozen=True)
class Figure:
    """A number with its spread.

    Parameters
    ----------
    value : float
    bound : str    ``<`` or ``>`` where the number is only an upper or lower bound, ``?`` where nothing is known.
    spread : float or None    Half of the 99 % interval, of the logarithm for times and ratios; None: unknown.
    """

    value: float
    bound: str = ""
    spread: float | None = None


def make_curve(row: dict, rounds=None) -> Curve:
    """Make the curve of a program's row of `programs.measure_scene`; ``rounds``: indices of those to take."""
    seconds, errors = np.array(row["seconds"]), np.array(row["errors"])
    work = np.array(row["work"], dtype=np.float64)
    if rounds is not None:
        seconds, errors = seconds[rounds], errors[rounds]
    middle, resolution = np.median(seconds, axis=0), 0.0
    if not row["is_ours"]:
        # The first run is as good as nothing but start-up.
        resolution = max(float(np.ptp(np.array(row["seconds"])[:, 0])), 1e-3)
        middle = np.maximum(middle - middle[0], resolution)
        if len(work) > 1:
            middle, work, errors = middle[1:], work[1:], errors[:, 1:]
    return Curve(
        work,
        middle,
        np.sqrt((errors**2).mean(axis=0)),
        errors.min(axis=0),
        errors.max(axis=0),
        resolution,
    )


def start_up(row: dict) -> float:
    """Time of a program that is no computing. [s]"""
    shortest = float(np.median(np.array(row["seconds"])[:, 0]))
    return max(row["first_seconds"] - shortest, 0.0) if row["is_ours"] else shortest


def seconds_to(curve: Curve, target: float) -> Figure:
    """Time to a relative error: where a line through errors near it, over work, meets it. [s]"""
    met = np.flatnonzero(curve.errors > target)
    first = int(met[-1]) + 1 if len(met) else 0
    if first == len(curve.errors):
        return Figure(float(curve.seconds[-1]), ">")
    if first == 0:
        return Figure(float(curve.seconds[0]), "<")
    near = np.abs(np.log(curve.errors / target)) <= math.log(DECADE)
    near[[first - 1, first]] = True
    x, y = np.log(curve.work), np.log(curve.errors)
    slope, start = np.polyfit(x[near], y[near], 1)
    ends = x[max(first - 2, 0)], x[min(first + 1, len(x) - 1)]
    place = np.clip((math.log(target) - start) / slope if slope < 0.0 else x[first], *ends)
    seconds = float(np.exp(np.interp(place, x, np.log(curve.seconds))))
    return Figure(seconds, "<" if seconds <= curve.resolution else "")


def ratio_to(ours: dict, other: dict, target: float) -> Figure:
    """Time of another program to a relative error over ours."""
    made = _log_ratio(ours, other, target)
    if made.bound == "?":
        return made
    spread = None
    if not made.bound:
        spread = _jackknife(ours, lambda rounds: _log_ratio(ours, other, target, rounds))
    if spread is not None:
        spread = max(spread, LEAST_SPREAD)
    return Figure(math.exp(made.value), made.bound, spread)


def tell_ratio(figure: Figure) -> str:
    """Return a ratio as text, with its spread as a factor."""
    if figure.bound == "?":
        return "-"
    told = f"x {figure.bound} {figure.value:.2g}".replace("  ", " ")
    return told if figure.spread is None else f"{told} ×/÷ {math.exp(figure.spread):.2f}"


def _log_ratio(ours: dict, other: dict, target: float, rounds=None) -> Figure:
    a = seconds_to(make_curve(other, rounds), target)
    b = seconds_to(make_curve(ours, rounds), target)
    mirrored = {"<": ">", ">": "<", "": ""}[b.bound]
    bound = a.bound or mirrored
    if a.bound and mirrored and a.bound != mirrored:
        bound = "?"
    return Figure(math.log(a.value / b.value), bound)


def slope_of(row: dict) -> Figure:
    """Exponent of the error in the work, over runs whose time can be told from start-up."""

    def fit(rounds=None) -> Figure:
        curve = make_curve(row, rounds)
        low, high = SLOPE_RANGE
        chosen = (curve.errors >= low) & (curve.errors <= high) & curve.is_timed
        if chosen.sum() < 3:
            return Figure(math.nan, "?")
        x, y = np.log(curve.work[chosen]), np.log(curve.errors[chosen])
        return Figure(float(np.polyfit(x, y, 1)[0]))

    made = fit()
    return made if made.bound else Figure(made.value, "", _jackknife(row, fit))


def honesty_of(row: dict) -> Figure:
    """Root mean square of the true error over that of the stated one, all amounts of work alike."""

    def compare(rounds=None) -> Figure:
        chosen = slice(None) if rounds is None else rounds
        true, stated = (np.array(row[name])[chosen] ** 2 for name in ("errors", "stated"))
        return Figure(float(np.sqrt((true.mean(axis=0) / stated.mean(axis=0)).mean())))

    return Figure(compare().value, "", _jackknife(row, compare))


def _jackknife(row: dict, figure: Callable) -> float | None:
    """Half of the 99 % interval of a figure, from leaving out one round after the other."""
    count = len(row["seconds"])
    if count < 2:
        return None
    parts = [figure([k for k in range(count) if k != left]) for left in range(count)]
    if any(part.bound for part in parts):
        return None
    values = np.array([part.value for part in parts])
    variance = (count - 1) / count * ((values - values.mean()) ** 2).sum()
    return t_quantile(0.995, count - 1) * math.sqrt(variance)


# ---- the whole result ----

TARGETS = (0.01, 0.003, 0.001)
"""Relative errors to which times are compared."""


def ratios_of(result: dict) -> dict[str, Figure]:
    """Ratios of all times to those of our first way, by scene, program and target."""
    made = {}
    for scene in result["scenes"]:
        ours, *others = scene["programs"].items()
        for name, row in others:
            if "refusal" in row:
                continue
            for target in TARGETS:
                made[f"{scene['key']}, {name}, {100 * target:g} %"] = ratio_to(ours[1], row, target)
    return made


@dataclass(frozen=True)
class Comparison:
    """One ratio in two results; ``factor``: between them; ``allowed``: what their spreads allow."""

    name: str
    before: float
    after: float
    factor: float
    allowed: float

    @property
    def passes(self) -> bool:
        """Whether the two agree within their spreads."""
        return self.factor <= self.allowed


def compare_results(before: dict, after: dict) -> list[Comparison]:
    """Compare the ratios of two results that both have."""
    old, new = ratios_of(before), ratios_of(after)
    rows = []
    for name in old:
        a, b = old[name], new.get(name)
        if b is None or a.spread is None or b.spread is None:
            continue
        factor = math.exp(abs(math.log(a.value / b.value)))
        allowed = math.exp(math.hypot(a.spread, b.spread))
        rows.append(Comparison(name, a.value, b.value, factor, allowed))
    return rows
