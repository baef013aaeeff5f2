"""Whether a year is what its hours are by themselves, whether its stated errors are right, and what it costs beside an hour.

The year of the room is computed at once, and hours of it each as a scene of its own (`hours`), by code that shares nothing
with the year but the paths' steps. What is told is how far both lie apart in units of the joint stated error, and the bias:
mean of the year over that of the hours, all sensors and hours together.

Metrics are asked for with many seeds, and compared with a run of many more paths: an interval of two sides is to hold the
truth as often as it says. They are judged with as many paths as the command takes by itself; what becomes of the errors
with few paths is told beside it.
"""

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.accuracy.student import t_quantile
from ...engine.daylight.replicated import MetricEstimate
from ...engine.sky.weather import Weather
from .hours import SingleHours, choose_hours
from .ours import YearEngine
from .reach import find_reach
from .room import Room

HOURS = 50
"""Of the year, that are computed by themselves."""

YEAR_SAMPLES, HOUR_SAMPLES = 1 << 14, 1 << 12
"""Paths of every sensor in the comparison of the year with its hours."""

SEEDS = 20

AMOUNTS = (1 << 9, 1 << 13)
"""Paths of every sensor whose metrics are judged: few, and as many as are taken where nothing is said."""

MANY_SAMPLES = 1 << 17
"""Paths of every sensor of what they are judged by."""

PROBABILITY = 0.95
"""Of the intervals that are judged."""

COST_SAMPLES = (1 << 8, 1 << 10, 1 << 12)
"""Paths of every sensor for which a year and an hour are timed."""

COST_HOURS = 3
"""That are timed, of which the mean counts."""

TARGET = 0.02
"""Relative error to which both are timed. [-]"""


def measure_year(
    engine: YearEngine, room: Room, weather: Weather, say=lambda text: None, **sizes
) -> dict:
    """Compare a year with its hours, judge its errors, and time it.

    Parameters
    ----------
    engine : YearEngine
    room : Room
    weather : Weather
    say : callable    Told of every step.
    sizes    Other amounts of work: ``hours``, ``seeds``, ``year_samples``, ``hour_samples``, ``amounts``,
        ``many_samples``, ``cost_samples``.

    Returns
    -------
    dict    ``agreement``, ``coverage`` and ``cost``, as the functions below return them.
    """
    singles = SingleHours(room, weather)
    made = {
        "agreement": compare_hours(
            engine,
            singles,
            weather,
            sizes.get("hours", HOURS),
            sizes.get("year_samples", YEAR_SAMPLES),
            sizes.get("hour_samples", HOUR_SAMPLES),
            say,
        ),
        "coverage": judge_errors(
            engine,
            room,
            weather,
            sizes.get("seeds", SEEDS),
            sizes.get("amounts", AMOUNTS),
            sizes.get("many_samples", MANY_SAMPLES),
            say,
        ),
    }
    made["cost"] = compare_cost(
        engine, singles, weather, sizes.get("cost_samples", COST_SAMPLES), say
    )
    return made


def compare_hours(
    engine: YearEngine,
    singles: SingleHours,
    weather: Weather,
    count,
    year_samples,
    hour_samples,
    say,
) -> dict:
    """Compare hours of a year with the same by themselves.

    Returns
    -------
    dict    ``hours``: how many; ``bias`` and ``bias_error``: mean of the year over that of the hours less 1, and its
        standard error by what is stated; ``within_2``: share of hours and sensors within two joint errors; ``farthest``:
        most joint errors; ``rms``: root mean square of them. [-]
    """
    year = engine.run(singles.room, weather, year_samples, seed=1)
    chosen = choose_hours(weather, count)
    alone = [singles.measure(int(i), StopRule(samples=hour_samples)) for i in chosen]
    values = np.stack([hour.illuminance for hour in alone], axis=1)
    errors = np.stack([hour.errors for hour in alone], axis=1)
    made = compare_values(year.illuminance[:, chosen], year.errors[:, chosen], values, errors)
    say(
        f"year: bias {100 * made['bias']:+.3f} % beside {len(chosen)} hours by themselves, "
        f"{100 * made['within_2']:.1f} % within two joint errors"
    )
    return {"hours": len(chosen), **made}


