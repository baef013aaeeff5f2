"""Areas whose illuminances are known but for noise that falls with time, as sensors have it."""

import numpy as np

from lumenray.engine.judgement.figures import find_figures
from lumenray.engine.judgement.verdict import LOOKS, State, judge, tail

GROUPS = 16
"""Independent groups of samples, as of sensors."""


class NoisyArea:
    """Readings of sensors after some time, from 1 on.

    Parameters
    ----------
    truth : (n,) array    [lx]
    noise : float    Relative standard error of a sensor after the time 1. [-]
    seed : int
    """

    def __init__(self, truth, noise, seed):
        self._truth, self._noise = np.asarray(truth, float), noise
        self._draw, self._sums, self.time = np.random.default_rng([seed, 7]), 0.0, 0.0
        self.go_on_until(1.0)

    def go_on_until(self, time):
        step = time - self.time
        noise = self._draw.standard_normal((GROUPS, len(self._truth)))
        spread = self._noise * np.sqrt(GROUPS * step)
        self._sums = self._sums + self._truth * (step + spread * noise)
        self.time = time

    def verdict(self, figure, limit):
        means = self._sums / self.time
        errors = means.std(axis=0, ddof=1) / np.sqrt(GROUPS)
        figures = find_figures(means.mean(axis=0), errors, tail(1), GROUPS - 1.0)
        return judge(figure, limit, getattr(figures, figure))

    def look_until_decided(self, figure, limit):
        """State after as many looks as share a probability, each after the time that the one before foretold."""
        for _ in range(LOOKS):
            found = self.verdict(figure, limit)
            if found.state is not State.UNDECIDED or found.more is None:
                break
            self.go_on_until(self.time * (1.0 + found.more))
        return found.state
