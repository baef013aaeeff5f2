"""Light that comes late: sensors to which it finds its way by more reflections than a simplification's bound allows for."""

from dataclasses import replace

import numpy as np

from ...accuracy.estimate import Estimate
from ...accuracy.stopping import StopRule
from ..paths.illuminance import LANES, Receivers, compute

ENDLESS = 1 << 20
"""Reflections that no light has had."""

GROUPS = 16
"""Independent groups of samples."""

FEWEST, MOST = 1 << 8, 1 << 14
"""Samples of a sensor."""

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
    wider, rows = np.zeros(len(bright.mean)), np.arange(len(bright.mean))
    for late in scene.requirements.late:
        if not len(rows):
            break
        rule = StopRule(samples=int(np.clip(LANES // len(rows), FEWEST, MOST)))
        own = _of(receivers, rows)
        early = compute(scene, own, rule, seed, GROUPS, None, cancelled, late.reflections)
        noise = np.hypot(early.standard_error, bright.standard_error[rows])
        most = (1.0 - late.share) * bright.mean[rows]
        rows = rows[early.mean + SURE * noise < most]
        wider[rows] = late.more
    reached = int((wider > 0.0).sum())
    if not reached:
        return wider, ()
    worst = 100.0 * (scene.requirements.spent + wider.max())
    return wider, (
        f"light reaches {reached} sensors after so many reflections that without wavelengths it could be wrong by "
        f"{worst:.2g} %, which their errors hold: switch 'colours' off to have it right",
    )


def _of(receivers: Receivers, rows: np.ndarray) -> Receivers:
    """Some of the receivers, of one place each."""
    columns = {
        name: getattr(receivers, name)[rows]
        for name in ("positions", "normals", "geometric_normals", "weights")
    }
    return replace(
        receivers, **columns, start=np.arange(len(rows)), count=np.ones(len(rows), np.int64)
    )
