"""The numbers of an LM-63 file: a stream of tokens that remembers its lines."""

import re

import numpy as np

from ....errors import FileFormatError
from ....reading.text import parse_number, parse_whole

_PLAIN = re.compile(r"[0-9eE+\-. ]*")
"""What ordinary numbers are made of; anything else takes the slower, stricter way."""

_THOUSANDS = re.compile(r"-?[1-9]\d{0,2}(,\d{3})+")


class Numbers:
    """Tokens from some line of a file on, taken one after the other.

    Parameters
    ----------
    path : str or Path    For messages.
    lines : list of str
    first_line : int    Number of the first of the lines in the file, from 1.
    decimal_comma : bool    Commas are decimal signs; else they separate, like blanks.
    """

    def __init__(self, path, lines, first_line=1, decimal_comma=False):
        comma = "." if decimal_comma else " "
        rows = [line.replace(",", comma).split() for line in lines]
        self.path = path
        self.tokens = [token for row in rows for token in row]
        self.decimal_comma = decimal_comma
        self.position = 0
        self._first_line = first_line
        self._ends = np.cumsum([len(row) for row in rows], dtype=np.int64)

    @property
    def remaining(self) -> int:
        """How many tokens have not been taken."""
        return len(self.tokens) - self.position

    def line(self, index: int | None = None) -> int:
        """Return the number of the line on which a token stands; the next one's if none is given."""
        index = min(self.position if index is None else index, len(self.tokens) - 1)
        row = int(np.searchsorted(self._ends, index, side="right")) if self.tokens else 0
        return self._first_line + row

    @property
    def last_line(self) -> int:
        """The line of the token that was taken last."""
        return self.line(self.position - 1)

    def tokens_on_line(self, index: int) -> int:
        """Return how many tokens stand on the line of a token."""
        row = self.line(index) - self._first_line
        return int(self._ends[row] - (self._ends[row - 1] if row else 0))

    def fail(self, message: str, index: int | None = None):
        """Raise a `FileFormatError` at a token, the next one if none is given."""
        raise FileFormatError(self.path, message, self.line(index))

    def reject(self, message: str):
        """Raise a `FileFormatError` at the token that was taken last."""
        self.fail(message, self.position - 1)

    def number(self, what: str) -> float:
        """Take a number.

        Raises
        ------
        FileFormatError    The file ends, or there is no finite number.
        """
        return self._take(what, parse_number, "a number")

    def whole(self, what: str) -> int:
        """Take a whole number, which may be written ``3.0``; raises as `number` does."""
        return self._take(what, parse_whole, "a whole number")

    def _take(self, what, parse, kind):
        if not self.remaining:
            self.fail(f"the file ends, expected {what}")
        token = self.tokens[self.position]
        value = parse(token)
        if value is None:
            self.fail(f"expected {kind} for {what}, found '{token[:40]}'")
        self.position += 1
        return value

    def numbers(self, count: int, what: str) -> np.ndarray:
        """Take several numbers as an array (count,); raises as `number` does, with how many were found."""
        start, self.position = self.position, min(self.position + count, len(self.tokens))
        taken = self.tokens[start : self.position]
        values = _convert(taken)
        if len(values) < len(taken):
            at = start + len(values)
            self.fail(f"expected a number for {what}, found '{self.tokens[at][:40]}'", at)
        if len(values) < count:
            self.fail(f"expected {count} {what}, found {len(values)} before the file ends")
        return values


def _convert(tokens) -> np.ndarray:
    """Return the numbers up to the first token that is none."""
    if _PLAIN.fullmatch(" ".join(tokens)):
        try:
            values = np.fromiter(map(float, tokens), np.float64, len(tokens))
        except ValueError:
            pass  # something like 1.2.3, which the other way finds
        else:
            if np.isfinite(values).all():
                return values
    values = []
    for token in tokens:
        value = parse_number(token)
        if value is None:
            break
        values.append(value)
    return np.array(values, dtype=np.float64)


def commas_may_be_decimal(lines) -> bool:
    """Whether there are commas inside numbers, and not all of them could separate thousands."""
    inside = [token for line in lines if "," in line for token in line.split() if "," in token]
    return any(not _THOUSANDS.fullmatch(token) for token in inside)
