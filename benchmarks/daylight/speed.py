"""Speed against error of a year: Radiance's two-phase chain and our engine, in one run.

The error of a year is the root mean square over its lit hours of what a sensor's illuminance is off, over the sensor's mean,
and of that the root mean square over sensors. Two things are told of every setting. Its noise, from two runs with other
random choices: half of the mean square between them. And its whole error, noise and what the method leaves out, against
hours that were computed by themselves. These are computed twice, and the two differences of a year from them are multiplied
with each other, so that their own noise does not count.

Times are those of the processors. What is compared is the time to `TARGET`, between runs or beyond them, as `reach` finds
it.
"""

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.sky.weather import Weather
from .hours import SingleHours, choose_hours
from .ours import YearEngine
from .reach import find_reach
from .room import Room
from .two_phase import Settings, run_suns, run_two_phase

TARGET = 0.02
"""Error to which times are compared. [-]"""

CHAINS = {
    "MF 1": (1, False),
    "MF 2": (2, False),
    "MF 4": (4, False),
    "MF 4, exact sun": (4, True),
}
"""Division of the patches, and whether the sun is asked for itself."""

DIVISIONS = (4000, 16000, 64000)
"""Rays from each sensor. Rays of less weight than one of these are ended by chance: no other choice gave less error in the
same time."""

BOUNCES = 6

SAMPLES = (1 << 8, 1 << 10, 1 << 12, 1 << 14)
"""Paths of every sensor of ours."""

OURS = "Lumenray"

HOURS = 24
"""That are computed by themselves."""

TRUE_SAMPLES = 1 << 13
"""Paths of every sensor in each of the two runs of such an hour."""


def measure_speed(
    engine: YearEngine,
    room: Room,
    weather: Weather,
    say=lambda text: None,
    keep=None,
    earlier: dict | None = None,
    **sizes,
) -> dict:
    """Race.

    Parameters
    ----------
    engine : YearEngine
    room : Room
    weather : Weather
    say : callable    Told of every run.
    keep : callable or None    Given what there is after every run.
    earlier : dict or None    What an earlier call kept; its runs are not made again.
    sizes    Other amounts of work: ``divisions``, ``samples``, ``hours``, ``true_samples``, ``chains``.

    Returns
    -------
    dict    ``truth``: ``hours`` and ``values`` (2, sensors, hours); ``runs`` by program: rows with ``work`` in words,
        its ``amount``, ``seconds``, ``noise`` and ``error``; ``sun_seconds``: of Radiance's exact sun by itself.
    """
    made = dict(earlier or {})
    made.setdefault("runs", {})

    def done() -> None:
        if keep is not None:
            keep(made)

    if "truth" not in made:
        made["truth"] = find_truth(
            room, weather, sizes.get("hours", HOURS), sizes.get("true_samples", TRUE_SAMPLES), say
        )
        done()
    for name in sizes.get("chains", CHAINS):
        factor, has_exact_sun = CHAINS[name]
        for divisions in sizes.get("divisions", DIVISIONS):
            settings = Settings(divisions, BOUNCES, 1.0 / divisions, factor, has_exact_sun)

            def run(number: int, settings=settings):
                made = run_two_phase(room, weather, settings.again() if number else settings)
                return made.illuminance, made.total, made.seconds

            _add(made, name, settings.words, divisions, run, say)
            done()
    if "sun_seconds" not in made:
        made["sun_seconds"] = run_suns(room, weather).total
        done()
    amounts = sizes.get("samples", SAMPLES)
    if amounts:
        # What is compiled only once does not count.
        engine.run(room, weather, min(amounts), seed=50)
    for samples in amounts:

        def run(number: int, samples=samples):
            made = engine.run(room, weather, samples, seed=60 + number)
            return made.illuminance, made.seconds, {}

        _add(made, OURS, f"{samples} paths", samples, run, say)
        done()
    return made


def _add(made: dict, name: str, work: str, amount: int, run, say) -> None:
    """Make two runs and add their row, unless it is there."""
    rows = made["runs"].setdefault(name, [])
    if any(row["work"] == work for row in rows):
        return
    first, seconds, parts = run(0)
    second, more, _ = run(1)
    truth = made["truth"]
    true, hours = np.array(truth["values"]), np.array(truth["hours"])
    row = {
        "work": work,
        "amount": amount,
        "seconds": 0.5 * (seconds + more),
        "parts": {key: round(value, 3) for key, value in parts.items()},
        "noise": noise_of(first, second),
        "error": error_of(first[:, hours], *true),
    }
    rows.append(row)
    say(f"speed: {name}, {work}: {row['seconds']:.2f} s, noise {100 * row['noise']:.2f} %, "
        f"error {100 * row['error']:.2f} %")  # fmt: skip


def find_truth(room: Room, weather: Weather, count: int, samples: int, say) -> dict:
    """Compute hours by themselves, twice. ``hours`` (k,) and ``values`` (2, sensors, k) as lists."""
    chosen = choose_hours(weather, count, seed=11)
    singles, values = SingleHours(room, weather), []
    for number in (20, 21):
        alone = [singles.measure(int(i), StopRule(samples=samples), number) for i in chosen]
        values.append(np.stack([hour.illuminance for hour in alone], axis=1))
    say(f"speed: {len(chosen)} hours by themselves differ by {100 * noise_of(*values):.2f} %")
    return {"hours": chosen.tolist(), "values": np.round(values, 3).tolist()}


def noise_of(first: np.ndarray, second: np.ndarray) -> float:
    """Error of one of two runs (sensors, hours) by their difference. [-]"""
    lit = (first + second).any(axis=0)
    means = np.maximum(0.5 * (first + second)[:, lit].mean(axis=1), 1e-12)
    square = 0.5 * ((first - second)[:, lit] ** 2).mean(axis=1)
    return float(np.sqrt(np.mean(square / means**2)))


def error_of(values: np.ndarray, first: np.ndarray, second: np.ndarray) -> float:
    """Error of illuminances (sensors, hours) against two independent runs of what is true. [-]

    Its square has no bias, and may fall below 0 by chance where it is small: then 0 stands for it.
    """
    means = np.maximum(0.5 * (first + second).mean(axis=1), 1e-12)
    square = ((values - first) * (values - second)).mean(axis=1)
    return float(np.sqrt(max(np.mean(square / means**2), 0.0)))


def find_times(made: dict) -> dict:
    """Times to `TARGET` by program.

    Returns
    -------
    dict    By name ``noise`` and ``error``: seconds and how they are known, as of `Reach`; None where the error does not
        come down to it.
    """
    found = {}
    for name, rows in made["runs"].items():
        found[name] = {}
        for kind in ("noise", "error"):
            columns = ([row[key] for row in rows] for key in ("amount", "seconds", kind))
            reach = find_reach(*columns, TARGET, has_floor=kind == "error")
            found[name][kind] = reach and {
                "seconds": reach.seconds,
                "bound": reach.bound,
                "beyond": reach.is_thought_on,
            }
    return found


def speedup(made: dict) -> tuple[float, str, str] | None:
    """How many times as long the fastest of Radiance's chains takes as our engine, its name, and by which error.

    By the whole error if any of the chains comes down to the target with it; else by the noise alone, as if the chain left
    nothing out.
    """
    times = find_times(made)
    ours = times.pop(OURS, None)
    for kind in ("error", "noise"):
        own = ours and ours[kind]
        chains = {name: row[kind]["seconds"] for name, row in times.items() if row[kind]}
        if own and chains:
            name = min(chains, key=chains.get)
            return chains[name] / own["seconds"], name, kind
    return None
