"""Passes of a bake that were made in several places, joined in the order of their chunks."""

import math

import numpy as np

from ..accuracy.forecast import Forecaster
from ..accuracy.stopping import StopRule
from ..baking.layer_state import LayerState

AREA = "area"
"""Name of what comes with the arrays of a state, see `baking.run.sum_passes`."""

ENDLESS = StopRule(samples=1 << 62)
"""Rule of states whose end others decide."""


class LuxSum:
    """States of all layers of a bake. Even and odd passes of every chunk stay even and odd ones of the whole.

    ``area``: surface in each lumel. (n,) [m2]
    """

    def __init__(self):
        self.layers: list[LayerState] = []
        self.area = np.zeros(0)

    @property
    def samples(self) -> int:
        """Mean number per lumel, so far."""
        return round(sum(state.sums.mean_samples for state in self.layers))

    def add(self, parts: tuple[dict[str, np.ndarray], ...]) -> None:
        """Add the layers of the next chunk."""
        new = [LayerState.from_arrays(ENDLESS, dict(part)) for part in parts]
        if not self.layers:
            self.layers, self.area = new, parts[0][AREA].astype(np.float64)
            return
        for state, more in zip(self.layers, new, strict=True):
            state.join(more)

    def errors(self) -> tuple[float, float]:
        """Standard error of everything: relative to the mean [-], and by itself [lx]."""
        area = max(float(self.area.sum()), 1e-300)
        lit = self.area > 0.0
        light = sum(float(self.area @ state.sums.mean()) for state in self.layers)
        square = sum(float(self.area[lit] @ state.sums.variance()[lit]) for state in self.layers)
        whole = math.sqrt(square / area)
        return (whole * area / light if light > 0.0 else math.inf), whole

    def finished(self, rule: StopRule, seconds: float) -> tuple[LayerState, ...]:
        """States that need no more passes. ``seconds``: what all of them took. [s]"""
        relative, whole = self.errors()
        for state in self.layers:
            state.is_done, state.forecaster = True, Forecaster(rule, 0.0)
            state.forecaster.note(seconds, state.sums.mean_samples, relative, whole)
        return tuple(self.layers)
