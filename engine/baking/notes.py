"""What people are told of a bake: how far it is, what was decided, and what is not as ordered."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from ..accuracy.stopping import Progress
from .order import Departure


@dataclass
class Notes:
    """Told on the way, and kept for the result.

    Parameters
    ----------
    progress : callable or None    Gets a `Progress`.
    departures : list of Departure
    decisions : list of str
    start : float    When the bake began, by `time.perf_counter`. [s]
    """

    progress: Callable | None = None
    departures: list[Departure] = field(default_factory=list)
    decisions: list[str] = field(default_factory=list)
    start: float = field(default_factory=time.perf_counter)
    _done: float = 0.0

    def report(self, state: Progress) -> None:
        """Tell how far things are. Forecasts go up and down; what people see goes up."""
        if self.progress is not None:
            self._done = max(self._done, state.done)
            self.progress(replace(state, done=self._done))

    def name_stage(self, stage: str, done: float = 0.0, samples: int = 0) -> None:
        """Tell what is done now, of which no passes tell how far it is."""
        seconds = time.perf_counter() - self.start
        self.report(Progress(done, samples, float("inf"), seconds, None, stage))

    def depart(self, name: str, message: str, remedy: str, is_error: bool = False) -> None:
        """Note what is not as ordered, see `Departure`."""
        self.departures.append(Departure(name, message, remedy, is_error))