def compare_values(year, year_errors, hours, hour_errors) -> dict:
    """Compare illuminances (sensors, hours) with their errors; as `compare_hours` without ``hours``."""
    joint = np.hypot(year_errors, hour_errors)
    off = np.abs(year - hours) / np.maximum(joint, 1e-12)
    # Hours of one year share their paths: their errors add up, those of hours by themselves do not.
    of_year = np.sqrt(np.sum(year_errors.mean(axis=1) ** 2)) / len(year)
    of_hours = np.sqrt(np.sum(hour_errors**2)) / hours.size
    mean = hours.mean()
    return {
        "bias": float(year.mean() / mean - 1.0),
        "bias_error": float(np.hypot(of_year, of_hours) / mean),
        "within_2": float(np.mean(off <= 2.0)),
        "rms": float(np.sqrt(np.mean(off**2))),
        "farthest": float(off.max()),
    }


def judge_errors(
    engine: YearEngine, room: Room, weather: Weather, seeds, amounts, many_samples, say
) -> dict:
    """Judge stated errors of metrics.

    Returns
    -------
    dict    ``seeds``, ``amounts``, and in ``metrics`` by name the ``cover``: shares of seeds (and sensors) whose interval of
        95 % holds the truth, by amount, and ``count``: of values that they are of. ``cover`` of all metrics are the means.
        Metrics that no chance is in are left out. [-]
    """
    truth = engine.run(room, weather, many_samples, 1000, has_metrics=True).metrics
    metrics = {
        name: {"cover": [], "count": 0} for name, true in truth.items() if np.isfinite(true.freedom)
    }
    for amount in amounts:
        runs = [
            engine.run(room, weather, amount, 2000 + k, has_metrics=True).metrics
            for k in range(seeds)
        ]
        for name, row in metrics.items():
            hits = [is_held(run[name], truth[name]) for run in runs]
            row["cover"].append(float(np.mean(hits)))
            row["count"] = int(np.size(hits))
            say(f"year: {amount} paths, {name}: {100 * row['cover'][-1]:.1f} % of intervals hold")
    cover = np.mean([row["cover"] for row in metrics.values()], axis=0).tolist()
    return {"seeds": seeds, "amounts": list(amounts), "metrics": metrics, "cover": cover}


def is_held(found: MetricEstimate, true: MetricEstimate) -> np.ndarray:
    """Whether intervals of 95 % hold what is true, whose own error is joined. Array of bool"""
    joint = np.hypot(found.standard_error, true.standard_error)
    reach = t_quantile(0.5 * (1.0 + PROBABILITY), found.freedom) * joint
    # Rounding of single precision, where nothing is random.
    return np.abs(found.value - true.value) <= reach + 1e-6 * np.abs(true.value)


def compare_cost(engine: YearEngine, singles: SingleHours, weather: Weather, samples, say) -> dict:
    """Time a year and hours of it to the same error.

    Returns
    -------
    dict    ``year`` and ``hour``: lists of (seconds, error); ``year_seconds`` and ``hour_seconds``: to `TARGET`, found
        between or beyond them; ``ratio``. Errors are root mean squares of stated errors over the mean, sensor by sensor.
    """
    chosen = choose_hours(weather, COST_HOURS, seed=7)
    # What is compiled only once does not count.
    engine.run(singles.room, weather, samples[0], seed=3)
    singles.measure(int(chosen[0]), StopRule(samples=samples[0]), number=2)
    years, hours = [], []
    for k, amount in enumerate(samples):
        year = engine.run(singles.room, weather, amount, seed=10 + k)
        lit = year.illuminance.any(axis=0)
        years.append((year.seconds, relative_error(year.illuminance[:, lit], year.errors[:, lit])))
        alone = [singles.measure(int(i), StopRule(samples=amount), number=3 + k) for i in chosen]
        values = np.stack([hour.illuminance for hour in alone], axis=1)
        errors = np.stack([hour.errors for hour in alone], axis=1)
        seconds = float(np.mean([hour.seconds for hour in alone]))
        hours.append((seconds, relative_error(values, errors)))
        say(f"year: {amount} paths, {years[-1][0]:.1f} s to {100 * years[-1][1]:.1f} %; an hour {seconds:.1f} s to "
            f"{100 * hours[-1][1]:.1f} %")  # fmt: skip
    of_year, of_hour = (
        find_reach(samples, *zip(*points, strict=True), TARGET, has_floor=False).seconds
        for points in (years, hours)
    )
    return {
        "year": years,
        "hour": hours,
        "year_seconds": of_year,
        "hour_seconds": of_hour,
        "ratio": of_year / of_hour,
    }


def relative_error(values: np.ndarray, errors: np.ndarray) -> float:
    """Root mean square of errors over hours, over the mean of the sensor, as root mean square over sensors. [-]"""
    means = np.maximum(values.mean(axis=1), 1e-12)
    return float(np.sqrt(np.mean((errors**2).mean(axis=1) / means**2)))
