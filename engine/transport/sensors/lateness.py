"""Light that comes late: sensors to which it finds its way by more reflections than a simplification's bound allows for."""

from dataclasses import replace

import numpy as np

from ...accuracy.estimate import Estimate
from ...accuracy.stopping import StopRule
from ..paths.illuminance import Receivers, compute

ENDLESS = 1 << 20
"""Reflections that no light has had."""

GROUPS = 16
"""Independent groups of samples."""

MOST_ASKED = 256
"""Sensors that are asked; others are like the nearest of them. More would cost what simplifications save."""

PATHS, MOST = 1 << 16, 1 << 14
"""Samples of all of them together, and most of one."""

SURE = 3.0
"""Standard errors by which light has to be late."""


def late_bounds(
    scene, receivers: Receivers, bright: Estimate, seed: int, cancelled
) -> tuple[np.ndarray, tuple[str, ...]]:
    """By how much the bounds of simplifications are larger at sensors that light reaches late, and notes on it.

    Parameters
    ----------
    scene : CompiledScene
    receivers : Receivers    Sensors, one place each.
    bright : Estimate    Their illuminance. (n,) [lx]

    Returns
    -------
    (n,) array, tuple of str    Relative. [-]
    """
    count = len(bright.mean)
    # From the darkest to the brightest, as it is dark where light comes late.
    order = np.argsort(bright.mean, kind="stable")
    asked = order[np.unique(np.linspace(0, count - 1, min(count, MOST_ASKED)).astype(int))]
    rows, found = asked, np.zeros(count)
    for late in scene.requirements.late:
        if not len(rows):
            break
        rule = StopRule(samples=min(max(PATHS // len(rows), GROUPS), MOST))
        own = _of(receivers, rows)
        early = compute(scene, own, rule, seed, GROUPS, None, cancelled, late.reflections)
        noise = np.hypot(early.standard_error, bright.standard_error[rows])
        most = (1.0 - late.share) * bright.mean[rows]
        rows = rows[early.mean + SURE * noise < most]
        found[rows] = late.more
    if not found.any():
        return found, ()
    wider = found[asked[_nearest(receivers.positions, receivers.positions[asked])]]
    worst = 100.0 * (scene.requirements.spent + wider.max())
    return wider, (
        f"light reaches {int((wider > 0.0).sum())} sensors after so many reflections that without wavelengths it could be "
        f"wrong by {worst:.2g} %, which their errors hold: switch 'colours' off to have it right",
    )


def _nearest(places: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Which of other places (m, 3) lies nearest to each of some (n, 3). (n,)"""
    square = (others**2).sum(axis=1)
    return np.concatenate(
        [
            (square - 2.0 * part @ others.T).argmin(axis=1)
            for part in np.array_split(places, len(places) // 4096 + 1)
        ]
    )


def _of(receivers: Receivers, rows: np.ndarray) -> Receivers:
    """Some of the receivers, of one place each."""
    names = ("positions", "normals", "geometric_normals", "weights")
    columns = {name: getattr(receivers, name)[rows] for name in names}
    one = np.ones(len(rows), dtype=np.int64)
    return replace(receivers, **columns, start=np.arange(len(rows)), count=one)
