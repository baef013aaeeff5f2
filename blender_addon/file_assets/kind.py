"""What is done with the file behind a light or a material, whatever its kind: find it, read it once, and tell its state."""

from collections.abc import Callable, Iterable
from concurrent.futures import CancelledError
from dataclasses import dataclass
from typing import Any

import bpy

from ...engine.errors import Cancelled, LumenrayError
from ...engine.reading.content import MAXIMUM_SIZE, read_bytes
from .places import Library, stamp, stored_path
from .shelf import Job, Shelf


class NoFileError(LumenrayError):
    """No file is chosen, or its data-block is missing."""


class NotReadyError(LumenrayError):
    """A file is being read, or that was stopped.

    ``share`` of the work is done, and the rest takes the time ``left``, if it is known. [s]
    """

    share = 0.0
    left: float | None = None
    is_stopped = False


@dataclass(frozen=True, eq=False)
class State:
    """A file at the time of a redraw.

    Parameters
    ----------
    name : str    Of the file, empty if none is chosen.
    notice : str    Where the file is kept, and whether it was edited.
    reading : object or None    None if none is chosen, it is being read, or cannot be used.
    share : float    Of the work that is done while it is being read.
    left : float or None    Forecast of how long the rest takes. [s]
    problem : str    Why it cannot be used, empty if it can.
    is_stopped : bool    Whether it is not there because whoever wanted it stopped it.
    """

    name: str
    notice: str = ""
    reading: Any = None
    share: float = 0.0
    left: float | None = None
    problem: str = ""
    is_stopped: bool = False


