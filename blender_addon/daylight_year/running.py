"""The year that is computed in the background of this Blender."""

import bpy
from bpy.app.handlers import persistent

from ...engine.errors import Cancelled
from ..foundation.background_work import BackgroundJob
from ..foundation.handlers import leave, listen
from .job import YearJob

INTERVAL = 0.2
"""How often the window looks how far it is. [s]"""


class RunningYear(BackgroundJob):
    """A year on a thread of its own.

    Parameters
    ----------
    job : YearJob
    session : RemoteSession    An empty one; it is closed at the end.
    """

    def __init__(self, job: YearJob, session):
        super().__init__(job, session, _running, "year", INTERVAL)

    def begin_signals(self, context) -> None:
        """Have the window wake up from time to time."""
        self.wake(context.window_manager, context.window)

    def show(self, context) -> None:
        """Show how far it is in the status bar."""
        progress = self._progress
        if progress is not None:
            context.workspace.status_text_set(f"Lumenray: {progress.text()}; Esc cancels")
            context.window_manager.progress_update(int(progress.done * 1000))

    def end(self, context) -> None:
        """Cancel it if it still works, wait for its end, and leave nothing behind; a second time nothing is left to do."""
        if self.leave(context.window_manager) and context.workspace is not None:
            context.workspace.status_text_set(None)


_running: list[RunningYear] = []


def start(job: YearJob, session) -> RunningYear:
    """Begin a year."""
    return RunningYear(job, session).start()


def is_running() -> bool:
    """Whether a year was begun that has not been taken away yet."""
    return bool(_running)


def end() -> None:
    """End the year, whatever it is at."""
    for year in list(_running):
        year.end(bpy.context)
        # Its operator may hear of it later, when there is nothing of ours left to write to.
        year.error = year.error or Cancelled("the year ended with its file or with the extension")


@persistent
def _end_with_file(*_):
    end()


_HANDLERS = {"load_pre": _end_with_file}


def attach():
    """Tie the year to the file."""
    listen(_HANDLERS)


def detach():
    """End the year for good."""
    leave(_HANDLERS)
    end()
