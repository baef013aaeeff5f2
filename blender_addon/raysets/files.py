"""Ray files made ready once for all that shine as they say, in the background where Blender's window would wait.

Rays of a large file take half a minute to prepare. In the live view a light joins when its rays are ready; a render or a
bake waits for it.
"""

import threading
from collections import OrderedDict
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from pathlib import Path

from ...engine.errors import Cancelled, FileFormatError, LumenrayError
from ...engine.raysets.cloud import Fluctuation
from ...engine.raysets.emission import RayLight, Wish
from ...engine.raysets.index import obtain_light
from ...engine.raysets.record import LUMINOUS, RADIANT
from ...engine.raysets.text import Assumed
from .settings import absolute_path
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
        self._pool: ThreadPoolExecutor | None = None

    def job(self, settings) -> _Job:
        """Job of the file of settings; it is begun if there is none."""
        path = absolute_path(settings)
        if not path:
            raise NoRayFileError("no ray file is chosen")
        wish = wish_of(settings)
        try:
            found = Path(path).stat()
        except (OSError, ValueError) as error:
            text = getattr(error, "strerror", None) or str(error)
            raise FileFormatError(path, f"cannot be opened ({text})") from None
        key = (path, found.st_size, found.st_mtime_ns, wish)
        with self._lock:
            if key in self._jobs:
                self._jobs.move_to_end(key)
                return self._jobs[key]
            job = self._jobs[key] = _Job()
            if self._pool is None:
                self._pool = ThreadPoolExecutor(1, thread_name_prefix="lumenray-rays")
            job.future = self._pool.submit(_prepare, job, path, wish, settings.keep_index)
            while len(self._jobs) > KEPT:
                self._jobs.popitem(last=False)[1].stop.set()
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

    def clear(self) -> None:
        """Forget all, and stop what is under way."""
        with self._lock:
            for job in self._jobs.values():
                job.stop.set()
            self._jobs.clear()
            if self._pool is not None:
                self._pool.shutdown(wait=False, cancel_futures=True)
                self._pool = None


def _prepare(job: _Job, path: str, wish: Wish, is_kept: bool) -> RayLight:
    def progress(share: float) -> None:
        job.share = share

    return obtain_light(path, wish, is_kept, progress, job.stop.is_set)


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
    """Prepare everything anew when it is asked for."""
    _shelf.clear()


def detach() -> None:
    """Stop everything: the add-on is taken off."""
    _shelf.clear()
