"""Values of light groups added up at levels that change one by one, as sliders do: only what has changed is added."""

import numpy as np


class GroupSum:
    """Sum of groups and its standard error.

    Parameters
    ----------
    values, errors : (g, n) float32 array    By group, at its own flux. They are kept, and must not change.

    Notes
    -----
    Light adds up, and errors of groups are independent, so that their squares do. Sums are kept in double precision: a level
    that changes a million times leaves no more behind than the last digit of what was written.
    """

    def __init__(self, values: np.ndarray, errors: np.ndarray):
        self.values = np.ascontiguousarray(values, dtype=np.float32)
        self.errors = np.ascontiguousarray(errors, dtype=np.float32)
        self._levels = np.zeros(len(self.values))
        self._total = np.zeros(self.values.shape[1])
        self._variance = np.zeros(self.values.shape[1])
        self._part = np.empty(self.values.shape[1])

    def set_levels(self, levels) -> None:
        """Let the groups shine at factors on their flux. (g,) [-]"""
        levels = np.asarray(levels, dtype=np.float64)
        for number in np.flatnonzero(levels != self._levels):
            before, now = self._levels[number], levels[number]
            np.multiply(self.values[number], now - before, out=self._part, dtype=np.float64)
            self._total += self._part
            np.square(self.errors[number], out=self._part, dtype=np.float64)
            self._part *= now**2 - before**2
            self._variance += self._part
        self._levels = levels.copy()
        if not levels.any():
            # Nothing is left but rounding.
            self._total[:], self._variance[:] = 0.0, 0.0

    @property
    def total(self) -> np.ndarray:
        """The sum, which the next call of `set_levels` changes. (n,) float64"""
        return self._total

    @property
    def error(self) -> np.ndarray:
        """Standard error of the sum. (n,) float64"""
        return np.sqrt(np.maximum(self._variance, 0.0))

    def describe(self) -> tuple[float, float, float]:
        """Mean, least and largest value of the sum."""
        return float(self._total.mean()), float(self._total.min()), float(self._total.max())
