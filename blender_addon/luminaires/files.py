"""Photometric files as data-blocks and on disk: embedding, linking, and reading each content once.

A file is embedded as a text data-block, one for every content, so that lights with the same file share it. Blender keeps the
line ends of a text as they are, so the bytes come back as they were.
"""

import hashlib
import re
import threading
from collections import OrderedDict
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import bpy

from ...engine.errors import FileFormatError, LumenrayError
from ...engine.luminaires.distribution import flux as flux_of
from ...engine.luminaires.formats.reader import parse_luminaire
from ...engine.luminaires.formats.record import LuminaireFile
from ...engine.luminaires.lamp_spectrum import LampSpectrum, choose_spectrum
from ...engine.reading.content import holds, read_bytes
from ...engine.scene.distribution import IntensityDistribution

EXTENSIONS = (".ies", ".ldt", ".xml")
"""Of photometric files."""

LONGEST_LINE = 100_000
"""Characters in a line that Blender's texts can take: their time grows with its square, 0.2 s at this length."""

ENCODINGS = ("utf-8", "utf-16-le", "utf-16-be", "latin-1")
"""Ways in which bytes stand for text, in the order in which they are tried."""

KEPT_BYTES = 1 << 28
"""Content of which the readings are kept. [byte]"""

KEPT_REFUSALS = 1000
"""Refused contents that are remembered."""

_TILT_FILE = re.compile(
    rb"^[ \t]*TILT[ \t]*=[ \t]*(?!NONE|INCLUDE)\S", re.IGNORECASE | re.MULTILINE
)


class NoFileError(LumenrayError):
    """No photometric file is chosen, or its data-block is missing."""


class NotTextError(LumenrayError):
    """A file can be read, but Blender's texts cannot hold it."""


@dataclass(frozen=True, eq=False)
class Reading:
    """A photometric file as it was read; shared by everything with this content.

    Parameters
    ----------
    file : LuminaireFile
    digest : str    SHA-256 of the content, in hexadecimal.
    """

    file: LuminaireFile
    digest: str

    @property
    def distribution(self) -> IntensityDistribution:
        """As it is stored, before any setting turns it."""
        return self.file.distribution

    @cached_property
    def flux(self) -> float:
        """Of the distribution. [lm, of radiant files W]"""
        return flux_of(self.file.distribution)

    @cached_property
    def lamp_spectrum(self) -> LampSpectrum:
        """What the file says of its lamp."""
        return choose_spectrum(self.file)


class _Shelf:
    """Readings by content, the latest used last. Renders read on threads of their own."""

    def __init__(self):
        self._lock = threading.Lock()
        self._readings: OrderedDict[tuple, tuple[Reading, int]] = OrderedDict()
        self._refused: OrderedDict[tuple, FileFormatError] = OrderedDict()
        self._stamps: dict[str, tuple[tuple, tuple]] = {}

    def parse(self, data: bytes, path, folder: Path | None = None) -> Reading:
        """Read a content; ``folder`` is where a TILT file may lie."""
        digest = digest_of(data)
        key = (digest, str(folder)) if names_tilt_file(data) else (digest,)
        with self._lock:
            if key in self._readings:
                self._readings.move_to_end(key)
                return self._readings[key][0]
            if (key, str(path)) in self._refused:
                raise self._refused[key, str(path)].with_traceback(None)
            try:
                reading = Reading(parse_luminaire(data, path, folder), digest)
            except FileFormatError as error:
                self._refused[key, str(path)] = error
                while len(self._refused) > KEPT_REFUSALS:
                    self._refused.popitem(last=False)
                raise
            self._readings[key] = (reading, len(data))
            while len(self._readings) > 1 and self._size() > KEPT_BYTES:
                self._readings.popitem(last=False)
            return reading

    def open(self, path: str) -> Reading:
        """Read a file on disk; what has not changed since is not read again."""
        stamp = _stamp(path)
        known = self._stamps.get(path)
        if known is not None and known[0] == stamp:
            with self._lock:
                found = self._readings.get(known[1])
            if found is not None:
                return found[0]
        data = read_bytes(path)
        reading = self.parse(data, path, Path(path).parent)
        if not names_tilt_file(data):
            self._stamps[path] = (stamp, (reading.digest,))
        return reading

    def clear(self) -> None:
        """Forget everything, so that files are read anew."""
        with self._lock:
            self._readings.clear()
            self._refused.clear()
            self._stamps.clear()

    def _size(self) -> int:
        return sum(size for _, size in self._readings.values())


_shelf = _Shelf()


def _stamp(path: str) -> tuple:
    """Date and size of a file, () if there is none."""
    try:
        found = Path(path).stat()
    except (OSError, ValueError):
        return ()
    return (found.st_mtime_ns, found.st_size)


