"""Bytes of files from outside: of plain files alone, and never more than is allowed for.

Every reader of a file that others wrote opens it here. What a path leads to may be a device or a pipe, which never end or
never begin, and a file may hold more than its size says, as those of ``/proc`` do.
"""

import os
import stat
from pathlib import Path
from typing import BinaryIO

from ..errors import FileFormatError

MAXIMUM_SIZE = 64 << 20
"""Largest file that is read in one piece, where a reader does not say otherwise. [byte]"""

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def open_file(path) -> BinaryIO:
    """Open a plain file for reading its bytes.

    Raises
    ------
    FileFormatError    It cannot be opened, or is a folder, a device, a pipe or a socket.
    """
    try:
        # Devices may do something when they are opened, so what it is is asked before; and again, should it have changed.
        _refuse_special(path, os.stat(path).st_mode)  # noqa: PTH116 - Path.stat would not take what is no path
        flags = os.O_RDONLY | getattr(os, "O_BINARY", 0)
        # A pipe without a writer would wait for one.
        flags |= getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
        file = os.fdopen(os.open(path, flags), "rb")
    except OSError as error:
        raise FileFormatError(path, f"cannot be opened ({error.strerror})") from None
    except ValueError as error:
        raise FileFormatError(path, f"cannot be opened ({error})") from None
    try:
        _refuse_special(path, os.fstat(file.fileno()).st_mode)
    except FileFormatError:
        file.close()
        raise
    return file


def size_of(file: BinaryIO) -> int:
    """Size of an open file as its file system states it. [byte]"""
    return os.fstat(file.fileno()).st_size


def read_bytes(path, most: int = MAXIMUM_SIZE) -> bytes:
    """Return the content of a file of at most so many bytes; no more than one beyond them is read.

    Raises
    ------
    FileFormatError    As of `open_file`, or it is too large.
    """
    with open_file(path) as file:
        size = size_of(file)
        if size > most:
            raise FileFormatError(path, f"has {size >> 20} MiB, expected at most {most >> 20} MiB")
        try:
            data = file.read(most + 1)
        except OSError as error:
            raise FileFormatError(path, f"cannot be read ({error.strerror})") from None
    if len(data) > most:
        raise FileFormatError(path, f"has no end within {most >> 20} MiB, which is the most")
    return data


def holds(path, data: bytes) -> bool:
    """Whether a path is a file with this very content."""
    try:
        return Path(path).is_file() and read_bytes(path, len(data)) == data
    except (FileFormatError, OSError):
        return False


def _refuse_special(path, mode: int) -> None:
    if stat.S_ISREG(mode):
        return
    kind = next((word for is_one, word in _KINDS if is_one(mode)), "no plain file")
    raise FileFormatError(path, f"is {kind}, expected a file")
