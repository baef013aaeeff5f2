"""A job of the engine in the background of this Blender: its thread, and how it ends.

There is one of a kind at a time. It belongs to the extension and not to the operator that started it, so that it ends
cleanly with the extension, with the file or with Blender.
"""

import bpy
from bpy.app.handlers import persistent

from ...engine.errors import Cancelled
from . import background_work
from .handlers import leave, listen

INTERVAL = 0.2
"""How often the window looks how far it is. [s]"""


class BackgroundJob(background_work.BackgroundJob):
    """A job on a thread of its own; all methods are for Blender's main thread.

    Parameters
    ----------
    job : object    With ``run(session, progress)`` and ``cancel()``.
    session : RemoteSession    An empty one; it is closed at the end.
    name : str    Of the thread, and in the log.
    """

    def __init__(self, job, session, name: str):
        super().__init__(job, session, _running, name, INTERVAL)
        self.name = name

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


_running: list[BackgroundJob] = []


def start(job, session, name: str) -> BackgroundJob:
    """Begin a job."""
    return BackgroundJob(job, session, name).start()


def is_running(name: str) -> bool:
    """Whether a job of a name was begun that has not been taken away yet."""
    return any(each.name == name for each in _running)


def end() -> None:
    """End all jobs, whatever they are at."""
    for each in list(_running):
        each.end(bpy.context)
        # Its operator may hear of it later, when there is nothing of ours left to write to.
        each.error = each.error or Cancelled(
            f"{each.name} ended with its file or with the extension"
        )


@persistent
def _end_with_file(*_):
    end()


_HANDLERS = {"load_pre": _end_with_file}


def attach():
    """Tie jobs to the file."""
    listen(_HANDLERS)


def detach():
    """End jobs for good."""
    leave(_HANDLERS)
    end()
