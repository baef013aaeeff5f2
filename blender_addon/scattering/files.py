"""Scattering files read once for all materials that use them, in the background where Blender's window would wait.

Large files take up to a minute to be read and resampled. Panels and the live view go on without a file that is not ready; a
render or a bake waits for it. A file is embedded as a text data-block, in our own compact format: one text for every
content, found again by its SHA-256, which is checked whenever it is read.
"""

import base64
import binascii
import re
import threading
from collections import OrderedDict
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from dataclasses import dataclass, is_dataclass, replace
from pathlib import Path

import bpy
import numpy as np

from ...engine.errors import FileFormatError, LumenrayError
from ...engine.reading.content import holds
from ...engine.scattering.data.record import ScatteringFile
from ...engine.scattering.data.store import SUFFIX, is_store
from ...engine.scattering.data.store import pack as pack_store
from ...engine.scattering.data.surface import excess_of
from ...engine.scattering.look import Look, fit_look
from ...engine.scattering.readers.reader import Wish, parse_scattering, read_content
from ...engine.scattering.summary import SideSummary, summarise
from ..luminaires.files import digest_of, stored_path
from .source import absolute_path, is_measured, name_of

LINE = 76
"""Characters in a line of an embedded file."""

KEPT = 256
"""Files that are kept: more than scenes have, as each reading of all of them would else read all anew."""

TICK = 0.25
"""Between two looks at what is being read. [s]"""

HEAD = re.compile(r"# Lumenray packed scattering file, from (.{0,200}), SHA-256 ([0-9a-f]{64})")
"""First line of an embedded file."""


class NoFileError(LumenrayError):
    """No scattering file is chosen, or its data-block is missing."""


class NotReadyError(LumenrayError):
    """A scattering file is being read."""


@dataclass(frozen=True, eq=False)
class Reading:
    """A scattering file as it was read; shared by all materials with this content. Its arrays are read-only.

    Parameters
    ----------
    file : ScatteringFile
    digest : str    SHA-256 of the content, in hexadecimal.
    sides : dict of str to SideSummary
    look : Look
    """

    file: ScatteringFile
    digest: str
    sides: dict[str, SideSummary]
    look: Look


class _Shelf:
    """Files that are read, or have been, the latest used last."""

    def __init__(self):
        self._lock = threading.Lock()
        self._jobs: OrderedDict[tuple, Future] = OrderedDict()
        self._told: set[Future] = set()
        self._pool: ThreadPoolExecutor | None = None
        # Used on the reading thread alone.
        self._readings: OrderedDict[tuple, Reading] = OrderedDict()
        self._waiting: list = []
        # Blender knows a timer by the object, and every look at a method makes a new one.
        self.timer = self._take_over

    def job(self, settings) -> Future:
        """Reading, or what will be one, of the file of settings; it is begun if there is none."""
        key, load = _source(settings)
        wish = Wish(settings.tolerance)
        key = (*key, wish)
        with self._lock:
            found = self._jobs.get(key)
            if found is None:
                if self._pool is None:
                    self._pool = ThreadPoolExecutor(1, thread_name_prefix="lumenray-scattering")
                found = self._jobs[key] = self._pool.submit(self._read, load(), wish)
                done = [each for each, job in self._jobs.items() if job.done()]
                for each in done[: max(len(self._jobs) - KEPT, 0)]:
                    self._told.discard(self._jobs.pop(each))
            self._jobs.move_to_end(key)
        if not (
            bpy.app.background or found in self._told or bpy.app.timers.is_registered(self.timer)
        ):
            # Persistent: loading a file does not end what is under way.
            bpy.app.timers.register(self.timer, first_interval=TICK, persistent=True)
        return found

    def call_when_ready(self, function) -> None:
        """Call a function on the main thread when what is being read is ready; it says whether it wants no more."""
        self._waiting.append(function)

    def forget(self) -> None:
        """Read all files anew when they are asked for next; who waits gets what is under way."""
        with self._lock:
            self._jobs.clear()
            self._told.clear()

    def close(self) -> None:
        """Forget all, and start nothing more."""
        with self._lock:
            pool, self._pool = self._pool, None
        self.forget()
        self._waiting.clear()
        if bpy.app.timers.is_registered(self.timer):
            bpy.app.timers.unregister(self.timer)
        if pool is not None:
            pool.shutdown(cancel_futures=True)
        self._readings.clear()

    def _read(self, load, wish: Wish) -> Reading:
        """Read a content, on the thread; it is known again by its hash."""
        try:
            data, path, origin = load()
            key = (digest_of(data), wish)
            if key not in self._readings:
                self._readings[key] = _make(data, path, origin, wish)
                while len(self._readings) > KEPT:
                    self._readings.popitem(last=False)
            self._readings.move_to_end(key)
            return self._readings[key]
        except LumenrayError:
            raise
        except Exception as error:
            # Whoever asks for the file shows the sentence; a panel or a view must not fail of it.
            raise LumenrayError(
                f"it cannot be read ({type(error).__name__}: {error}); please send the file to the developers"
            ) from error

    def _take_over(self) -> float | None:
        """Tell Blender of files that became ready; time until the next look, None after the last. [s]"""
        with self._lock:
            # Asked first, so that what ends meanwhile is told by one more look.
            is_busy = any(not job.done() for job in self._jobs.values())
            new = {job for job in self._jobs.values() if job.done()} - self._told
            self._told |= new
        if new:
            self._waiting[:] = [function for function in self._waiting if not function()]
            for material in bpy.data.materials:
                if is_measured(material):
                    material.update_tag()
            _redraw()
        return TICK if is_busy else None


