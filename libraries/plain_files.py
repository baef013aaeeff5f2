"""Bytes of plain files alone, never more than is allowed for, and the objects in JSON that they may hold.

What a path leads to may be a device or a pipe, which never end or never begin, and a file may hold more than its size says,
as those of ``/proc`` do. It lies here because readers of users' folders need it, which know nothing of the engine; the
engine's own readers open files by `engine.reading.content`, which is made of it.
"""

import json
import os
import stat
from typing import BinaryIO

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


class UnreadableError(Exception):
    """A file cannot be read; the message says why and what was expected, without its name."""


def open_plain(path) -> BinaryIO:
    """Open a plain file for reading its bytes.

    Raises
    ------
    UnreadableError    It cannot be opened, or is a folder, a device, a pipe or a socket.
    """
    try:
        # Devices may do something when they are opened, so what it is is asked before; and again, should it have changed.
        _refuse_special(os.stat(path).st_mode)  # noqa: PTH116 - Path.stat would not take what is no path
        flags = os.O_RDONLY | getattr(os, "O_BINARY", 0)
        # A pipe without a writer would wait for one.
        flags |= getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
        file = os.fdopen(os.open(path, flags), "rb")
    except OSError as error:
        raise UnreadableError(f"cannot be opened ({error.strerror})") from None
    except ValueError as error:
        raise UnreadableError(f"cannot be opened ({error})") from None
    try:
        _refuse_special(os.fstat(file.fileno()).st_mode)
    except UnreadableError:
        file.close()
        raise
    return file


def size_of(file: BinaryIO) -> int:
    """Size of an open file as its file system states it. [byte]"""
    return os.fstat(file.fileno()).st_size


def read_plain(path, most: int) -> bytes:
    """Return the content of a file of at most so many bytes; no more than one beyond them is read.

    Raises
    ------
    UnreadableError    As of `open_plain`, or it is too large.
    """
    with open_plain(path) as file:
        size = size_of(file)
        if size > most:
            raise UnreadableError(f"has {size >> 20} MiB, expected at most {most >> 20} MiB")
        try:
            data = file.read(most + 1)
        except OSError as error:
            raise UnreadableError(f"cannot be read ({error.strerror})") from None
    if len(data) > most:
        raise UnreadableError(f"has no end within {most >> 20} MiB, which is the most")
    return data


def read_object(path, most: int) -> dict:
    """Return the object that a JSON file of at most so many bytes holds.

    Raises
    ------
    UnreadableError    As of `read_plain`, or it is no JSON, or something else than an object.
    """
    data = read_plain(path, most)
    try:
        content = json.loads(data.decode("utf-8-sig"))
    except json.JSONDecodeError as error:
        raise UnreadableError(f"is not JSON: line {error.lineno}, {error.msg}") from None
    except (ValueError, RecursionError) as error:
        raise UnreadableError(f"cannot be read ({error})") from None
    if not isinstance(content, dict):
        raise UnreadableError("expected an object in braces")
    return content


def _refuse_special(mode: int) -> None:
    if stat.S_ISREG(mode):
        return
    kind = next((word for is_one, word in _KINDS if is_one(mode)), "no plain file")
    raise UnreadableError(f"is {kind}, expected a file")
