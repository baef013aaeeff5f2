"""Bytes of photometric files as text and numbers, by rules that hold for all of their formats."""

import math
from pathlib import Path

from ..errors import FileFormatError

MAXIMUM_SIZE = 64 << 20
"""Largest file that is read. [byte]"""

END_OF_FILE = "\x1a"
"""Ctrl-Z, with which old programs end a text."""


def read_bytes(path, most: int = MAXIMUM_SIZE) -> bytes:
    """Return the content of a file of at most so many bytes.

    Raises
    ------
    FileFormatError    It cannot be opened or is too large.
    """
    path = Path(path)
    try:
        size = path.stat().st_size
        if size > most:
            raise FileFormatError(path, f"has {size >> 20} MiB, expected at most {most >> 20} MiB")
        return path.read_bytes()
    except OSError as error:
        raise FileFormatError(path, f"cannot be opened ({error.strerror})") from None


def decode(path, data: bytes) -> str:
    """Return the text: UTF-8 or else Latin-1, lines ended by a line feed, nothing from the first Ctrl-Z on, no NUL.

    Raises
    ------
    FileFormatError    It is empty, or UTF-16.
    """
    if data[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        raise FileFormatError(path, "is UTF-16 text; save it as UTF-8 or ANSI")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    text = text.split(END_OF_FILE, 1)[0].replace("\0", "")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if not text.strip():
        raise FileFormatError(path, "is empty")
    return text


def parse_number(token: str) -> float | None:
    """Return the number that a token stands for, None if it is none or not finite. Fortran's D exponents are taken.

    Python's own extras (``1_000``, ``infinity``, digits of other scripts) are not numbers here.
    """
    if not token.isascii() or "_" in token:
        return None
    try:
        value = float(token.replace("D", "e").replace("d", "e"))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def parse_whole(token: str) -> int | None:
    """Return the whole number that a token stands for, ``3.0`` included; None if it is none."""
    value = parse_number(token)
    if value is None or abs(value) > 1e9 or abs(value - round(value)) > 1e-6:
        return None
    return round(value)
