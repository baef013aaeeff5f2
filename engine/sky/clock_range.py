"""Stretches of the year and of the day that may run over their ends, such as October to March, or 22 to 6 h."""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError

WHOLE_YEAR, WHOLE_DAY = (1, 12), (0.0, 24.0)
"""First and last month, and first and last hour."""


@dataclass(frozen=True)
class ClockRange:
    """Months, and hours of each day in them.

    Parameters
    ----------
    months : (int, int)    First and last, both with all their days; the last may be the earlier one: October to March.
    hours : (float, float)    Start and end, 0 to 24; the end may be the earlier one: over midnight. [h]

    Raises
    ------
    SceneError    A month or an hour is none, or the day's stretch has no length.
    """

    months: tuple[int, int] = WHOLE_YEAR
    hours: tuple[float, float] = WHOLE_DAY

    def __post_init__(self):
        """Refuse what is no stretch."""
        first, last = self.months
        if not (1 <= first <= 12 and 1 <= last <= 12):
            raise SceneError(f"the months are {first} to {last}, expected numbers of 1 to 12")
        start, end = self.hours
        if not (0.0 <= start <= 24.0 and 0.0 <= end <= 24.0) or start == end:
            raise SceneError(
                f"the hours are {start:g} to {end:g}, expected two different ones of 0 to 24"
            )

    @property
    def words(self) -> str:
        """The stretch in a few words."""
        first, last = self.months
        months = f"month {first}" if first == last else f"months {first} to {last}"
        return f"{months}, {self.hours[0]:g} to {self.hours[1]:g} h"

    def holds(self, month, hour) -> np.ndarray:
        """Return which moments lie within.

        Parameters
        ----------
        month : (n,) int array    1 to 12.
        hour : (n,) array    Of the day. [h]

        Returns
        -------
        (n,) bool array    The start is within, the end is not.
        """
        month, hour = np.asarray(month), np.asarray(hour, dtype=np.float64)
        first, last = self.months
        start, end = self.hours
        after, before = month >= first, month <= last
        in_year = after & before if first <= last else after | before
        after, before = hour >= start, hour < end
        in_day = after & before if start < end else after | before
        return in_year & in_day