_shelf = _Shelf()


def _redraw() -> None:
    for window in (w for manager in bpy.data.window_managers for w in manager.windows):
        for area in window.screen.areas:
            if area.type in {"PROPERTIES", "VIEW_3D"}:
                area.tag_redraw()


def _source(settings):
    """By what the file of settings is known, and a function that fetches what the thread then loads it from."""
    text = settings.text
    if text is not None:
        if text.is_missing:
            raise NoFileError(f"the embedded scattering file '{text.name}' is missing")
        head = text.lines[0].body if len(text.lines) else ""
        return ("text", text.session_uid, head), lambda: _loader_of_text(text)
    path = absolute_path(settings)
    if not path:
        raise NoFileError("no scattering file is chosen")
    return ("path", path, *_stamp(path)), lambda: lambda: (read_content(path), path, None)


def _loader_of_text(text):
    """Loader of an embedded file; the text itself is read at once, as the thread must not."""
    content, name = text.as_string(), text.name
    return lambda: _unwrap(content, name)


def _stamp(path: str) -> tuple:
    """Date and size of a file, () if there is none."""
    try:
        found = Path(path).stat()
    except (OSError, ValueError):
        return ()
    return (found.st_mtime_ns, found.st_size)


def _make(data: bytes, path, origin: str | None, wish: Wish) -> Reading:
    """Read a content, and find everything that is asked of it."""
    file = parse_scattering(data, path, wish)
    if origin:
        file = replace(file, format=origin)
    for scatter in set(file.sides.values()):
        _freeze(scatter)
        # Found here once and remembered, as it takes a while.
        excess_of(scatter, None)
    return Reading(file, digest_of(data), summarise(file), fit_look(file))


def _freeze(value) -> None:
    """Make all arrays of a scatter read-only: what follows from them is remembered then."""
    for part in vars(value).values():
        if isinstance(part, np.ndarray):
            part.flags.writeable = False
        elif is_dataclass(part):
            _freeze(part)


# ---- reading ----


def obtain(settings, is_patient: bool = True) -> Reading:
    """Return the file that settings choose; cheap once it is read.

    Parameters
    ----------
    settings : LumenrayMeasuredSettings
    is_patient : bool    Whether to wait for it.

    Raises
    ------
    NoFileError    None is chosen.
    NotReadyError    It is not read yet.
    LumenrayError    It cannot be read.
    """
    job = _shelf.job(settings)
    if not is_patient and not job.done():
        raise NotReadyError("its file is being read")
    try:
        return job.result()
    except LumenrayError as error:
        raise error.with_traceback(None) from None
    except CancelledError:
        raise NotReadyError("its file was not read: stopped") from None