def digest_of(data: bytes) -> str:
    """SHA-256 of a content in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def names_tilt_file(data: bytes) -> bool:
    """Whether a content needs another file beside it."""
    return _TILT_FILE.search(data) is not None


def forget_readings() -> None:
    """Read all files anew when they are asked for."""
    _shelf.clear()


# ---- reading ----


def read(settings) -> Reading:
    """Read the photometric file that settings choose; cheap when nothing has changed.

    Parameters
    ----------
    settings : LuminaireSettings

    Raises
    ------
    NoFileError    None is chosen.
    FileFormatError    It cannot be opened, or is refused.
    """
    path = absolute_path(settings)
    if settings.text is not None:
        return read_text(settings.text, Path(path).parent if path else None)
    if not path:
        raise NoFileError("no photometric file is chosen")
    return _shelf.open(path)


def read_path(path: str) -> Reading:
    """Read a file on disk.

    Raises
    ------
    FileFormatError    It cannot be opened, or is refused.
    """
    return _shelf.open(path)


def read_text(text, folder: Path | None = None) -> Reading:
    """Read a text data-block.

    Raises
    ------
    NoFileError    It is missing in the file that it is linked from.
    FileFormatError    It is refused.
    """
    if text.is_missing:
        raise NoFileError(f"the embedded photometric file '{text.name}' is missing")
    return _shelf.parse(content_of(text), text.name, folder)


def absolute_path(settings) -> str:
    """Return where a file was read from, empty if that is not known."""
    if not settings.filepath:
        return ""
    return bpy.path.abspath(settings.filepath, library=settings.id_data.library)


def has_changed(settings, reading: Reading) -> bool:
    """Whether what is read now differs from what was loaded: the file on disk, or the text in Blender, was edited."""
    loaded = settings.text.lumenray.digest if settings.text is not None else settings.digest
    return bool(loaded) and loaded != reading.digest


def name_of(settings) -> str:
    """Name of the file for people."""
    return bpy.path.basename(settings.filepath) or (settings.text.name if settings.text else "")


# ---- embedding ----


def content_of(text) -> bytes:
    """Return the bytes of an embedded file."""
    content, encoding = text.as_string(), text.lumenray.encoding or "utf-8"
    try:
        return content.encode(encoding)
    except UnicodeEncodeError:
        # Someone wrote into it what its own encoding lacks.
        return content.encode("utf-8")


def embed(data: bytes, name: str):
    """Return the text data-block of a content: the one that is there already, or a new one.

    Raises
    ------
    NotTextError    Blender could not hold it as a text.
    """
    digest = digest_of(data)
    for text in bpy.data.texts:
        is_same = text.library is None and text.lumenray.digest == digest
        if is_same and content_of(text) == data:
            return text
    content, encoding = _as_text(data, name)
    text = bpy.data.texts.new(name)
    text.use_fake_user = False
    text.from_string(content)
    text.lumenray.digest, text.lumenray.encoding = digest, encoding
    return text


def _as_text(data: bytes, name: str) -> tuple[str, str]:
    """Return the text that bytes stand for, and in which encoding they come back exactly."""
    for encoding in ENCODINGS:
        try:
            content = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in content:
            break
    else:
        raise NotTextError(f"{name} has NUL characters, which Blender's texts cannot hold")
    longest = max(map(len, re.split(r"[\r\n]", content)))
    if longest > LONGEST_LINE:
        raise NotTextError(
            f"{name} has a line of {longest} characters, Blender's texts take {LONGEST_LINE}"
        )
    return content, encoding


def load(settings, path: str, is_embedded: bool = True) -> Reading:
    """Choose a file on disk for settings; they stay as they are if it is refused.

    What Blender's texts cannot hold is linked: ``settings.text`` tells whether it was embedded.

    Raises
    ------
    FileFormatError    It cannot be opened or is refused.
    """
    path = str(Path(bpy.path.abspath(path)).absolute())
    data = read_bytes(path)
    reading = _shelf.parse(data, path, Path(path).parent)
    text = None
    if is_embedded:
        with suppress(NotTextError):
            text = embed(data, Path(path).name)
    _choose(settings, path, text, reading.digest)
    settings.use_file = True
    return reading


def _choose(settings, path: str, text, digest: str) -> None:
    # The text of before goes when Blender saves, if nothing uses it: a render that is under way may still read it.
    settings.filepath = stored_path(path) if path else ""
    settings.text, settings.digest = text, digest


def pack(settings) -> None:
    """Embed the file that is linked.

    Raises
    ------
    LumenrayError    As of `read` and `embed`.
    """
    read(settings)
    path = absolute_path(settings)
    data = read_bytes(path)
    _choose(settings, path, embed(data, name_of(settings)), digest_of(data))


def unpack(settings) -> str:
    """Link the file that is embedded and return its path; it is written where the path has another content or none.

    Raises
    ------
    LumenrayError    There is no place for it, or it cannot be written.
    """
    data = content_of(settings.text)
    path = Path(absolute_path(settings) or ".")
    if not holds(path, data):
        path = _free_place(name_of(settings), data)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        except OSError as error:
            raise LumenrayError(f"{path} cannot be written ({error.strerror})") from None
    _choose(settings, str(path), None, digest_of(data))
    return str(path)


def reload(settings) -> Reading:
    """Read a file anew from where it was read; embedded stays embedded.

    Raises
    ------
    LumenrayError    As of `load`, or its place is not known.
    """
    path = absolute_path(settings)
    if not path:
        raise NoFileError("it is not known where the photometric file was read from")
    forget_readings()
    return load(settings, path, settings.text is not None)


def clear(settings) -> None:
    """Choose no photometric file."""
    settings.use_file = False
    _choose(settings, "", None, "")


def _free_place(name: str, data: bytes) -> Path:
    """Place beside the .blend file that is free, or has this content already."""
    if not bpy.data.filepath:
        raise LumenrayError(
            "save the Blender file first: the photometric file is written beside it"
        )
    folder = Path(bpy.path.abspath("//luminaires"))
    plain = Path(bpy.path.clean_name(Path(name).stem) + Path(name).suffix)
    path, number = folder / plain, 1
    while path.exists() and not holds(path, data):
        number += 1
        path = folder / f"{plain.stem}_{number}{plain.suffix}"
    return path


def stored_path(path: str) -> str:
    """Path as Blender keeps it: relative to the .blend file where the user prefers that."""
    if not bpy.data.filepath or not bpy.context.preferences.filepaths.use_relative_paths:
        return path
    try:
        return bpy.path.relpath(path)
    except ValueError:
        # Another drive of Windows.
        return path
