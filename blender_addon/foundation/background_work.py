"""Work that goes on in the background of this Blender: its thread, the window's timer, and how both end.

Work belongs to the extension and not to the operator that started it, so that it ends cleanly with the extension, with the
file or with Blender. Of each kind there is a list of what runs, which has one entry at most.
"""

import logging
import threading

from ...engine.errors import LumenrayError
from ...imports import loaded_when_used

with loaded_when_used():
    from ...engine.accuracy import stopping

log = logging.getLogger(__name__)


class BackgroundWork:
    """Work on a thread of its own; all methods but `_work` are for Blender's main thread.

    Kinds give `_work`, which runs on the thread, and `ask_to_end`, which makes it return soon.

    Parameters
    ----------
    running : list    What runs of this kind; the work is in it until it has been taken away.
    name : str    Of the thread.
    interval : float    How often the window wakes up. [s]
    has_bar : bool    Whether Blender shows how far it is at the mouse.
    """

    def __init__(self, running: list, name: str, interval: float, has_bar: bool = True):
        self._running, self._interval, self._has_bar = running, interval, has_bar
        self._timer = None
        self._thread = threading.Thread(target=self._work, name=f"lumenray {name}", daemon=True)

    def start(self):
        """Begin, and return itself."""
        self._running.append(self)
        self._thread.start()
        return self

    @property
    def is_alive(self) -> bool:
        """Whether it still works."""
        return self._thread.is_alive()

    def ask_to_end(self) -> None:
        """Ask it to end at once."""
        raise NotImplementedError

    def wake(self, window_manager, window) -> None:
        """Have the window wake up from time to time."""
        if self._has_bar:
            window_manager.progress_begin(0, 1000)
        self._timer = window_manager.event_timer_add(self._interval, window=window)

    def leave(self, window_manager) -> bool:
        """End it if it still works, wait for its end, and leave nothing behind.

        Returns
        -------
        bool    False: it was taken away before, and nothing was left to do.
        """
        if self not in self._running:
            return False
        self._running.remove(self)
        if self.is_alive:
            self.ask_to_end()
        self._thread.join()
        if self._timer is not None:
            window_manager.event_timer_remove(self._timer)
            if self._has_bar:
                window_manager.progress_end()
            self._timer = None
        return True

    def _work(self) -> None:
        raise NotImplementedError


class BackgroundJob(BackgroundWork):
    """A job of the engine on a thread of its own.

    Parameters
    ----------
    job : object    With ``run(session, progress)`` and ``cancel()``.
    session : RemoteSession    An empty one; it is closed at the end.
    running, name, interval    As of `BackgroundWork`.
    """

    def __init__(self, job, session, running: list, name: str, interval: float):
        self.job, self.error = job, None
        self._session, self._name = session, name
        self._progress: stopping.Progress | None = None
        super().__init__(running, name, interval)

    def ask_to_end(self) -> None:
        """Cancel the job."""
        self.job.cancel()

    def _work(self) -> None:
        try:
            self.job.run(self._session, self._note)
        except LumenrayError as error:
            self.error = error
        except Exception as error:
            # A fault of ours: the log tells where, the window that it happened.
            log.exception("the %s failed", self._name)
            self.error = error
        finally:
            self._session.close()

    def _note(self, progress: "stopping.Progress") -> None:
        self._progress = progress
