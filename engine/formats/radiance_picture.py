"""Radiance pictures (.hdr, .pic): what their header says, and their pixels.

References
----------
G. Ward: Radiance file formats, "Picture", in: G. Ward Larson, R. Shakespeare, Rendering with Radiance, 1998; its header
lines EXPOSURE and COLORCORR are multipliers that the pixels carry, and count together. PIXASPECT changes nothing here: a
picture fills its sphere or its square of UV whatever the shape of its pixels.
"""

import math
import re
from dataclasses import dataclass

import numpy as np

from ..errors import FileFormatError
from ..photometry.colour import XYZ_TO_REC709

MAGIC = b"#?"
"""How such a file begins."""

MAXIMUM_HEADER = 1 << 20
"""Headers are never longer than this. [byte]"""

MAXIMUM_PIXELS = 1 << 28
"""Pictures are never larger than this."""

LINES_AT_ONCE = 256
"""Rows that are decoded together, so that large pictures need little memory beside their own."""

PLAIN = "-Y +X"
"""The usual order: rows from the top down, each from left to right."""

RGBE, XYZE = "32-bit_rle_rgbe", "32-bit_rle_xyze"

REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
"""Chromaticities x, y of red, green, blue and white. (ITU-R BT.709)"""

_RESOLUTION = re.compile(rb"([+-][XY])[ \t]+(\d{1,9})[ \t]+([+-][XY])[ \t]+(\d{1,9})[ \t]*\r?\n")


@dataclass(frozen=True)
class Header:
    """What the header of a picture says.

    Parameters
    ----------
    encoding : str    What FORMAT says, empty without one.
    exposure : float    All EXPOSURE lines multiplied. [-]
    correction : (float, float, float)    All COLORCORR lines multiplied. [-]
    primaries : tuple of 8 float or None    What PRIMARIES says, None without one or where it is all 0.
    gamma : float    What GAMMA says. [-]
    order : str    Such as ``-Y +X``: where rows lie, and where the pixels of a row.
    lines, length : int    Number of rows as stored, and pixels of each.
    start : int    Where the pixels begin. [byte]
    """

    encoding: str
    exposure: float
    correction: tuple[float, float, float]
    primaries: tuple[float, ...] | None
    gamma: float
    order: str
    lines: int
    length: int
    start: int


def read_header(data: bytes, path) -> Header:
    """Read the header of a Radiance picture.

    Parameters
    ----------
    data : bytes    The file, or its first `MAXIMUM_HEADER` bytes.
    path : str or Path    For errors.

    Raises
    ------
    FileFormatError    It is no such picture, or a line cannot be understood.
    """
    end = re.search(rb"\r?\n\r?\n", data[:MAXIMUM_HEADER])
    if not data.startswith(MAGIC) or end is None:
        raise FileFormatError(
            path, "expected a Radiance picture: '#?RADIANCE', lines and an empty line"
        )
    lines = data[: end.start()].split(b"\n")
    # Indented lines tell of the pictures that this one was made of.
    told = [
        (number, *(part.strip() for part in line.split(b"=", 1)))
        for number, line in enumerate(lines, start=1)
        if re.match(rb"[A-Z]+=", line)
    ]
    stated = {key: text.decode("latin-1") for _, key, text in told}
    exposure, correction = 1.0, np.ones(3)
    for number, key, text in told:
        if key == b"EXPOSURE":
            exposure *= float(_numbers(path, number, key, text, 1)[0])
        elif key == b"COLORCORR":
            correction = correction * _numbers(path, number, key, text, 3)
    if not (math.isfinite(exposure) and exposure > 0.0 and np.isfinite(correction).all()):
        raise FileFormatError(path, "its EXPOSURE and COLORCORR lines multiply to no usable number")
    found = _RESOLUTION.match(data, end.end())
    number = len(lines) + 2
    if found is None or found[1][1:] == found[3][1:]:
        raise FileFormatError(path, "expected a size such as '-Y 512 +X 1024'", number)
    count, length = int(found[2]), int(found[4])
    if not 0 < count * length <= MAXIMUM_PIXELS:
        raise FileFormatError(
            path, f"{length} x {count} pixels, expected 1 to {MAXIMUM_PIXELS}", number
        )
    return Header(
        stated.get(b"FORMAT", ""),
        exposure,
        tuple(float(each) for each in correction),
        _primaries(stated.get(b"PRIMARIES")),
        _gamma(stated.get(b"GAMMA")),
        f"{found[1].decode()} {found[3].decode()}",
        count,
        length,
        found.end(),
    )


def _numbers(path, number: int, key: bytes, text: bytes, count: int) -> np.ndarray:
    """Return numbers above 0 of a header line."""
    try:
        values = np.array([float(each) for each in text.split()])
    except ValueError:
        values = np.zeros(0)
    if len(values) != count or not (np.isfinite(values) & (values > 0.0)).all():
        raise FileFormatError(
            path,
            f"{key.decode()} is '{text[:60].decode('latin-1')}', expected {count} number{'s'[: count > 1]} above 0",
            number,
        )
    return values


