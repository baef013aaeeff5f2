"""Texts of scattering files as words and numbers, each with the line that it stands in."""

import numpy as np

from ..errors import FileFormatError
from .content import MAXIMUM_SIZE
from .text import decode, parse_number, parse_whole

SHOWN = 40
"""Characters of a word that messages quote."""


LARGEST = 1e9
"""No number in these files means anything beyond it."""


class Words:
    """A text, read from its beginning on.

    Parameters
    ----------
    data : bytes
    path : str or Path    For messages.
    comment : str    What comment lines begin with; empty: there are none.
    """

    def __init__(self, data: bytes, path, comment: str = ""):
        self.path = path
        if len(data) > MAXIMUM_SIZE:
            raise FileFormatError(
                path,
                f"has {len(data) >> 20} MiB of text, expected at most {MAXIMUM_SIZE >> 20} MiB",
            )
        self._lines = decode(path, data).split("\n")
        if comment:
            self._lines = ["" if s.lstrip().startswith(comment) else s for s in self._lines]
        self._room = sum(len(each) + 1 for each in self._lines)
        self._words: list[str] = []
        self._at = 0
        self.line = 0

    def fail(self, message: str):
        """Refuse the file for what stands in the line that was read last."""
        raise FileFormatError(self.path, message, max(self.line, 1))

    def read_line(self) -> str:
        """The next whole line; what is left of the one before is dropped. Empty at the end."""
        self._words, self._at = [], 0
        if self.line >= len(self._lines):
            return ""
        self.line += 1
        return self._lines[self.line - 1].strip()

    def read_characters(self, count: int) -> str:
        """Characters from the beginning of the next line on, and to the end of the line in which they end."""
        found = ""
        while len(found) < count and self.line < len(self._lines):
            found += ("\n" if found else "") + self._lines[self.line]
            self.line += 1
        self._words, self._at = [], 0
        return found[:count].strip()

    def peek(self) -> str:
        """The next word; empty at the end."""
        while self._at >= len(self._words) and self.line < len(self._lines):
            self._words, self._at = self._lines[self.line].split(), 0
            self.line += 1
        return self._words[self._at] if self._at < len(self._words) else ""

    def peek_row(self) -> int:
        """How many words are left in the line of the next one."""
        self.peek()
        return len(self._words) - self._at

    def word(self, what: str) -> str:
        """The next word; ``what`` says for messages what it should be."""
        found = self.peek()
        if not found:
            self.fail(f"ends before {what}")
        self._at += 1
        return found

    def number(self, what: str, low: float = -np.inf, high: float = np.inf) -> float:
        """The next word as a number within limits."""
        word = self.word(what)
        value = parse_number(word)
        if value is None or not low <= value <= high:
            limits = "" if np.isinf(low) or np.isinf(high) else f" from {low:g} to {high:g}"
            self.fail(f"has '{word[:SHOWN]}' as {what}, expected a number{limits}")
        return value

    def whole(self, what: str, low: int, high: int) -> int:
        """The next word as a whole number within limits."""
        word = self.word(what)
        value = parse_whole(word)
        if value is None or not low <= value <= high:
            self.fail(
                f"has '{word[:SHOWN]}' as {what}, expected a whole number from {low} to {high}"
            )
        return value

    def numbers(self, count: int, what: str) -> np.ndarray:
        """The next numbers, over as many lines as they take. (count,) float64"""
        if 2 * count > self._room + 1:
            self.fail(f"states {count} numbers of {what}, more than the file can hold")
        found = np.empty(count)
        have = 0
        while have < count:
            if not self.peek():
                self.fail(f"ends after {have} of {count} numbers of {what}")
            row = self._words[self._at : self._at + count - have]
            self._at += len(row)
            found[have : have + len(row)] = self._values(row, what)
            have += len(row)
        return found

    def _values(self, row: list[str], what: str):
        try:
            values = np.array([float(word) for word in row])
            if (np.abs(values) <= LARGEST).all() and not any("_" in word for word in row):
                return values
        except ValueError:
            # Fortran's exponents, or no numbers.
            pass
        values = [parse_number(word) for word in row]
        for word, value in zip(row, values, strict=True):
            if value is None or abs(value) > LARGEST:
                self.fail(f"has '{word[:SHOWN]}' among {what}, expected a number up to {LARGEST:g}")
        return values

    def rising(self, count: int, what: str, low: float, high: float) -> np.ndarray:
        """The next numbers, strictly ascending within limits. (count,)"""
        found = self.numbers(count, what)
        if np.any(np.diff(found) <= 0.0) or found[0] < low or found[-1] > high:
            self.fail(f"has {what} that do not ascend within {low:g} to {high:g}")
        return found

    def end(self) -> None:
        """Refuse what follows, but for words that say that it is the end."""
        left = self.peek()
        if left and left.lower() != "end":
            self.fail(f"has '{left[:SHOWN]}' where it should end; counts may be wrong")

    def angles(self, count: int, what: str, highest: float, *, any_order=False) -> np.ndarray:
        """The next numbers as angles that ascend from 0 or more to ``highest`` at most. [degree -> rad]"""
        found = self.numbers(count, what)
        if not any_order and np.any(np.diff(found) <= 0.0):
            self.fail(f"has {what} that do not ascend")
        if found.min() < 0.0 or found.max() > highest + 1e-6:
            self.fail(
                f"has {what} from {found.min():g} to {found.max():g} degrees, expected 0 to {highest:g}"
            )
        return np.radians(np.minimum(found, highest))
