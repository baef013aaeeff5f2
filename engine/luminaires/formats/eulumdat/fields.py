"""Lines of EULUMDAT files, each with one value, and what people write into them besides numbers."""

import re

from ....errors import FileFormatError
from ....reading.remarks import Remark
from ....reading.text import parse_number

LENGTH = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
FLUX = {"lm": 1.0, "klm": 1000.0}
POWER = {"w": 1.0, "kw": 1000.0}
PERCENT = {"%": 1.0}
ANGLE = {"°": 1.0, "deg": 1.0}
INTENSITY = {"cd/klm": 1.0, "cd/1000lm": 1.0, "cd/1000 lm": 1.0}
"""Units that may stand behind a number, with the factor to the unit of the field, which is the first."""

ANGLE_OR_INTENSITY = {"": 1.0, **ANGLE, **INTENSITY}

LONGEST_NUMBER = 80
"""Longer texts are no numbers. [character]"""

_DIGITS = r"(?:[0-9]+(?:[.,][0-9]*)?|[.,][0-9]+)(?:[eEdD][-+]?[0-9]{1,4})?"
_WITH_UNIT = re.compile(rf"([-+]?{_DIGITS}) ?([^0-9.,+\- ].*)?")
_WITH_BLANKS = re.compile(r"([-+]?[0-9]{1,3}(?: [0-9]{3})+(?:[.,][0-9]*)?)(?: ?([^0-9.,+\- ].*))?")


class Fields:
    """The lines of a file, taken one after the other.

    Parameters
    ----------
    path : str or Path    For messages.
    rows : list of (int, str)    Line number, from 1, and text of each line.
    """

    def __init__(self, path, rows):
        self.path = path
        self._rows = rows
        self._next = 0
        self._remarks: list[Remark] = []
        self._blanks: dict[str, list[tuple[int, str]]] = {}
        self._units: dict[str, list[int]] = {}
        self._commas: list[int] = []

    @property
    def line(self) -> int:
        """Line of the value that was taken last."""
        return self._rows[self._next - 1][0]

    def remarks(self) -> list[Remark]:
        """Return what was found on the way; things that occur often once, at their first line."""
        remarks = list(self._remarks)
        for assumed, places in self._blanks.items():
            names = ", ".join(name for _, name in places)
            remarks.append(Remark(f"blank, taken as {assumed}: {names}", places[0][0]))
        for unit, lines in self._units.items():
            text = f"the unit '{unit}' stands behind {_numbers(lines)}, expected the number alone"
            remarks.append(Remark(text, lines[0]))
        if self._commas:
            text = f"a decimal comma stands in {_numbers(self._commas)}, expected a point"
            remarks.append(Remark(text, self._commas[0]))
        return sorted(remarks, key=lambda remark: remark.line)

    def remark(self, text: str) -> None:
        """Note a departure at the value that was taken last."""
        self._remarks.append(Remark(text, self.line))

    def fail(self, message: str):
        """Refuse the file at the value that was taken last."""
        raise FileFormatError(self.path, message, self.line)

    def text(self, name: str) -> str:
        """Take a line of text."""
        if self._next >= len(self._rows):
            raise FileFormatError(self.path, f"the file ends where {name} is expected", self._end())
        self._next += 1
        return self._rows[self._next - 1][1].replace("\xa0", " ").strip()

    def number(self, name: str, units=(), default=None, assumed="0", hint="") -> float | None:
        """Take a number.

        Parameters
        ----------
        name : str    What it is, for messages.
        units : dict of str to float    Units that may stand behind it, with their factors.
        default : float or None    What is returned if the line is blank.
        assumed : str    How the remark on a blank line calls it.
        hint : str    Added to a message.

        Raises
        ------
        FileFormatError    There is no line, or something else than one number.
        """
        text = self.text(name)
        if not text:
            self._blanks.setdefault(assumed, []).append((self.line, name))
            return default
        value = parse_number(text)
        if value is not None:
            return value
        number, unit = self._split(text)
        factor = dict(units).get(unit.casefold()) if unit else 1.0
        if number is None or factor is None:
            unit = next(iter(units), "")
            expected = f" in {unit}" if unit else ""
            self.fail(f"expected {name}, a number{expected}, found '{shortened(text)}'{hint}")
        if unit and factor == 1.0:
            self._units.setdefault(unit, []).append(self.line)
        if factor != 1.0 or " " in number:
            self.remark(f"'{text}' as {name}, taken as {_plain(number) * factor:g}")
        if "," in number:
            self._commas.append(self.line)
        return _plain(number) * factor

    def whole(self, name: str, low: int, high: int, hint="") -> int:
        """Take a whole number within bounds.

        Raises
        ------
        FileFormatError    There is something else.
        """
        value = self.number(name, hint=hint)
        if value is None:
            self.fail(f"expected {name}, {low} to {high}, found a blank line{hint}")
        if not low <= value <= high or abs(value - round(value)) > 1e-6:
            self.fail(f"expected {name}, {low} to {high}, found {value:g}{hint}")
        return round(value)

    def rest(self) -> list[tuple[int, str]]:
        """Return the lines that have not been taken."""
        return self._rows[self._next :]

    def take(self, count: int, name: str) -> list[tuple[int, str]]:
        """Take several lines as they are."""
        rows = self._rows[self._next : self._next + count]
        if len(rows) < count:
            raise FileFormatError(
                self.path, f"the file ends where {name} are expected", self._end()
            )
        self._next += count
        return rows

    def _end(self) -> int:
        return self._rows[-1][0] if self._rows else 1

    def _split(self, text: str) -> tuple[str | None, str]:
        """The number and the unit behind it."""
        if len(text) > LONGEST_NUMBER:
            return None, ""
        match = _WITH_UNIT.fullmatch(text) or _WITH_BLANKS.fullmatch(text)
        if match is None or _plain(match[1]) is None:
            return None, ""
        return match[1], (match[2] or "").strip()


def _plain(number: str) -> float | None:
    return parse_number(number.replace(" ", "").replace(",", "."))


def _numbers(lines) -> str:
    return "one number" if len(lines) == 1 else f"{len(lines)} numbers"


def shortened(text: str) -> str:
    """Return a text short enough for a message."""
    return text if len(text) <= 40 else text[:40] + "..."
