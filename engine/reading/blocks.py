"""Binary files with compressed blocks: numbers and blocks in order, nothing larger than what the file can hold."""

import struct
import zlib

import numpy as np

from ..errors import FileFormatError
from .words import LARGEST

MOST_GROWTH = {"zlib": 1040, "lz4": 260}
"""Bytes that one compressed byte can become, by the nature of the method."""

MOST_BYTES = 400_000_000
"""Of all blocks of a file together."""


class Blocks:
    """The bytes of a file, read from a place on.

    Parameters
    ----------
    data : bytes
    path : str or Path    For messages.
    at : int    Where to begin.
    """

    def __init__(self, data: bytes, path, at: int):
        self.data, self.path, self.at = data, path, at
        self._held = 0

    def fail(self, message: str):
        """Refuse the file for what stands here."""
        raise FileFormatError(self.path, f"byte {self.at}: {message}")

    def take(self, count: int, what: str) -> bytes:
        """The next bytes."""
        if count > len(self.data) - self.at:
            self.fail(
                f"ends after {len(self.data) - self.at} of {count} bytes of {what}; it is cut short"
            )
        self.at += count
        return self.data[self.at - count : self.at]

    def whole(self, what: str, low: int, high: int) -> int:
        """The next four bytes as a number within limits."""
        value = struct.unpack("<I", self.take(4, what))[0]
        if not low <= value <= high:
            self.at -= 4
            self.fail(f"has {value} as {what}, expected {low} to {high}")
        return value

    def numbers(self, count: int, what: str) -> np.ndarray:
        """The next numbers of eight bytes. (count,) float64"""
        return self._finite(self.take(8 * count, what), what)

    def zlib_block(self, what: str) -> bytes:
        """A block after its size and its compressed size."""
        size = struct.unpack("<I", self.take(4, what))[0]
        stored = struct.unpack("<I", self.take(4, what))[0]
        self._hold(size, stored, "zlib", what)
        unpacker = zlib.decompressobj()
        try:
            found = unpacker.decompress(self.take(stored, what), size + 1)
        except zlib.error as error:
            self.fail(f"cannot unpack {what} ({error})")
        if len(found) != size or not unpacker.eof:
            self.fail(f"unpacks {what} to another size than the stated {size} bytes")
        return found

    def zlib_numbers(self, count: int, what: str) -> np.ndarray:
        """A block of numbers. (count,) float64"""
        return self._counted(self.zlib_block(what), count, what)

    def lz4_numbers(self, count: int, what: str) -> np.ndarray:
        """Numbers in LZ4 blocks after their whole size, each after its size and its compressed size. (count,) float64"""
        size = struct.unpack("<Q", self.take(8, what))[0]
        if size != 8 * count:
            self.fail(f"has {size} bytes of {what}, expected {8 * count}")
        found = bytearray()
        while len(found) < size:
            part = self.whole(f"the size of a block of {what}", 1, size - len(found))
            stored = struct.unpack("<I", self.take(4, what))[0]
            self._hold(part, stored, "lz4", what)
            unpacked = unpack_lz4(self.take(stored, what), part)
            if unpacked is None:
                self.fail(f"cannot unpack {what}; it is damaged")
            found += unpacked
        return self._counted(bytes(found), count, what)

    def _hold(self, size: int, stored: int, method: str, what: str) -> None:
        """Refuse what cannot be before it is unpacked."""
        self._held += size
        if size > MOST_GROWTH[method] * stored + 64 or self._held > MOST_BYTES:
            self.fail(f"states {size} bytes of {what} in {stored} compressed ones, which cannot be")

    def _counted(self, found: bytes, count: int, what: str) -> np.ndarray:
        if len(found) != 8 * count:
            self.fail(f"has {len(found)} bytes of {what}, expected {8 * count}")
        return self._finite(found, what)

    def _finite(self, found: bytes, what: str) -> np.ndarray:
        values = np.frombuffer(found, "<f8").astype(np.float64)
        # A comparison with NaN is false.
        if not (np.abs(values) <= LARGEST).all():
            self.fail(f"has {what} that are no numbers up to {LARGEST:g}")
        return values


def unpack_lz4(data: bytes, size: int) -> bytes | None:
    """Unpack one LZ4 block of a known size; None where it is damaged.

    References
    ----------
    LZ4 Block Format Description, https://github.com/lz4/lz4/blob/dev/doc/lz4_Block_format.md
    """
    found, at, end = bytearray(), 0, len(data)

    def length(value):
        """A length of four bits, with the bytes that go on with it."""
        nonlocal at
        if value == 15:
            more = 255
            while more == 255 and at < end and value <= size:
                more = data[at]
                value += more
                at += 1
        return value

    while at < end:
        token = data[at]
        at += 1
        plain = length(token >> 4)
        found += data[at : at + plain]
        at += plain
        if at >= end:
            break
        back = int.from_bytes(data[at : at + 2], "little")
        at += 2
        count = length(token & 15) + 4
        if not 0 < back <= len(found) or len(found) + count > size:
            return None
        # What is copied may run into what the copy makes.
        piece = found[len(found) - back : len(found) - back + count]
        found += (piece * (count // len(piece) + 1))[:count]
    return bytes(found) if at == end and len(found) == size else None
