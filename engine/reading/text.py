"""Bytes of files from outside as text, whoever wrote them, and text as numbers."""

import codecs
import math

from ..errors import FileFormatError

END_OF_FILE = "\x1a"
"""Ctrl-Z, with which old programs end a text."""

MARK = "\ufeff"
"""Byte-order mark, with which texts in Unicode may begin."""

LOOKED_AT = 1 << 16
"""First bytes that tell UTF-16 without a mark. [byte]"""


def find_encoding(data: bytes, is_whole: bool = True) -> str:
    """Return the encoding of a text: decoding with it never fails and, of a whole text, is undone by encoding.

    UTF-16 has a mark, or NUL in every other byte as Western text in it does. What else is not UTF-8 is taken for
    Windows-1252, which programs of the trade write; it has all signs of Latin-1 and some where that has but control
    characters. With one of the five bytes that it leaves undefined it is Latin-1, whose every byte means something. A mark
    stays in the text.

    Parameters
    ----------
    data : bytes
    is_whole : bool    Whether the text ends where they do; its beginning may end within a character.
    """
    for encoding in (_find_utf16(data), "utf-8", "cp1252"):
        try:
            if encoding is not None:
                codecs.getincrementaldecoder(encoding)().decode(data, final=is_whole)
                return encoding
        except UnicodeDecodeError:
            continue
    return "latin-1"


def _find_utf16(data: bytes) -> str | None:
    if data[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        return "utf-16-le" if data[:1] == b"\xff" else "utf-16-be"
    head = data[:LOOKED_AT]
    zeros = head[0::2].count(0), head[1::2].count(0)
    if len(head) < 16 or max(zeros) <= 0.45 * len(head):
        return None
    return "utf-16-be" if zeros[0] > zeros[1] else "utf-16-le"


def decode_text(data: bytes, most: int | None = None) -> str:
    """Return a text without a mark: lines ended by a line feed, nothing from the first Ctrl-Z on, no NUL.

    ``most``: only so many of its first bytes are looked at.
    """
    head = data[:most]
    text = head.decode(find_encoding(head, len(head) == len(data)), "ignore")
    text = text.removeprefix(MARK).split(END_OF_FILE, 1)[0].replace("\0", "")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def decode(path, data: bytes) -> str:
    """Return a text as `decode_text` does.

    Raises
    ------
    FileFormatError    It is empty.
    """
    text = decode_text(data)
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
