"""Distribution files of ASAP (.dis) that hold rays."""

from ..errors import FileFormatError
from ..reading.remarks import Remark
from .binary import Head, check_count, read_rows
from .record import RADIANT, UNITS, Columns, RayFile

HEAD, MARK = 140, 247
"""Five records of 28 bytes; the first number is `MARK` plus 1024 times the words of a row."""

WORDS = {7: 7, 9: 9}


def is_asap(head: Head) -> bool:
    """Whether a file begins with the mark of one."""
    return (
        len(head.data) >= HEAD
        and head.number("i", 0) % 1024 == MARK
        and head.number("i", 0) // 1024 in WORDS
    )


def read_asap(path) -> RayFile:
    """Read the head of a distribution file.

    Raises
    ------
    FileFormatError    It is cut short or holds a grid of values.
    """
    head = Head(path, HEAD)
    words = head.number("i", 0) // 1024
    # The fourth record: the label, both limits, and the number.
    number = head.number("i", 3 * 28 + 24)
    if number >= 0:
        raise FileFormatError(path, f"holds a grid of {number} rows of values, expected rays")
    check_count(path, -number)
    size = 4 * words * -number
    head.expect_length(HEAD + size, f"{-number} rays of {words} numbers after {HEAD} bytes of head")
    return RayFile(
        head.path,
        "ASAP",
        -number,
        Columns(words, 0, 3, 6),
        lambda: read_rows(path, HEAD, -number, words),
        UNITS["mm"],
        RADIANT,
        metadata={"TITLE": head.text(28, 24)} if head.text(28, 24) else {},
        remarks=(Remark("does not tell its unit of length; taken as mm"),),
    )
