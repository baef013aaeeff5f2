"""Bytes of files from outside: of plain files alone, and never more than is allowed for.

Every reader of a file that others wrote opens it here; how, `libraries.plain_files` tells.
"""

from pathlib import Path
from typing import BinaryIO

from ...libraries.plain_files import (
    UnreadableError,
    open_plain,
    read_object,
    read_plain,
    size_of,
)
from ..errors import FileFormatError

__all__ = ["MAXIMUM_SIZE", "holds", "open_file", "read_bytes", "read_json", "size_of"]

MAXIMUM_SIZE = 64 << 20
"""Largest file that is read in one piece, where a reader does not say otherwise. [byte]"""


def open_file(path) -> BinaryIO:
    """Open a plain file for reading its bytes.

    Raises
    ------
    FileFormatError    It cannot be opened, or is a folder, a device, a pipe or a socket.
    """
    try:
        return open_plain(path)
    except UnreadableError as error:
        raise FileFormatError(path, str(error)) from None


def read_bytes(path, most: int = MAXIMUM_SIZE) -> bytes:
    """Return the content of a file of at most so many bytes; no more than one beyond them is read.

    Raises
    ------
    FileFormatError    As of `open_file`, or it is too large.
    """
    try:
        return read_plain(path, most)
    except UnreadableError as error:
        raise FileFormatError(path, str(error)) from None


def read_json(path, most: int) -> dict:
    """Return the object that a JSON file of at most so many bytes holds.

    Raises
    ------
    FileFormatError    As of `read_bytes`, or it is no JSON or no object.
    """
    try:
        return read_object(path, most)
    except UnreadableError as error:
        raise FileFormatError(path, str(error)) from None


def holds(path, data: bytes) -> bool:
    """Whether a path is a file with this very content."""
    try:
        return Path(path).is_file() and read_bytes(path, len(data)) == data
    except (FileFormatError, OSError):
        return False
