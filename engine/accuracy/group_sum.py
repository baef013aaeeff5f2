"""Values of light groups added up at levels that change one by one, as sliders do: only what has changed is added."""

import numpy as np

BLOCK = 1 << 15
"""Values that are added in one go, so that they stay in the processor's cache."""


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
        # Levels that the variance is of: it is only brought up to date when it is asked for.
        self._known = np.zeros(len(self.values))
        self._total = np.zeros(self.values.shape[1])
        self._variance = np.zeros(self.values.shape[1])
        self._part = np.empty(min(BLOCK, self.values.shape[1]))

    def set_levels(self, levels) -> None:
        """Let the groups shine at factors on their flux. (g,) [-]"""
        levels = np.asarray(levels, dtype=np.float64)
        changes = levels - self._levels
        numbers = np.flatnonzero(changes)
        for first in range(0, len(self._total) if len(numbers) else 0, BLOCK):
            total = self._total[first : first + BLOCK]
            part = self._part[: len(total)]
            for number in numbers:
                own = self.values[number, first : first + BLOCK]
                np.multiply(own, changes[number], out=part, dtype=np.float64)
                total += part
        self._levels = levels.copy()
        if not levels.any():
            # Nothing is left but rounding.
            self._total[:] = 0.0

    @property
    def total(self) -> np.ndarray:
        """The sum, which the next call of `set_levels` changes. (n,) float64"""
        return self._total

    @property
    def error(self) -> np.ndarray:
        """Standard error of the sum. (n,) float64"""
        for number in np.flatnonzero(self._levels != self._known):
            change = self._levels[number] ** 2 - self._known[number] ** 2
            for first in range(0, len(self._variance), BLOCK):
                part = self._part[: len(self._variance) - first]
                own = self.errors[number, first : first + BLOCK]
                np.square(own, out=part, dtype=np.float64)
                part *= change
                self._variance[first : first + BLOCK] += part
        self._known = self._levels.copy()
        if not self._levels.any():
            self._variance[:] = 0.0
        return np.sqrt(np.maximum(self._variance, 0.0))

    def describe(self) -> tuple[float, float, float]:
        """Mean, least and largest value of the sum."""
        return float(self._total.mean()), float(self._total.min()), float(self._total.max())
