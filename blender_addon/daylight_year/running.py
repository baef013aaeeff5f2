"""The year that is computed in the background of this Blender; there is one at a time."""

from ..foundation import background_job

NAME = "daylight year"
"""Of the job."""


def is_running() -> bool:
    """Whether a year was begun that has not been taken away yet."""
    return background_job.is_running(NAME)
