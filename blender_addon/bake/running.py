"""The bake that runs in the background of this Blender: its thread, and how it ends.

There is one at a time. It belongs to the extension and not to the operator that started it, so that it ends cleanly with
the extension, with the file or with Blender.
"""

import logging
import threading

import bpy
from bpy.app.handlers import persistent

from ...engine.accuracy.stopping import Progress
from ...engine.errors import Cancelled, LumenrayError
from .. import feedback
from ..foundation.handlers import leave, listen
from .error_graph import graph

INTERVAL = 0.1
"""How often the window looks how far the bake is. [s]"""

log = logging.getLogger(__name__)


class RunningBake:
    """A bake on a thread of its own; all methods are for Blender's main thread.

    Parameters
    ----------
    job : bake.BakeJob    Prepared.
    session : RemoteSession    An empty one; it is closed at the end.
    """

    def __init__(self, job, session):
        self.job, self.error = job, None
        self._session = session
        self._progress: Progress | None = None
        self._timer = None
        self._thread = threading.Thread(target=self._work, name="lumenray bake", daemon=True)
        self._thread.start()

    @property
    def is_alive(self) -> bool:
        """Whether it still works."""
        return self._thread.is_alive()

    def show(self, window_manager) -> None:
        """Show how far it is, until it is taken away."""
        progress = self._progress
        if progress is None or self not in _running:
            return
        feedback.show_progress(window_manager, progress)
        if self._timer is not None:
            window_manager.progress_update(int(progress.done * 1000))
        if progress.history is not None:
            graph.note(progress.history)

    def begin_signals(self, window_manager, window) -> None:
        """Have the window wake up from time to time, and show that something is going on."""
        window_manager.progress_begin(0, 1000)
        self._timer = window_manager.event_timer_add(INTERVAL, window=window)

    def end(self, window_manager) -> None:
        """Cancel it if it still works, wait for its end, and leave nothing behind; a second time nothing is left to do."""
        if self not in _running:
            return
        _running.remove(self)
        if self.is_alive:
            self.job.cancel()
        self._thread.join()
        if self._timer is not None:
            window_manager.event_timer_remove(self._timer)
            window_manager.progress_end()
            self._timer = None
        window_manager.lumenray.job.running = False

    def _work(self) -> None:
        try:
            self.job.run(self._session, self._note)
        except LumenrayError as error:
            self.error = error
        except Exception as error:
            # A fault of ours: the log tells where, the window that it happened.
            log.exception("the bake failed")
            self.error = error
        finally:
            self._session.close()

    def _note(self, progress: Progress) -> None:
        self._progress = progress


_running: list[RunningBake] = []


def start(job, session, window_manager) -> RunningBake:
    """Begin a bake."""
    graph.note(None)
    made = RunningBake(job, session)
    _running.append(made)
    feedback.begin_job(window_manager)
    return made


def current() -> RunningBake | None:
    """Return the bake that was begun and not taken away yet."""
    return _running[0] if _running else None


def stop(window_manager) -> None:
    """Ask the bake to end with what it has."""
    if _running:
        _running[0].job.stop()
        window_manager.lumenray.job.is_stopping = True


def cancel() -> None:
    """Ask the bake to end at once."""
    if _running:
        _running[0].job.cancel()


def end() -> None:
    """End the bake, whatever it is at; what it has found by now has no place to go to any more."""
    for bake in list(_running):
        bake.end(bpy.context.window_manager)
        # Its operator may hear of it later, when there is neither our scene nor our window left to write to.
        bake.error = bake.error or Cancelled("the bake ended with its file or with the extension")


@persistent
def _end_with_file(*_):
    end()


_HANDLERS = {"load_pre": _end_with_file}


def attach():
    """Tie the bake to the file; what an earlier life of the extension left in the window is forgotten."""
    listen(_HANDLERS)
    # While Blender starts there is no data to look at, and nothing is left.
    for window_manager in getattr(bpy.data, "window_managers", ()):
        if not _running:
            window_manager.lumenray.property_unset("job")


def detach():
    """End the bake for good."""
    leave(_HANDLERS)
    end()
