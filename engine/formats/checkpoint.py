"""State of an interrupted job in a file: named arrays and facts, checked byte by byte when it is read.

A file is a line that says what it is; sixteen bytes with the length of the header and its checksum; the header, JSON text
with the facts and with name, kind, shape, place and checksum of every array; and the arrays, one behind the other and
nothing else. So no size that a file claims is believed before the file itself is found to be as large.
"""

import contextlib
import dataclasses
import hashlib
import json
import math
import os
import struct
import zlib
from enum import Enum
from pathlib import Path

import numpy as np

from .. import VERSION
from ..errors import FileFormatError
from ..reading.content import open_file, size_of

MAGIC = b"Lumenray checkpoint 3\n"
"""First bytes of every file; the number is that of the format."""

KIND = b"Lumenray checkpoint "
"""What all versions of the format begin with."""

PREFIX = struct.Struct("<QII")
"""Length of the header, its checksum, and 0."""

LONGEST_HEADER = 1 << 24
"""Largest header that is read. [byte]"""

MOST_ARRAYS = 4096
"""Most arrays of a file."""

MOST_SIDES = 8
"""Most dimensions of an array."""

KINDS = ("|b1", "|i1", "|u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8", "<f2", "<f4", "<f8")
"""Kinds of numbers that arrays may hold."""

PIECE = 1 << 24
"""What is read or written at once. [byte]"""

WHOSE = {
    "engine": "another version of Lumenray ({found}; this is {wanted})",
    "scene": "another state of the scene",
    "order": "a bake with other settings",
}
"""Facts that must agree, and what a file comes from where they do not."""


TABLES = {"scene": "items", "order": "settings"}
"""Facts whose parts are known by name."""

MOST_NAMES = 4
"""Parts that are named where many differ."""


def write_checkpoint(path, state: dict[str, np.ndarray], facts: dict) -> Path:
    """Write arrays and facts; a file that was there before stays whole until the new one is.

    Parameters
    ----------
    path : str or Path
    state : dict of str to array    Numbers or truth values.
    facts : dict
        What JSON can hold (tuples come back as lists). ``scene`` and ``order`` are digests that `read_checkpoint` compares;
        ``engine`` is added.

    Raises
    ------
    FileFormatError    It cannot be written; nothing is left behind.
    """
    path = Path(path)
    arrays = {name: _plain(path, name, array) for name, array in state.items()}
    table, offset = [], 0
    for name, array in arrays.items():
        table.append([name, array.dtype.str, list(array.shape), offset, _checksum(array)])
        offset += array.nbytes
    text = {"facts": {**facts, "engine": VERSION}, "arrays": table}
    header = json.dumps(text, separators=(",", ":")).encode()
    if len(header) > LONGEST_HEADER or len(table) > MOST_ARRAYS:
        raise FileFormatError(path, "cannot be written, its facts or names are too many")
    part = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with part.open("wb") as file:
            file.write(MAGIC + PREFIX.pack(len(header), zlib.crc32(header), 0) + header)
            for array in arrays.values():
                for piece in _pieces(array):
                    file.write(piece)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except OSError as error:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
        raise FileFormatError(path, f"cannot be written ({error.strerror or error})") from None
    return path


def read_checkpoint(
    path, scene: str | None = None, order: str | None = None, wanted: dict | None = None
) -> tuple[dict[str, np.ndarray], dict]:
    """Read arrays and facts.

    Parameters
    ----------
    path : str or Path
    scene, order : str or None    Digests that the file's facts must have; None: any.
    wanted : dict or None    Facts as of `write_checkpoint`, with which a refusal says what differs: tables of digests by
        name, ``items`` of the scene and ``settings`` of the order.

    Returns
    -------
    dict of str to array, dict    State and facts, bit by bit what was written.

    Raises
    ------
    FileFormatError    No checkpoint, damaged, or of another version, scene or order.
    """
    path = Path(path)
    try:
        with open_file(path) as file:
            size = size_of(file)
            facts, table, begin = _read_header(path, file, size)
            digests = {"engine": VERSION, "order": order, "scene": scene}
            _compare(path, facts, digests, wanted or {})
            layout = _check_table(path, table, size - begin)
            state = {}
            for name, kind, shape, checksum in layout:
                array = np.empty(shape, dtype=kind)
                for piece in _pieces(array):
                    if file.readinto(piece) != len(piece):
                        raise _cut(path)
                if _checksum(array) != checksum:
                    raise FileFormatError(
                        path, f"the checkpoint is damaged in {name!r}: delete it and start anew"
                    )
                state[name] = array
    except OSError as error:
        raise FileFormatError(path, f"cannot be read ({error.strerror or error})") from None
    except MemoryError:
        raise FileFormatError(path, "the checkpoint is larger than this machine's memory") from None
    return state, facts


def digest(value, without: tuple[str, ...] = ()) -> str:
    """Fingerprint of plain data: dataclasses, tables with names, sequences, arrays, texts and numbers.

    Parameters
    ----------
    value
    without : tuple of str    Fields of ``value`` itself, or names of the table that it is, that make no difference.

    Returns
    -------
    str    64 hexadecimal digits; the same in every process and on every machine.

    Raises
    ------
    TypeError    It holds something else.
    """
    if dataclasses.is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        value = {name: entry for name, entry in value.items() if name not in without}
    sum_ = hashlib.sha256()
    _feed(sum_, value)
    return sum_.hexdigest()