def call_when_ready(function) -> None:
    """Call a function whenever files become ready, until it returns True."""
    _shelf.call_when_ready(function)


def forget() -> None:
    """Read all files anew when they are asked for next."""
    _shelf.forget()


def detach() -> None:
    """Stop everything: the add-on is taken off."""
    _shelf.close()


# ---- embedding ----


def embed(data: bytes, name: str, origin: str):
    """Return the text data-block of a content: the one that is there already, or a new one.

    Parameters
    ----------
    data : bytes    Content of a file of ours.
    name : str    Of the file.
    origin : str    Format of the file that it was made of.
    """
    digest = digest_of(data)
    content = _wrap(data, digest, origin)
    for text in bpy.data.texts:
        head = HEAD.fullmatch(text.lines[0].body) if len(text.lines) else None
        if text.library is None and head and head[2] == digest and _holds(text, data):
            return text
    text = bpy.data.texts.new(name)
    text.use_fake_user = False
    text.from_string(content)
    return text


def _holds(text, data: bytes) -> bool:
    try:
        return _unwrap(text.as_string(), text.name)[0] == data
    except FileFormatError:
        return False


def _wrap(data: bytes, digest: str, origin: str) -> str:
    words = " ".join(origin.split())[:200]
    coded = base64.b64encode(data).decode("ascii")
    lines = [coded[k : k + LINE] for k in range(0, len(coded), LINE)]
    return "\n".join([f"# Lumenray packed scattering file, from {words}, SHA-256 {digest}", *lines])


def _unwrap(content: str, name: str) -> tuple[bytes, str, str]:
    """Content of an embedded file, its name, and the format that it was made of.

    Raises
    ------
    FileFormatError    It is none, or not what was embedded.
    """
    head, *lines = content.split("\n")
    found = HEAD.fullmatch(head)
    if found is None:
        raise FileFormatError(
            name, "is no embedded scattering file, expected a first line that says so; open the file anew", 1
        )  # fmt: skip
    try:
        data = base64.b64decode("".join(lines), validate=True)
    except (binascii.Error, ValueError) as error:
        raise FileFormatError(
            name, f"is no base64 text below its first line ({error}); open the file anew"
        ) from None
    digest = digest_of(data)
    if digest != found[2]:
        raise FileFormatError(
            name,
            f"was changed since it was embedded: its SHA-256 is {digest[:12]}…, expected {found[2][:12]}…; open the file "
            "anew",
        )
    return data, name, found[1]


def pack(settings) -> None:
    """Embed the file that is linked, in our own format.

    Raises
    ------
    LumenrayError    It cannot be read.
    """
    reading, path = obtain(settings), absolute_path(settings)
    data = read_content(path)
    if not is_store(data):
        data = pack_store(reading.file)
    settings.text = embed(data, name_of(settings), reading.file.format)


def unpack(settings, folder: str = "") -> str:
    """Link the file that is embedded and return its path; it is written unless its own path still holds it.

    Parameters
    ----------
    settings : LumenrayMeasuredSettings
    folder : str    Where it is written; empty: into a folder beside the .blend file.

    Raises
    ------
    LumenrayError    There is no place for it, or it cannot be written.
    """
    data, name, _ = _unwrap(settings.text.as_string(), settings.text.name)
    path = Path(absolute_path(settings) or ".")
    if folder or not holds(path, data):
        path = _free_place(folder, name, data)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        except OSError as error:
            raise LumenrayError(f"{path} cannot be written ({error.strerror})") from None
        settings.filepath = stored_path(str(path))
    settings.text = None
    return str(path)


def _free_place(folder: str, name: str, data: bytes) -> Path:
    """Place in a folder that is free, or has this content already."""
    if not folder and not bpy.data.filepath:
        raise LumenrayError("save the Blender file first: the scattering file is written beside it")
    place = Path(bpy.path.abspath(folder or "//materials"))
    stem = bpy.path.clean_name(Path(name).stem)
    path, number = place / f"{stem}{SUFFIX}", 1
    while path.exists() and not holds(path, data):
        number += 1
        path = place / f"{stem}_{number}{SUFFIX}"
    return path
