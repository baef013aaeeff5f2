"""Columns of numbers in text files, as spreadsheets and instruments write them."""

import re

from ..errors import FileFormatError

MAXIMUM_BYTES = 16 << 20
"""A table is never larger than this; anything larger is another kind of file."""

MAXIMUM_ROWS = 200_000

_COMMENT = re.compile(r"^\s*(#|//|;|%|!)")


def parse_rows(path, data: bytes, count: int, expected: str) -> list[tuple[int, ...]]:
    """Rows of numbers, each with the number of its line in front.

    Columns are separated by blanks, tabs, commas or semicolons (with semicolons or tabs a comma is the decimal sign). Lines
    before the first row of numbers are a heading; lines that begin with ``#``, ``//``, ``;``, ``%`` or ``!`` are comments.

    Parameters
    ----------
    path : str or Path    For errors.
    data : bytes    UTF-8 or Windows' Latin text.
    count : int    Columns to be read; more are ignored.
    expected : str    What stands in them, for errors.

    Raises
    ------
    FileFormatError    After the first row a line has no numbers, or too few; or there are too many rows.
    """
    rows = []
    for number, line in enumerate(_decode(path, data).splitlines(), start=1):
        if not line.strip() or _COMMENT.match(line):
            continue
        values = _numbers(line)
        if values is None or len(values) < count:
            if rows:
                raise FileFormatError(
                    path, f"expected {expected}, found '{line.strip()[:60]}'", number
                )
            continue
        rows.append((number, *values[:count]))
        if len(rows) > MAXIMUM_ROWS:
            raise FileFormatError(path, f"more than {MAXIMUM_ROWS} rows", number)
    return rows


def _decode(path, data: bytes) -> str:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise FileFormatError(path, "UTF-16 text, save it as UTF-8")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def _numbers(line: str) -> list[float] | None:
    """Numbers of a row, None when any field is not a number."""
    if ";" in line or "\t" in line:
        fields = [f.strip().replace(",", ".") for f in re.split(r"[;\t]", line) if f.strip()]
        if len(fields) == 1:
            fields = fields[0].split()
    else:
        fields = re.split(r"[,\s]+", line.strip().strip(","))
    try:
        return [float(re.sub(r"[dD](?=[+-]?\d)", "e", f)) for f in fields]
    except ValueError:
        return None
