"""Content of photometric files as text and numbers, by rules that hold for all of their formats."""

import math

from ..errors import FileFormatError

END_OF_FILE = "\x1a"
"""Ctrl-Z, with which old programs end a text."""


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