class FileKind:
    """A kind of file that settings name by their ``filepath``, and all of its files that were read.

    Each kind says what differs in the attributes and the first methods.

    Parameters
    ----------
    kept : int    Sum of the sizes of the files that are kept as they were read, see `Job`.
    thread : str    Name of the thread that reads them; empty: whoever asks first reads at once.
    """

    noun: str
    """What people call it."""

    library: Library | None = None
    """Files of ours."""

    largest = MAXIMUM_SIZE
    """Of files that are read. [byte]"""

    under_way = "its file is being read"
    stopped = "its file was not read: stopped"
    fault = "it cannot be read ({cause}); please send the file to the developers"
    """Said of a file that is not ready, will not be, or cannot be by a mistake of ours."""

    is_stopped_unwanted = False
    """Whether reading is stopped when those who asked for it want something else."""

    def __init__(self, kept: int, thread: str = ""):
        self._shelf = Shelf(kept, thread, self.users)

    # ---- what differs ----

    def read(self, job: Job, data: bytes, path: str, terms, origin: str = ""):
        """Make a reading of a content.

        Parameters
        ----------
        job : Job    To be told how far it is.
        data : bytes
        path : str    Of the file, or the name of its text, for messages.
        terms : hashable    See `terms_of`.
        origin : str    Format that an embedded file was made of.

        Raises
        ------
        LumenrayError    It is refused.
        """
        raise NotImplementedError

    def terms_of(self, settings):
        """Return what counts for the reading beside the content; hashable."""
        return ()

    def users(self) -> Iterable:
        """Give the data-blocks that use files of this kind."""
        return ()

    # ---- where it is ----

    def absolute_path(self, settings) -> str:
        """Return where a file is or was read from, empty if that is not known."""
        path = settings.filepath
        if self._is_ours(path):
            return self.library.path_of(path)
        return bpy.path.abspath(path, library=settings.id_data.library) if path else ""

    def name_of(self, settings) -> str:
        """Name of the file for people, empty if none is chosen."""
        path = settings.filepath
        name = path.removeprefix(self.library.prefix) if self._is_ours(path) else path
        return bpy.path.basename(name)

    def place_of(self, settings) -> str:
        """Say where the file is kept."""
        is_ours = self._is_ours(settings.filepath)
        return "From Lumenray's library" if is_ours else "Linked by its path"

    def stored(self, path: str) -> str:
        """Return a path, or the name of a file of ours, as settings keep it."""
        return path if self._is_ours(path) or path.startswith("//") else stored_path(path)

    def _is_ours(self, path: str) -> bool:
        return self.library is not None and path.startswith(self.library.prefix)

    # ---- reading ----

    def obtain(self, settings, is_patient: bool = True):
        """Return the reading of the file that settings choose; cheap once it is read.

        Raises
        ------
        NoFileError    None is chosen.
        NotReadyError    It is not ready, and ``is_patient`` is not set: then it is waited for.
        LumenrayError    It cannot be read.
        """
        owner = settings.id_data.original.session_uid if self.is_stopped_unwanted else None
        return self.result(*self.source(settings), owner, is_patient)

    def source(self, settings) -> tuple[tuple, Callable]:
        """Return by what the file of settings is known, and what begins to read it, as `Shelf.job` takes them."""
        path = self.absolute_path(settings)
        if not path:
            raise NoFileError(f"no {self.noun} is chosen")
        return self.source_of_path(path, self.terms_of(settings))

    def source_of_path(self, path: str, terms) -> tuple[tuple, Callable]:
        """As `source`, of a file on disk."""
        key = (path, *stamp(path), terms)
        return key, lambda: lambda job: self.read(job, read_bytes(path, self.largest), path, terms)

    def result(self, key: tuple, prepare: Callable, owner=None, is_patient: bool = True):
        """Return the reading of a source; raises as `obtain`."""
        job = self._shelf.job(key, lambda: self._guarded(prepare()), owner)
        if not is_patient and not job.future.done():
            error = NotReadyError(self.under_way.format(share=100.0 * job.share))
            error.share, error.left = job.share, job.left
            raise error
        try:
            return job.future.result()
        except (Cancelled, CancelledError):
            error = NotReadyError(self.stopped)
            error.is_stopped = True
            raise error from None
        except LumenrayError as error:
            raise error.with_traceback(None) from None

    def state_of(self, settings) -> State:
        """Find out the state of the file that settings choose; where there is a thread, it reads what has to be read."""
        name = self.name_of(settings)
        if not name:
            return State(name)
        place = self.place_of(settings)
        try:
            return State(name, place, self.obtain(settings, is_patient=False))
        except NotReadyError as error:
            return State(
                name, place, share=error.share, left=error.left, is_stopped=error.is_stopped
            )
        except LumenrayError as error:
            problem = str(error).removeprefix(f"{self.absolute_path(settings)}: ")
            return State(name, place, problem=problem)

    def call_when_ready(self, function: Callable[[], bool]) -> None:
        """Call a function whenever files became ready, until it returns True."""
        self._shelf.call_when_ready(function)

    def forget(self, settings=None) -> None:
        """Have the file of settings, or all, read anew when asked for next."""
        self._shelf.forget("" if settings is None else self.absolute_path(settings))

    def reload(self, settings) -> None:
        """Have the file of settings read anew."""
        self.forget(settings)
        settings.id_data.update_tag()

    def stop(self, settings) -> None:
        """End the reading of what settings choose, if it is under way."""
        self._shelf.stop(self.source(settings)[0])

    def restart(self, settings) -> None:
        """Read what settings choose after all, which was stopped."""
        self._shelf.drop(self.source(settings)[0])
        settings.id_data.update_tag()

    def detach(self) -> None:
        """Stop everything: the add-on is taken off."""
        self._shelf.close()

    def _guarded(self, read: Callable) -> Callable:
        """Let a mistake of ours be told as problems of files are: a panel or a view must not fail of it."""

        def guarded(job):
            try:
                return read(job)
            except LumenrayError:
                raise
            except Exception as error:
                cause = f"{type(error).__name__}: {error}"
                raise LumenrayError(self.fault.format(cause=cause)) from error

        return guarded
