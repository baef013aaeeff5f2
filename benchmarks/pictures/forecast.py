"""How good the forecast is of the time that a picture still takes."""

import math
from dataclasses import replace

from ...engine.accuracy.stopping import StopRule
from .programs import OURS, Lumenray
from .scenes import PictureScene, resize

ROUNDS = 3

TAKEN_AT = 0.1
"""Share of the time after which the forecast is taken."""

SHRINK = 4
"""By which these pictures are narrower and lower: a tenth of the time has to hold enough samples for a forecast."""

TRIAL = 64
"""Samples per pixel of the run that tells how long others take."""

LONGER = (2.0, 16.0)
"""Least and most that the others are longer than that."""

SHARE = 1.0 / 8.0
"""Of the budget that each of them may take."""

FIRST_SEED = 700_000


def measure_forecasts(scene: PictureScene, budget: float, say) -> list[dict]:
    """Render a small picture of a scene down to an error.

    Returns
    -------
    list of dict    See `judge_forecast`, with ``target`` [-].
    """
    rows = _follow(scene, budget)
    told = ", ".join("none" if each["share"] is None else f"x {each['share']:.2f}" for each in rows)
    say(f"forecast over true time: {told}")
    return rows


def _follow(scene: PictureScene, budget: float) -> list[dict]:
    camera = scene.camera
    small = (max(camera.width // SHRINK, 1), max(camera.height // SHRINK, 1))
    ours = Lumenray(replace(scene, camera=resize(camera, small)), OURS)
    # The first one makes kernels.
    trial = min(
        (ours.render(TRIAL, FIRST_SEED + k) for k in range(2)), key=lambda made: made.seconds
    )
    longer = min(max(SHARE * budget / trial.seconds, LONGER[0]), LONGER[1])
    target = trial.stated / math.sqrt(longer)
    rows = []
    for number in range(2, ROUNDS + 2):
        states: list[tuple[float, float]] = []
        made = ours.follow(
            StopRule(error=target), FIRST_SEED + number, lambda *state, to=states: to.append(state)
        )
        rows.append({"target": target} | judge_forecast(states, made.seconds))
    return rows


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
