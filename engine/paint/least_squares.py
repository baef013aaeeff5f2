"""Bounded least squares from one start, by Levenberg's and Marquardt's steps cut at the bounds.

References
----------
J. J. More: The Levenberg-Marquardt algorithm, implementation and theory, Lecture Notes in Mathematics 630, 1978.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

STEP = 2e-3
"""Of differences, by the range of a variable."""

FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-2, 1e-9, 1e6

ENOUGH = 1e-4
"""Relative gain of a step below which no more are made."""


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a sum of squares is least near a start.

    Parameters
    ----------
    place : (p,) float64 array    Within 0 and 1 each.
    residuals : (r,) float64 array
    slopes : (r, p) float64 array    Of the residuals.
    calls : int
    """

    place: np.ndarray
    residuals: np.ndarray
    slopes: np.ndarray
    calls: int

    @property
    def cost(self) -> float:
        """Sum of the squares."""
        return float(self.residuals @ self.residuals)


def minimise(residuals_at: Callable, start, most_steps: int = 25) -> Minimum:
    """Find the least sum of squares of functions of variables within 0 and 1 each, near a start.

    Parameters
    ----------
    residuals_at : function    (p,) -> (r,)
    start : (p,) array
    """
    place = np.clip(np.asarray(start, np.float64), 0.0, 1.0)
    residuals = residuals_at(place)
    calls, damping = 1, FIRST_DAMPING
    slopes = _slopes(residuals_at, place, residuals)
    calls += len(place)
    for _ in range(most_steps):
        gradient = slopes.T @ residuals
        # What is at a bound and would leave it stays.
        free = ~(((place <= 0.0) & (gradient > 0.0)) | ((place >= 1.0) & (gradient < 0.0)))
        if not free.any():
            break
        square = slopes[:, free].T @ slopes[:, free]
        scale = np.diag(np.maximum(np.diag(square), 1e-12))
        gained = 0.0
        while damping < MOST_DAMPING:
            step = np.zeros(len(place))
            step[free] = -np.linalg.solve(square + damping * scale, gradient[free])
            tried = np.clip(place + step, 0.0, 1.0)
            found = residuals_at(tried)
            calls += 1
            gained = residuals @ residuals - found @ found
            if gained > 0.0:
                damping = max(damping * 0.2, LEAST_DAMPING)
                break
            damping *= 5.0
        if gained <= 0.0:
            break
        is_last = gained <= ENOUGH * (residuals @ residuals)
        place, residuals = tried, found
        slopes = _slopes(residuals_at, place, residuals)
        calls += len(place)
        if is_last:
            break
    return Minimum(place, residuals, slopes, calls)


def _slopes(residuals_at: Callable, place: np.ndarray, residuals: np.ndarray) -> np.ndarray:
    columns = []
    for k in range(len(place)):
        step = STEP if place[k] + STEP <= 1.0 else -STEP
        moved = place.copy()
        moved[k] += step
        columns.append((residuals_at(moved) - residuals) / step)
    return np.stack(columns, axis=1)