def _feed(sum_, value) -> None:
    """Put a value into a fingerprint; every kind with its name and length, so that no two values read alike."""
    if dataclasses.is_dataclass(value):
        sum_.update(type(value).__name__.encode() + b"\0")
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, Enum):
        value = value.name
    if isinstance(value, dict):
        sum_.update(b"table %d\0" % len(value))
        for name in sorted(value):
            _feed(sum_, name)
            _feed(sum_, value[name])
    elif isinstance(value, list | tuple):
        sum_.update(b"sequence %d\0" % len(value))
        for entry in value:
            _feed(sum_, entry)
    elif isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value)
        array = array.astype(array.dtype.newbyteorder("<"), copy=False)
        sum_.update(f"array {array.dtype.str} {value.shape}\0".encode() + array.tobytes())
    elif value is None or isinstance(value, bool | int | float | str | np.generic):
        plain = value.item() if isinstance(value, np.generic) else value
        # A whole number is the same setting whether it was typed as 8 or as 8.0.
        is_whole = isinstance(plain, float) and plain.is_integer()
        text = repr(int(plain) if is_whole else plain)
        sum_.update(f"{len(text)} {text}\0".encode("utf-8", "surrogatepass"))
    else:
        raise TypeError(f"a {type(value).__name__} has no fingerprint")


def _plain(path: Path, name: str, array) -> np.ndarray:
    """Return an array as it stands in the file."""
    array = np.asarray(array)
    plain = array.astype(array.dtype.newbyteorder("<"), copy=False)
    if plain.dtype.str not in KINDS or plain.ndim > MOST_SIDES:
        raise FileFormatError(path, f"cannot be written, {name!r} is an array of {array.dtype}")
    return np.ascontiguousarray(plain).reshape(plain.shape)


def _pieces(array: np.ndarray):
    """Bytes of an array, to be read or filled, piece by piece."""
    data = array.reshape(-1).view(np.uint8)
    for first in range(0, len(data), PIECE):
        yield data[first : first + PIECE].data


def _checksum(array: np.ndarray) -> int:
    value = 0
    for piece in _pieces(array):
        value = zlib.crc32(piece, value)
    return value


def _read_header(path: Path, file, size: int) -> tuple[dict, list, int]:
    """Facts, table of arrays, and where the arrays begin."""
    magic = file.read(len(MAGIC))
    if magic != MAGIC:
        if magic.startswith(KIND):
            raise FileFormatError(
                path,
                "the checkpoint is of another version of Lumenray: delete it and start anew",
            )
        if magic and MAGIC.startswith(magic):
            raise _cut(path)
        raise FileFormatError(path, "this is no checkpoint of Lumenray")
    prefix = file.read(PREFIX.size)
    if len(prefix) < PREFIX.size:
        raise _cut(path)
    length, checksum, zero = PREFIX.unpack(prefix)
    if zero or length > LONGEST_HEADER:
        raise _damaged(path)
    begin = len(MAGIC) + PREFIX.size + length
    if begin > size:
        raise _cut(path)
    header = file.read(length)
    if zlib.crc32(header) != checksum:
        raise _damaged(path)
    try:
        text = json.loads(header)
    except (ValueError, RecursionError):
        raise _damaged(path) from None
    facts, table = (text.get("facts"), text.get("arrays")) if isinstance(text, dict) else (0, 0)
    if not isinstance(facts, dict) or not isinstance(table, list) or len(table) > MOST_ARRAYS:
        raise _damaged(path)
    return facts, table, begin


def _compare(path: Path, facts: dict, digests: dict, wanted: dict) -> None:
    """Refuse a file of another version, scene or order."""
    for name, value in digests.items():
        if value is not None and facts.get(name) != value:
            whose = WHOSE[name].format(found=str(facts.get(name))[:40], wanted=value)
            table = TABLES.get(name)
            what = _differences(facts.get(table), wanted.get(table))
            raise FileFormatError(
                path, f"the checkpoint comes from {whose}{what}: delete it or name another file"
            )


def _differences(found, wanted) -> str:
    """Names by which two tables differ, in brackets; nothing where they are not known."""
    if not isinstance(found, dict) or not isinstance(wanted, dict) or not found or not wanted:
        return ""
    names = [name for name in {**found, **wanted} if found.get(name) != wanted.get(name)]
    if not names:
        return ""
    more = f" and {len(names) - MOST_NAMES} others" if len(names) > MOST_NAMES else ""
    return f" ({', '.join(str(name)[:60] for name in names[:MOST_NAMES])}{more})"


def _check_table(path: Path, table: list, room: int) -> list[tuple[str, np.dtype, tuple, int]]:
    """Check that the arrays fill the rest of the file exactly, before any memory is taken."""
    layout, names, end = [], set(), 0
    for row in table:
        if not isinstance(row, list) or len(row) != 5:
            raise _damaged(path)
        name, kind, shape, offset, checksum = row
        fits = (
            isinstance(name, str)
            and name not in names
            and kind in KINDS
            and isinstance(shape, list)
            and len(shape) <= MOST_SIDES
            and all(type(side) is int and 0 <= side < 1 << 48 for side in shape)
            and type(checksum) is int
            and offset == end
        )
        if not fits:
            raise _damaged(path)
        dtype = np.dtype(kind)
        # numpy counts in 64 bits, also what is multiplied by a side of length zero.
        if math.prod(max(side, 1) for side in shape) * dtype.itemsize >= 1 << 62:
            raise _damaged(path)
        names.add(name)
        end += math.prod(shape) * dtype.itemsize
        layout.append((name, dtype, tuple(shape), checksum))
    if end > room:
        raise _cut(path)
    if end < room:
        raise _damaged(path)
    return layout


def _cut(path: Path) -> FileFormatError:
    return FileFormatError(path, "the checkpoint ends too early: delete it and start anew")


def _damaged(path: Path) -> FileFormatError:
    return FileFormatError(path, "the checkpoint is damaged: delete it and start anew")
