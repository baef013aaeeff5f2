"""The bake that runs in the background of this Blender."""

import bpy
from bpy.app.handlers import persistent

from ...engine.errors import Cancelled
from .. import feedback
from ..foundation.background_work import BackgroundJob
from ..foundation.handlers import leave, listen
from .error_graph import graph

INTERVAL = 0.1
"""How often the window looks how far the bake is. [s]"""


class RunningBake(BackgroundJob):
    """A bake on a thread of its own.

    Parameters
    ----------
    job : bake.BakeJob    Prepared.
    session : RemoteSession    An empty one; it is closed at the end.
    """

    def __init__(self, job, session):
        super().__init__(job, session, _running, "bake", INTERVAL)

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

    def end(self, window_manager) -> None:
        """Cancel it if it still works, wait for its end, and leave nothing behind; a second time nothing is left to do."""
        if self.leave(window_manager):
            window_manager.lumenray.job.running = False


_running: list[RunningBake] = []


def start(job, session, window_manager) -> RunningBake:
    """Begin a bake."""
    graph.note(None)
    made = RunningBake(job, session).start()
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
