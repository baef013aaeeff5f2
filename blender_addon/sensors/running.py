"""The measurement of sensors in the background of this Blender; there is one at a time."""

from ...imports import loaded_when_used
from ..bake.results import Watch
from ..foundation import background_job
from . import results

with loaded_when_used():
    from . import job as sensor_job

NAME = "measurement"
"""Of the job."""


class Measuring:
    """A measurement under way, and what has changed since it began.

    Parameters
    ----------
    job : SensorJob
    session : RemoteSession    An empty one; it is closed at the end.
    """

    def __init__(self, job: "sensor_job.SensorJob", session):
        self._watch = Watch()
        self.background = background_job.start(job, session, NAME)
        self.job = job

    def end(self, context) -> Exception | None:
        """Take it away, cancelled if it still works, and return what went wrong."""
        self.background.end(context)
        self._changed = self._watch.end()
        return self.background.error

    def store(self) -> list:
        """Keep what was measured, once it has ended well, and return the empties."""
        return results.store(self.job, self._changed)


def is_running() -> bool:
    """Whether a measurement was begun that has not been taken away yet."""
    return background_job.is_running(NAME)
