"""A job of the engine in the background of this Blender: its thread, and how it ends.

There is one of a kind at a time. It belongs to the extension and not to the operator that started it, so that it ends
cleanly with the extension, with the file or with Blender.
"""

import logging
import threading

import bpy
from bpy.app.handlers import persistent

from ...engine.accuracy.stopping import Progress
from ...engine.errors import Cancelled, LumenrayError
from .handlers import leave, listen

INTERVAL = 0.2
"""How often the window looks how far it is. [s]"""

log = logging.getLogger(__name__)


class BackgroundJob:
    """A job on a thread of its own; all methods are for Blender's main thread.

    Parameters
    ----------
    job : object    With ``run(session, progress)`` and ``cancel()``.
    session : RemoteSession    An empty one; it is closed at the end.
    name : str    Of the thread, and in the log.
    """

    def __init__(self, job, session, name: str):
        self.job, self.error, self.name = job, None, name
        self._session, self._timer = session, None
        self._progress: Progress | None = None
        self._thread = threading.Thread(target=self._work, name=f"lumenray {name}", daemon=True)
        self._thread.start()

    @property
    def is_alive(self) -> bool:
        """Whether it still works."""
        return self._thread.is_alive()

    def begin_signals(self, context) -> None:
        """Have the window wake up from time to time."""
        manager = context.window_manager
        manager.progress_begin(0, 1000)
        self._timer = manager.event_timer_add(INTERVAL, window=context.window)

    def show(self, context) -> None:
        """Show how far it is in the status bar."""
        progress = self._progress
        if progress is not None:
            context.workspace.status_text_set(f"Lumenray: {progress.text()}; Esc cancels")
            context.window_manager.progress_update(int(progress.done * 1000))

    def end(self, context) -> None:
        """Cancel it if it still works, wait for its end, and leave nothing behind; a second time nothing is left to do."""
        if self not in _running:
            return
        _running.remove(self)
        if self.is_alive:
            self.job.cancel()
        self._thread.join()
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            context.window_manager.progress_end()
            self._timer = None
            if context.workspace is not None:
                context.workspace.status_text_set(None)

    def _work(self) -> None:
        try:
            self.job.run(self._session, self._note)
        except LumenrayError as error:
            self.error = error
        except Exception as error:
            # A fault of ours: the log tells where, the window that it happened.
            log.exception("%s failed", self.name)
            self.error = error
        finally:
            self._session.close()

    def _note(self, progress: Progress) -> None:
        self._progress = progress


_running: list[BackgroundJob] = []


def start(job, session, name: str) -> BackgroundJob:
    """Begin a job."""
    made = BackgroundJob(job, session, name)
    _running.append(made)
    return made


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
