"""Heads and rows of binary ray files: numbers at fixed places, then rows of float32, little-endian throughout."""

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..reading.content import open_file, size_of
from ..reading.text import decode_text

PIECE = 1 << 16
"""Rows that are read in one go."""

MAXIMUM_RAYS = 4_000_000_000
"""Most rays of a file."""


class Head:
    """The first bytes of a file, with the size of the whole.

    Parameters
    ----------
    path : Path
    size : int    First bytes to be read; fewer where the file is shorter.
    """

    def __init__(self, path, size: int = 1 << 16):
        self.path = Path(path)
        with open_file(self.path) as file:
            self.length = size_of(file)
            self.data = file.read(min(size, self.length))

    def number(self, kind: str, offset: int):
        """One number: ``kind`` as of `struct`, such as ``i``, ``I``, ``Q`` or ``f``."""
        return self.numbers(kind, offset)[0]

    def numbers(self, kinds: str, offset: int) -> tuple:
        """Numbers that follow each other."""
        size = struct.calcsize("<" + kinds)
        if offset + size > len(self.data):
            raise FileFormatError(
                self.path,
                f"ends at byte {self.length}, within its head; expected at least {offset + size} bytes",
            )
        return struct.unpack_from("<" + kinds, self.data, offset)

    def text(self, offset: int, size: int, encoding: str | None = None) -> str:
        """Text that is filled up with NUL."""
        raw = self.data[offset : offset + size]
        if encoding is None:
            return decode_text(raw.split(b"\0", 1)[0]).strip()
        return raw.decode(encoding, "replace").split("\0", 1)[0].strip()

    def expect_length(self, expected: int, what: str) -> None:
        """Refuse a file of another length. ``what``: how the expected one is made up."""
        if self.length != expected:
            word = "is cut short" if self.length < expected else "is too long"
            raise FileFormatError(
                self.path, f"{word}: it has {self.length} bytes, expected {expected} ({what})"
            )


def check_count(path, count: int) -> None:
    """Refuse numbers of rays that cannot be."""
    if not 0 < count <= MAXIMUM_RAYS:
        raise FileFormatError(path, f"states {count} rays, expected 1 to {MAXIMUM_RAYS}")


def read_rows(path, offset: int, count: int, columns: int) -> Iterator[np.ndarray]:
    """Yield the rows (n, columns) float32 of a binary file piece by piece."""
    with open_file(path) as file:
        file.seek(offset)
        left = count
        while left:
            wanted = min(left, PIECE)
            rows = np.fromfile(file, dtype="<f4", count=wanted * columns)
            if len(rows) < wanted * columns:
                place = offset + (count - left) * columns * 4 + len(rows) * 4
                raise FileFormatError(path, f"ends at byte {place}, {left} rays before its end")
            yield rows.reshape(wanted, columns)
            left -= wanted
