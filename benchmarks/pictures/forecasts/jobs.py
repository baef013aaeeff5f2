"""How good the forecast is of the time that a picture, or a measurement at sensors, still takes."""

import math
from dataclasses import replace

import numpy as np

from ....engine.accuracy.stopping import StopRule
from ..programs import OURS, Lumenray
from ..scenes import PictureScene, resize

TAKEN_AT = 0.1
"""Share of the time after which the forecast is taken."""

SHRINK = 4
"""By which these pictures are narrower and lower: a tenth of the time has to hold enough samples for a forecast."""

TRIAL, SENSOR_TRIAL = 64, 2048
"""Samples per pixel, and per sensor, of the run that tells how long others take."""

LONGER = (2.0, 64.0)
"""Least and most that the first job is longer which tells the error that the others are made to."""

SIZINGS, MOST_CHANGE = 2, 4.0
"""Such jobs, one after the other, and most by which the next one, or the others, are longer or shorter than each. [-]"""

FIRST_SEED = 700_000


def measure_scene(scene: PictureScene, seconds: float, rounds: int, say) -> dict[str, list[dict]]:
    """Render a small picture of a scene, and measure at its sensors, down to errors that take so long, about.

    Returns
    -------
    dict of list of dict    By kind of job: see `judge_forecast`, with ``target`` [-].
    """
    camera = scene.camera
    small = (max(camera.width // SHRINK, 1), max(camera.height // SHRINK, 1))
    ours = Lumenray(replace(scene, camera=resize(camera, small)), OURS)

    def render(rule: StopRule, seed: int, progress) -> tuple[float, float]:
        made = ours.follow(rule, seed, progress)
        return made.stated, made.seconds

    made = {}
    for name, trial, run in (
        ("picture", TRIAL, render),
        ("sensors", SENSOR_TRIAL, Lumenray(scene, OURS).measure),
    ):
        made[name] = _follow(run, trial, seconds, rounds)
        told = [
            "none" if each["share"] is None else f"x {each['share']:.2f}" for each in made[name]
        ]
        say(f"{name}: forecast over true time {', '.join(told)}")
    return made


def _follow(run, samples: int, wanted: float, rounds: int) -> list[dict]:
    """Forecasts of a kind of jobs. ``run(rule, seed, progress)``: does one; returns its error and the seconds."""
    # The first one makes kernels.
    tries = [run(StopRule(samples=samples), FIRST_SEED + k, _ignore) for k in range(2)]
    error, seconds = min(tries, key=lambda each: each[1])
    target = error / math.sqrt(float(np.clip(wanted / seconds, *LONGER)))
    # How the error falls, and what is done once, is known only by jobs as long as the others, about.
    for number in range(SIZINGS):
        _, seconds = run(StopRule(error=target), FIRST_SEED + 2 + number, _ignore)
        change = float(np.clip(wanted / seconds, 1.0 / MOST_CHANGE, MOST_CHANGE))
        target /= math.sqrt(change)
    rows = []
    for number in range(2 + SIZINGS, 2 + SIZINGS + rounds):
        states: list[tuple[float, float]] = []
        _, seconds = run(
            StopRule(error=target), FIRST_SEED + number, lambda *state, to=states: to.append(state)
        )
        rows.append({"target": target} | judge_forecast(states, seconds))
    return rows


def _ignore(*_state) -> None:
    """Hear of a job's progress."""


def judge_forecast(states: list[tuple[float, float]], whole: float) -> dict:
    """Take the first forecast after a share of the time.

    Parameters
    ----------
    states : list of (seconds, seconds_left)
    whole : float    Time that it took. [s]

    Returns
    -------
    dict    ``seconds``: that it took; ``at``: share of it when the forecast was taken, ``share``: the forecast of the whole
        over the whole; None: there was none before the end.
    """
    for seconds, left in states:
        if TAKEN_AT * whole <= seconds < whole:
            return {"seconds": whole, "at": seconds / whole, "share": (seconds + left) / whole}
    return {"seconds": whole, "at": None, "share": None}
