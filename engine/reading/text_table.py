"""Columns of numbers in text files, as spreadsheets and instruments write them."""

import re
from dataclasses import dataclass

from ..errors import FileFormatError
from .text import decode_text

MAXIMUM_BYTES = 16 << 20
"""A table is never larger than this; anything larger is another kind of file."""

MAXIMUM_ROWS = 200_000

MAXIMUM_COLUMNS = 1_000

_DECIMAL_COMMA = re.compile(r"[+-]?\d+(,\d+)?([eEdD][+-]?\d+)?")
"""A number without a point, where blanks separate."""

_COMMENT = re.compile(r"^\s*(#|//|;|%|!)")


@dataclass(frozen=True)
class TextTable:
    """Rows of numbers.

    Parameters
    ----------
    rows : list of (int, list of float or None)    Number of the line, and what stands in it; None where a field is empty.
    headings : list of str    Of the columns, from the line before the first row; empty where that names not as many.
    """

    rows: list[tuple[int, list[float | None]]]
    headings: list[str]


def parse_rows(path, data: bytes, count: int, expected: str) -> list[tuple[int, ...]]:
    """Rows of the first so many numbers, each with the number of its line in front; as `parse_table`.

    Raises
    ------
    FileFormatError    As of `parse_table`, or a field is empty.
    """
    rows = []
    for line, values in parse_table(path, data, count, expected).rows:
        if None in values[:count]:
            raise FileFormatError(path, f"expected {expected}, found an empty field", line)
        rows.append((line, *values[:count]))
    return rows


def parse_table(path, data: bytes, least: int, expected: str) -> TextTable:
    """Rows of numbers.

    Columns are separated by blanks, tabs, commas or semicolons (with semicolons or tabs a comma is the decimal sign). Lines
    before the first row of numbers are a heading; lines that begin with ``#``, ``//``, ``;``, ``%`` or ``!`` are comments.

    Parameters
    ----------
    path : str or Path    For errors.
    data : bytes
    least : int    Columns that there have to be.
    expected : str    What stands in them, for errors.

    Raises
    ------
    FileFormatError    After the first row a line has no numbers, or too few; or there are too many rows or columns.
    """
    rows, headings = [], []
    for number, line in enumerate(decode_text(data).split("\n"), start=1):
        if not line.strip() or _COMMENT.match(line):
            continue
        fields = _fields(line)
        values = _numbers(fields)
        if values is None or len(values) < least:
            if rows:
                raise FileFormatError(
                    path, f"expected {expected}, found '{line.strip()[:60]}'", number
                )
            headings = fields
            continue
        if len(values) > MAXIMUM_COLUMNS:
            raise FileFormatError(path, f"more than {MAXIMUM_COLUMNS} columns", number)
        rows.append((number, values))
        if len(rows) > MAXIMUM_ROWS:
            raise FileFormatError(path, f"more than {MAXIMUM_ROWS} rows", number)
    fits = rows and len(headings) == len(rows[0][1])
    return TextTable(rows, [name.strip("\"' ") for name in headings] if fits else [])


def _fields(line: str) -> list[str]:
    """Fields of a row; empty ones count where a sign separates them, but for those at the end."""
    if ";" in line or "\t" in line:
        fields = [field.strip().replace(",", ".") for field in re.split(r"[;\t]", line)]
    else:
        fields = [field.strip() for field in line.split(",")]
    while fields and not fields[-1]:
        fields.pop()
    if len(fields) == 1 or any(_numbers(field.split()) for field in fields if " " in field):
        # Blanks separate, or they do beside another sign.
        words = line.split()
        if all(_DECIMAL_COMMA.fullmatch(word) for word in words):
            return [word.replace(",", ".") for word in words]
        return re.split(r"[,;\s]+", line.strip().strip(",;"))
    return fields


def _numbers(fields: list[str]) -> list[float | None] | None:
    """Numbers of a row, None for an empty field; None for all when any other field is not a number."""
    try:
        return [
            float(re.sub(r"[dD](?=[+-]?\d)", "e", field)) if field else None for field in fields
        ]
    except ValueError:
        return None
