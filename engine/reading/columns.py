"""Tables of numbers as instruments and spreadsheets write them: a head of keywords, names of columns, then rows."""

import re
from dataclasses import dataclass

import numpy as np

from ..errors import FileFormatError
from .text import parse_number

MOST_ROWS = 1_000_000
"""Rows that a table may have."""

MOST_COLUMNS = 2000
"""Columns that a table may have."""

MISSING = {"", "-", "--", "nan", "n/a", "na", "none"}
"""What stands, in lower case, where nothing was measured."""

_KEYWORD = re.compile(r"^[#\s]*([A-Za-z][A-Za-z0-9 _-]*?)\s*[:=]\s*(.*?)[\s,;]*$")

_WAVELENGTH = re.compile(r"^(?:nm|l|lambda|w|r|f)?_?(\d+(?:\.\d+)?)_?(?:nm)?$")

_UNITS = re.compile(r"_(?:deg|degree|degrees|rad|radian|radians)$")


@dataclass(frozen=True, eq=False)
class Columns:
    """A table of numbers.

    Parameters
    ----------
    path : str or Path    For messages.
    head : dict of str to str    Keywords in lower case, their values as written.
    names : tuple of str    Of the columns: lower case, other signs as underscores, without units of angles.
    values : (n, c) float64 array    nan where nothing stands.
    lines : (n,) int array    Of the file, from 1.
    """

    path: object
    head: dict[str, str]
    names: tuple[str, ...]
    values: np.ndarray
    lines: np.ndarray

    def fail(self, message: str, row: int | None = None):
        """Refuse the file, because of a row if one is told."""
        line = int(self.lines[row]) if row is not None else None
        raise FileFormatError(self.path, message, line)

    def find(self, *synonyms: str) -> np.ndarray | None:
        """The column with one of the names, the first one first; None: there is none. (n,)"""
        for name in synonyms:
            if name in self.names:
                return self.values[:, self.names.index(name)]
        return None

    def number(self, key: str, default: float, low: float, high: float) -> float:
        """A number of the head, within bounds."""
        if key not in self.head:
            return default
        value = parse_number(self.head[key].split()[0]) if self.head[key].split() else None
        if value is None or not low <= value <= high:
            self.fail(f"states '{key}: {self.head[key][:40]}', expected {low:g} to {high:g}")
        return value


def wavelength_of(name: str) -> float | None:
    """Wavelength that the name of a column states, None: it states none. [nm]"""
    found = _WAVELENGTH.match(name)
    return float(found[1]) if found and 100.0 <= float(found[1]) <= 1e5 else None


def name_columns(line: str) -> tuple[str | None, tuple[str, ...]]:
    """What parts the columns of a line that names them (None: blanks), and their names."""
    line = line.strip().lstrip("#").strip()
    mark = next((mark for mark in ";\t," if mark in line), None)
    names = (re.sub(r"[^a-z0-9.]+", "_", token.lower()).strip("_") for token in line.split(mark))
    return mark, tuple(_UNITS.sub("", name) for name in names)


def read_keyword(line: str) -> tuple[str, str] | None:
    """Keyword in lower case and value of a line like ``# key: value``; None: it is none."""
    found = _KEYWORD.match(line)
    return (found[1].lower().replace("_", " ").strip(), found[2].strip()) if found else None


def parse_columns(lines: list[str], first: int, path, head: dict, mark, names) -> Columns:
    """Read the rows of a table.

    Parameters
    ----------
    lines : list of str    Of the whole file.
    first : int    Number of the first line of the rows, from 0.
    path : str or Path    For messages.
    head : dict
    mark : str or None    What parts columns; with ``;`` and tabs a comma is the decimal sign.
    names : tuple of str    Of the columns.

    Raises
    ------
    FileFormatError    A row has another number of columns, or something that is no number; or there are none, or too many.
    """
    if len(names) > MOST_COLUMNS:
        raise FileFormatError(path, f"has {len(names)} columns, expected at most {MOST_COLUMNS}")
    twice = next((name for name in names if name and names.count(name) > 1), None)
    if twice is not None:
        raise FileFormatError(path, f"has two columns named '{twice[:40]}'", first)
    rows, numbers = [], []
    for number, line in enumerate(lines[first:], start=first + 1):
        text = line.strip(" \r\n")
        if not text.strip() or text.lstrip().startswith("#"):
            continue
        rows.append(_parse_row(text, number, path, mark, len(names)))
        numbers.append(number)
        if len(rows) > MOST_ROWS:
            raise FileFormatError(path, f"has more than {MOST_ROWS} rows", number)
    if not rows:
        raise FileFormatError(path, "has names of columns, but no rows of numbers")
    return Columns(path, head, names, np.array(rows, dtype=np.float64), np.array(numbers))


def _parse_row(text: str, number: int, path, mark, count: int) -> list[float]:
    tokens = text.split(mark)
    while len(tokens) > count and not tokens[-1].strip():
        tokens.pop()
    if len(tokens) != count:
        raise FileFormatError(path, f"has {len(tokens)} columns, expected {count}", number)
    return [_parse_token(token.strip(), number, path, mark) for token in tokens]


def _parse_token(token: str, number: int, path, mark) -> float:
    if token.lower() in MISSING:
        return np.nan
    if mark in {";", "\t"}:
        token = token.replace(",", ".")
    value = parse_number(token)
    if value is None:
        raise FileFormatError(path, f"has '{token[:40]}', expected a number", number)
    return value
