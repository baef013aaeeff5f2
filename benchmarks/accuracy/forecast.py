"""How good the forecast of the time is that a job still takes."""

import numpy as np

from .programs import Lumenray
from .scenes import ExactScene
from .statistics import make_curve

ROUNDS = 6

LENGTH = 2.0
"""Time of the jobs over that of the longest runs."""

TAKEN_AT = 0.1
"""Share of the work after which the forecast of the rest is taken."""


def measure_forecasts(scene: ExactScene, ours: Lumenray, row: dict, longest: float) -> list[dict]:
    """Compare forecasts of the time to a relative standard error with what it took.

    Parameters
    ----------
    scene : ExactScene
    ours : Lumenray
    row : dict    What `programs.measure_scene` has of it; tells which error takes how long.
    longest : float    [s]

    Returns
    -------
    list of dict    ``target`` [-], ``seconds``: all together, ``share``: of it when the forecast was taken, ``left`` and
        ``forecast``: time from then on, true and as forecast [s]; None: there was none before the end.
    """
    target = _error_after(ours.run(scene, row["work"][-1], -1), row, LENGTH * longest)
    rows = []
    for number in range(ROUNDS):
        states = []
        ours.run(scene, 0, number, progress=states.append, error=target)
        whole = states[-1].seconds
        made = {"target": target, "seconds": whole, "share": None, "left": None, "forecast": None}
        for state in states[:-1]:
            if state.seconds_left is not None and state.seconds >= TAKEN_AT * whole:
                made["share"] = state.seconds / whole
                made["left"] = whole - state.seconds
                made["forecast"] = state.seconds_left
                break
        rows.append(made)
    return rows


def _error_after(last, row: dict, seconds: float) -> float:
    """Relative standard error, as stopping rules mean it, that a time should give."""
    curve = make_curve(row)
    slope = np.polyfit(np.log(curve.work[-4:]), np.log(curve.errors[-4:]), 1)[0]
    error = np.sqrt(np.mean(last.stated**2)) / np.mean(last.values)
    return float(error * (seconds / curve.seconds[-1]) ** min(slope, -0.25))
