"""Which hours of a year count: those of a schedule by the clocks of a place, and their daylight saving time."""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..sky.place import to_local

EVERY_DAY = (0, 1, 2, 3, 4, 5, 6)
WORKDAYS = (0, 1, 2, 3, 4)
"""Days of the week, Monday first."""


@dataclass(frozen=True)
class Schedule:
    """When people are there.

    Parameters
    ----------
    start, end : float    By the clocks, 0 to 24, the end after the start. [h]
    days : tuple of int    Of the week, 0 is Monday.
    """

    start: float = 8.0
    end: float = 18.0
    days: tuple[int, ...] = EVERY_DAY


@dataclass(frozen=True, eq=False)
class CountedHours:
    """Hours that count, where illuminances are known of those alone that have light.

    Parameters
    ----------
    lit : (h,) bool array    Which of the hours with light count.
    dark : int    Hours without any light that count besides.
    interval : float    What an hour lasts: less where the weather has shorter intervals. [h]
    """

    lit: np.ndarray
    dark: int = 0
    interval: float = 1.0

    @property
    def count(self) -> int:
        """How many count."""
        return int(np.count_nonzero(self.lit)) + self.dark

    @classmethod
    def of_year(cls, counts, lit, interval: float = 1.0) -> "CountedHours":
        """Return the hours that count.

        Parameters
        ----------
        counts : (n,) bool array    Which hours of the year count.
        lit : (h,) int array    Which of them have light, in the order of the illuminances.
        interval : float    [h]
        """
        counts, lit = np.asarray(counts, dtype=bool), np.asarray(lit, dtype=np.int64)
        of_lit = counts[lit]
        return cls(of_lit, int(np.count_nonzero(counts)) - int(np.count_nonzero(of_lit)), interval)


def occupied_hours(times, zone: str, schedule: Schedule | None = None) -> np.ndarray:
    """Return which intervals of a year lie within a schedule.

    Parameters
    ----------
    times : (n,) array    Middles of the intervals, universal time since 1970, as `weather.find_middles` gives them. [s]
    zone : str    Of the place's clocks, such as ``Europe/Berlin``; one with a fixed offset has no daylight saving time.
    schedule : Schedule or None    None: 8 to 18 h of every day.

    Returns
    -------
    (n,) bool array

    Raises
    ------
    SceneError    The zone is not known, or the schedule is none.
    """
    schedule = schedule or Schedule()
    if not (0.0 <= schedule.start < schedule.end <= 24.0):
        raise SceneError(
            f"people are there from {schedule.start:g} to {schedule.end:g} h, expected 0 to 24 and the end after the start"
        )
    if not schedule.days or not set(schedule.days) <= set(EVERY_DAY):
        raise SceneError(
            f"the days of the schedule are {schedule.days}, expected numbers of 0 (Monday) to 6"
        )
    clocks = [to_local(time, zone) for time in np.asarray(times, dtype=np.float64)]
    hour = np.array([c.hour + c.minute / 60.0 + c.second / 3600.0 for c in clocks])
    day = np.array([c.weekday() for c in clocks])
    return (hour >= schedule.start) & (hour < schedule.end) & np.isin(day, schedule.days)
