"""Whether an OpenEXR file is whole, by its header and its table of blocks; libraries read what is missing as black.

References
----------
OpenEXR file layout, Academy Software Foundation, https://openexr.com/en/latest/OpenEXRFileLayout.html
"""

import struct

import numpy as np

from ..errors import FileFormatError

MAGIC = b"\x76\x2f\x31\x01"
"""How such a file begins."""

TILED, OTHERS = 0x200, 0x1800
"""Flags of the version: of tiles, and of deep pixels and several parts."""

LINES = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256}
"""Rows of a block by the number of its compression."""

LARGEST = 1 << 28
"""Pictures are never larger than this. [pixel]"""


def check_whole(path, data: bytes) -> None:
    """Refuse a file that ends early, or that is no single flat picture.

    Parameters
    ----------
    path : str or Path    For errors.
    data : bytes    The whole file.

    Raises
    ------
    FileFormatError    Says which.
    """
    if not data.startswith(MAGIC) or len(data) < 8:
        raise FileFormatError(path, "expected an OpenEXR file")
    flags = struct.unpack_from("<I", data, 4)[0]
    if flags & OTHERS:
        raise FileFormatError(path, "has several parts or deep pixels, expected one flat picture")
    attributes, start = _read_header(path, data)
    try:
        x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
        compression = attributes["compression"][0]
        lines = LINES[compression]
    except (KeyError, IndexError, struct.error):
        raise FileFormatError(
            path, "its header lacks a window of data, or a known compression"
        ) from None
    width, height = x1 - x0 + 1, y1 - y0 + 1
    if not (width > 0 and height > 0 and width * height <= LARGEST):
        raise FileFormatError(path, f"{width} x {height} pixels, expected 1 to {LARGEST}")
    if flags & TILED:
        count, head = _count_tiles(path, attributes, width, height), 20
    else:
        count, head = -(-height // lines), 8
    table = np.frombuffer(data, "<u8", min(count, max(len(data) - start, 0) // 8), start)
    if len(table) < count:
        raise FileFormatError(path, "ends early, in its table of blocks")
    for place in table:
        last = int(place) + head
        size = (
            struct.unpack_from("<i", data, last - 4)[0] if place > 0 and last <= len(data) else -1
        )
        if size < 0 or last + size > len(data):
            raise FileFormatError(path, "ends early: blocks of its pixels are missing")


def _read_header(path, data: bytes) -> tuple[dict[str, bytes], int]:
    """Return the attributes of a header and where it ends."""
    attributes, place = {}, 8
    while True:
        end = data.find(b"\0", place, place + 256)
        if end < 0:
            raise FileFormatError(path, "ends early, in its header")
        if end == place:
            return attributes, place + 1
        kind = data.find(b"\0", end + 1, end + 257)
        if kind < 0 or kind + 5 > len(data):
            raise FileFormatError(path, "ends early, in its header")
        size = struct.unpack_from("<I", data, kind + 1)[0]
        value = data[kind + 5 : kind + 5 + size]
        if len(value) < size:
            raise FileFormatError(path, "ends early, in its header")
        attributes[data[place:end].decode("latin-1")] = value
        place = kind + 5 + size


def _count_tiles(path, attributes, width: int, height: int) -> int:
    """Return the number of tiles of the finest level, whose blocks come first."""
    try:
        across, down, _ = struct.unpack("<2IB", attributes["tiles"])
    except (KeyError, struct.error):
        across = down = 0
    if not (across and down):
        raise FileFormatError(path, "its header lacks the size of its tiles")
    return -(-width // across) * -(-height // down)
