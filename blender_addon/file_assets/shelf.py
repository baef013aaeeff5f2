"""Files of one kind read once for all that use them: a key finds a job, and a job becomes a reading.

Small files are read at once. Large ones are read on a thread where Blender's window would wait: panels and the live view go
on without a file that is not ready, a render or a bake waits for it.
"""

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from weakref import WeakSet, WeakValueDictionary

import bpy

from ...engine.errors import LumenrayError
from ..foundation.redraw import redraw
from ..foundation.side_thread import SideThread

TICK = 0.25
"""Between two looks at what is being read. [s]"""


class Job:
    """A file that is being read, or has been.

    Attributes
    ----------
    share : float    Of the work that is done, as far as whoever reads tells it.
    left : float or None    Forecast of the time that it still takes, likewise. [s]
    size : int    What it counts for among what is kept.
    stop : threading.Event    Set when nobody wants it any more.
    future : Future    Of its reading.
    is_told : bool    Whether Blender knows that it came to an end.
    """

    def __init__(self):
        self.share = 0.0
        self.left: float | None = None
        self.size = 1
        self.stop = threading.Event()
        self.future = Future()
        self.is_told = False

    def tell(self, share: float, left: float | None = None) -> None:
        """Note how much of the work is done, and for how long it still goes on if that is known. [s]"""
        self.share, self.left = share, left


class Shelf:
    """Readings of one kind of file, the latest used last. Renders ask for them from threads of their own.

    Parameters
    ----------
    kept : int    Sum of the sizes of jobs that are kept.
    thread : str    Name of the thread that reads; empty: whoever asks first reads at once.
    users : callable    Gives the data-blocks that are told when files become ready.
    """

    def __init__(self, kept: int, thread: str = "", users: Callable = tuple):
        self._kept, self._thread, self._users = kept, thread, users
        self._lock = threading.Lock()
        self._jobs: OrderedDict[tuple, Job] = OrderedDict()
        # On the thread, forgotten ones too.
        self._begun: WeakSet[Job] = WeakSet()
        # What each owner asked for last.
        self._wanted: dict[Hashable, tuple] = {}
        self._contents = WeakValueDictionary()
        self._pool: SideThread | None = None
        self._waiting: list[Callable[[], bool]] = []
        self._shares: list[float] = []
        # Blender knows a timer by the object, and every look at a method makes a new one.
        self.timer = self._take_over

    def job(self, key: tuple, prepare: Callable, owner: Hashable = None) -> Job:
        """Return the job of a key; it is begun if there is none.

        Parameters
        ----------
        key : tuple
        prepare : callable    Called at once if it is begun; returns what reads then, given the job.
        owner : hashable or None    Who asks: what no owner asks for any more is stopped.
        """
        with self._lock:
            if owner is not None:
                self._want(owner, key)
            job = self._jobs.get(key)
            if job is None:
                job = self._begin(prepare())
                self._jobs[key] = job
                self._trim()
            self._jobs.move_to_end(key)
        # Blender's timers are its main thread's; a render waits for the job itself.
        is_main = threading.current_thread() is threading.main_thread()
        if is_main and not (job.is_told or bpy.app.background):
            self._have_told()
        return job

    def ready(self, key: tuple):
        """Return the reading of a key, None if there is none, or not yet."""
        with self._lock:
            job = self._jobs.get(key)
        is_ready = job is not None and job.future.done() and job.future.exception() is None
        return job.future.result() if is_ready else None

    def shared(self, content: Hashable, make: Callable):
        """Return the reading of a content that others use already, or make it; for use while reading."""
        found = self._contents.get(content)
        if found is None:
            found = self._contents[content] = make()
        return found

    def call_when_ready(self, function: Callable[[], bool]) -> None:
        """Call a function on the main thread whenever files became ready, until it returns True."""
        self._waiting.append(function)

    def forget(self, path: str = "") -> None:
        """Have the file of a path, or all, read anew when asked for next; who waits gets what is under way."""
        with self._lock:
            for key in [key for key in self._jobs if not path or path in key]:
                del self._jobs[key]

    def stop(self, key: tuple) -> None:
        """End what is under way for a key; who asks for it is told so until it is dropped."""
        with self._lock:
            job = self._jobs.get(key)
        if job is not None:
            job.stop.set()
            # What has not begun has nobody to look at its stop.
            job.future.cancel()

    def drop(self, key: tuple) -> None:
        """Have what a key stands for read anew when asked for next."""
        with self._lock:
            self._jobs.pop(key, None)

    def close(self) -> None:
        """Forget all, and stop what is under way."""
        with self._lock:
            pool, self._pool = self._pool, None
            for job in self._begun:
                job.stop.set()
            self._jobs.clear()
            self._wanted.clear()
        self._waiting.clear()
        if bpy.app.timers.is_registered(self.timer):
            bpy.app.timers.unregister(self.timer)
        if pool is not None:
            pool.shutdown()
        self._contents.clear()

    def _begin(self, read: Callable) -> Job:
        job = Job()
        if self._thread:
            if self._pool is None:
                self._pool = SideThread(self._thread)
            job.future = self._pool.submit(read, job)
            self._begun.add(job)
            return job
        job.is_told = True
        try:
            job.future.set_result(read(job))
        except LumenrayError as error:
            job.future.set_exception(error)
        return job

    def _have_told(self) -> None:
        if not bpy.app.timers.is_registered(self.timer):
            # Persistent: loading a file does not end what is under way.
            bpy.app.timers.register(self.timer, first_interval=TICK, persistent=True)

    def _want(self, owner, key: tuple) -> None:
        """Note what an owner asks for, and stop what it asked for before if nobody else does."""
        before = self._wanted.get(owner)
        self._wanted[owner] = key
        if before is None or before in self._wanted.values():
            return
        job = self._jobs.get(before)
        if job is not None and not job.future.done():
            job.stop.set()
            del self._jobs[before]

    def _trim(self) -> None:
        """Let go of the oldest that are done; those under way are never many."""
        over = sum(job.size for job in self._jobs.values()) - self._kept
        for key in list(self._jobs)[:-1]:
            if over <= 0:
                break
            if self._jobs[key].future.done():
                over -= self._jobs.pop(key).size

    def _take_over(self) -> float | None:
        """Tell Blender of files that became ready; time until the next look, None after the last. [s]"""
        with self._lock:
            # Asked first, so that what ends meanwhile is told by one more look.
            shares = [job.share for job in self._jobs.values() if not job.future.done()]
            new = [job for job in self._jobs.values() if job.future.done() and not job.is_told]
        for job in new:
            job.is_told = True
        if new:
            self._waiting[:] = [function for function in self._waiting if not function()]
            for user in self._users():
                user.update_tag()
        if new or shares != self._shares:
            redraw("PROPERTIES", "VIEW_3D")
        self._shares = shares
        return TICK if shares else None
