"""The year that is computed in the background of this Blender; there is one at a time."""

from ..foundation import background_job
from .job import YearJob

NAME = "daylight year"
"""Of the job."""


def start(job: YearJob, session) -> background_job.BackgroundJob:
    """Begin a year in an empty session, which is closed at the end."""
    return background_job.start(job, session, NAME)


def is_running() -> bool:
    """Whether a year was begun that has not been taken away yet."""
    return background_job.is_running(NAME)