def _primaries(text: str | None) -> tuple[float, ...] | None:
    try:
        values = tuple(float(each) for each in (text or "").split())
    except ValueError:
        return None
    # Some programs write eight zeros.
    return values if len(values) == 8 and any(values) else None


def _gamma(text: str | None) -> float:
    try:
        return float(text or 1.0)
    except ValueError:
        return 1.0


def decode(data: bytes, header: Header, path) -> np.ndarray:
    """Decode the pixels of a Radiance picture.

    Parameters
    ----------
    data : bytes    The whole file.
    header : Header    Of this file.
    path : str or Path    For errors.

    Returns
    -------
    (height, width, 3) float32 array
        Linear Rec. 709, row 0 at the bottom, as stored: exposure and correction are still in. Of XYZE the luminance is Y.

    Raises
    ------
    FileFormatError    The file ends early, or its encoding is unknown.
    """
    if header.encoding not in {RGBE, XYZE, ""}:
        raise FileFormatError(
            path, f"FORMAT is '{header.encoding[:60]}', expected {RGBE} or {XYZE}"
        )
    # A run of 127 equal bytes takes two, so nothing is stored in less than this.
    if header.lines * header.length * 4 > 64 * (len(data) - header.start):
        raise FileFormatError(
            path,
            f"ends early: {header.length} x {header.lines} pixels need more than {len(data)} bytes",
        )
    stored = np.empty((header.lines, header.length, 4), dtype=np.uint8)
    place = header.start
    for line in stored:
        place = _read_line(data, place, line, path)
    pixels = np.empty((*stored.shape[:2], 3), dtype=np.float32)
    first, second = header.order.split()
    # Row 0 is to be the bottom one, column 0 the left one.
    rows = pixels[::-1] if first[0] == "-" else pixels
    rows = rows[:, ::-1] if second[0] == "-" else rows
    for start in range(0, header.lines, LINES_AT_ONCE):
        part = stored[start : start + LINES_AT_ONCE]
        scale = np.ldexp(np.float32(1.0), part[..., 3].astype(np.int32) - 136)
        scale[part[..., 3] == 0] = 0.0
        values = part[..., :3] * scale[..., None]
        if header.encoding == XYZE:
            values = values @ XYZ_TO_REC709.T.astype(np.float32)
        rows[start : start + LINES_AT_ONCE] = values
    return pixels if first[1] == "Y" else np.ascontiguousarray(pixels.transpose(1, 0, 2))


def _read_line(data: bytes, place: int, line: np.ndarray, path) -> int:
    """Read a row of (length, 4) bytes; return where the next begins."""
    length = len(line)
    begins = bytes((2, 2, length >> 8 & 255, length & 255))
    if 8 <= length < 32768 and data[place : place + 4] == begins:
        return _read_runs(data, place + 4, line, path)
    flat = np.frombuffer(data, np.uint8, min(4 * length, len(data) - place), place)
    # As numbers of four bytes: three of 1 are a repeat, whatever the exponent.
    if len(flat) == 4 * length and not ((flat.view("<u4") & 0xFFFFFF) == 0x010101).any():
        line[:] = flat.reshape(-1, 4)
        return place + 4 * length
    return _read_repeats(data, place, line, path)


def _read_runs(data: bytes, place: int, line: np.ndarray, path) -> int:
    """Read a row whose four components are packed in runs, one after the other."""
    length = len(line)
    for component in range(4):
        row = bytearray()
        while len(row) < length:
            code = data[place] if place < len(data) else 0
            if code > 128:
                row += data[place + 1 : place + 2] * (code - 128)
                place += 2
            else:
                row += data[place + 1 : place + 1 + code]
                place += 1 + code
            if code == 0 or place > len(data) or len(row) > length:
                raise FileFormatError(path, f"its pixels are damaged or end early at byte {place}")
        line[:, component] = np.frombuffer(row, np.uint8)
    return place


def _read_repeats(data: bytes, place: int, line: np.ndarray, path) -> int:
    """Read a row in which the pixel 1, 1, 1, n says that the one before comes n times more."""
    done, shift = 0, 0
    while done < len(line):
        pixel = data[place : place + 4]
        if len(pixel) < 4:
            raise FileFormatError(path, f"its pixels end early at byte {place}")
        place += 4
        if pixel[:3] != b"\1\1\1":
            line[done] = tuple(pixel)
            done, shift = done + 1, 0
            continue
        count = pixel[3] << shift
        if done == 0 or shift > 24 or done + count > len(line):
            raise FileFormatError(path, f"its pixels are damaged at byte {place - 4}")
        line[done : done + count] = line[done - 1]
        done, shift = done + count, shift + 8
    return place
