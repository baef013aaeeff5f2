"""Ray files made ready once for all that shine as they say, in the background where Blender's window would wait.

Rays of a large file take half a minute to prepare. In the live view a light joins when its rays are ready; a render or a
bake waits for it.
"""

import threading
from collections import OrderedDict
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor

from ...engine.errors import Cancelled, LumenrayError
from ...engine.raysets.cloud import Fluctuation
from ...engine.raysets.emission import RayLight, Wish
from ...engine.raysets.index import obtain_light, save_light, state_of
from ...engine.raysets.record import LUMINOUS, RADIANT
from ...engine.raysets.text import Assumed
from .source import absolute_path
from .watching import watch

KEPT = 16
"""Prepared files that are kept, of 10 MB each at most."""

SYMMETRY = {"AUTO": None, "ON": True, "OFF": False}


class NoRayFileError(LumenrayError):
    """No ray file is chosen."""


class NotReadyError(LumenrayError):
    """A ray file is being prepared."""


def wish_of(settings) -> Wish:
    """How settings ask for their file to be prepared."""
    position = direction = None
    if settings.use_widths:
        position, direction = 1e-3 * settings.width_position, settings.width_direction
    fluctuation = Fluctuation(None, position, direction, SYMMETRY[settings.symmetry])
    return Wish(fluctuation, Assumed(settings.unit, LUMINOUS if settings.is_luminous else RADIANT))


class _Job:
    """A file that is prepared, or has been."""

    def __init__(self):
        self.share = 0.0
        self.stop = threading.Event()
        self.future: Future | None = None
        self.is_told = False


class _Shelf:
    """Prepared files by path, date, size and wish; the latest used last."""

    def __init__(self):
        self._lock = threading.Lock()
        self._jobs: OrderedDict[tuple, _Job] = OrderedDict()
        # What each light asked for last: what no light asks for any more is not gone on with.
        self._wanted: dict[int, tuple] = {}
        self._fresh: set[str] = set()
        self._pool: ThreadPoolExecutor | None = None

    def job(self, settings) -> _Job:
        """Job of the file of settings; it is begun if there is none."""
        path = absolute_path(settings)
        if not path:
            raise NoRayFileError("no ray file is chosen")
        wish = wish_of(settings)
        state = state_of(path, wish)
        key = (path, state[1], state[2], wish)
        owner = settings.id_data.original.session_uid
        with self._lock:
            before = self._wanted.get(owner)
            self._wanted[owner] = key
            if before is not None and before != key and before not in self._wanted.values():
                self._stop(before)
            job = self._jobs.get(key)
            if job is None:
                job = self._jobs[key] = _Job()
                is_fresh = path in self._fresh
                self._fresh.discard(path)
                if self._pool is None:
                    self._pool = ThreadPoolExecutor(1, thread_name_prefix="lumenray-rays")
                job.future = self._pool.submit(
                    _prepare, job, path, wish, settings.keep_index, is_fresh
                )
                self._trim()
            self._jobs.move_to_end(key)
        if not job.is_told:
            watch(self.is_busy, lambda: len(self.finished()))
        return job

    def is_busy(self) -> bool:
        """Whether a file is being prepared."""
        with self._lock:
            return any(not job.future.done() for job in self._jobs.values())

    def finished(self) -> list[_Job]:
        """Jobs that came to an end since the last call."""
        with self._lock:
            found = [job for job in self._jobs.values() if job.future.done() and not job.is_told]
            for job in found:
                job.is_told = True
            return found

    def keep(self, settings) -> None:
        """Write the index of a file that is ready."""
        path, wish = absolute_path(settings), wish_of(settings)
        with self._lock:
            found = [j for k, j in self._jobs.items() if k[0] == path and k[3] == wish]
            ready = [j for j in found if j.future.done() and j.future.exception() is None]
        if ready:
            save_light(path, ready[-1].future.result(), wish)

    def forget(self, path: str) -> None:
        """Prepare a file anew when it is asked for next; who waits for it gets what is under way."""
        with self._lock:
            self._fresh.add(path)
            for key in [key for key in self._jobs if key[0] == path]:
                del self._jobs[key]

    def clear(self) -> None:
        """Forget all, and stop what is under way."""
        with self._lock:
            for job in self._jobs.values():
                job.stop.set()
            self._jobs.clear()
            self._wanted.clear()
            if self._pool is not None:
                self._pool.shutdown(wait=False, cancel_futures=True)
                self._pool = None

    def _stop(self, key: tuple) -> None:
        job = self._jobs.get(key)
        if job is not None and not job.future.done():
            job.stop.set()
            del self._jobs[key]

    def _trim(self) -> None:
        """Let go of the oldest that are done; those under way are never many."""
        done = [key for key, job in self._jobs.items() if job.future.done()]
        for key in done[: max(len(self._jobs) - KEPT, 0)]:
            del self._jobs[key]


def _prepare(job: _Job, path: str, wish: Wish, is_kept: bool, is_fresh: bool) -> RayLight:
    def progress(share: float) -> None:
        job.share = share

    try:
        return obtain_light(path, wish, is_kept, is_fresh, progress, job.stop.is_set)
    except LumenrayError:
        raise
    except Exception as error:
        # Whoever asks for the light shows the sentence; a panel or a view must not fail of it.
        raise LumenrayError(
            f"its rays cannot be prepared ({type(error).__name__}: {error})"
        ) from error


_shelf = _Shelf()


def obtain(settings, is_patient: bool = True) -> RayLight:
    """Return the light of the file that settings choose; cheap once it is ready.

    Parameters
    ----------
    settings : LumenrayRaysetSettings
    is_patient : bool    Whether to wait for it.

    Raises
    ------
    NoRayFileError    None is chosen.
    NotReadyError    It is not ready yet.
    FileFormatError    It cannot be read.
    """
    job = _shelf.job(settings)
    if not is_patient and not job.future.done():
        raise NotReadyError(f"its rays are being prepared ({100.0 * job.share:.0f} %)")
    try:
        return job.future.result()
    except LumenrayError as error:
        if isinstance(error, Cancelled):
            raise NotReadyError("its rays were not prepared: stopped") from None
        raise error.with_traceback(None) from None
    except CancelledError:
        raise NotReadyError("its rays were not prepared: stopped") from None


def share_of(settings) -> float | None:
    """Share of the preparation that is done while it is under way, else None."""
    try:
        job = _shelf.job(settings)
    except LumenrayError:
        return None
    return None if job.future.done() else job.share


def forget(settings) -> None:
    """Prepare the file of settings anew when it is asked for next."""
    _shelf.forget(absolute_path(settings))


def keep(settings) -> None:
    """Write what is known of the file of settings beside it.

    Raises
    ------
    FileFormatError    It cannot be written.
    """
    _shelf.keep(settings)


def detach() -> None:
    """Stop everything: the add-on is taken off."""
    _shelf.clear()
