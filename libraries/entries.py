"""What readers of folders share: values of an entry in JSON, checked, and what was left out."""

import os
import sys
from dataclasses import dataclass
from pathlib import Path

LARGEST = sys.float_info.max
"""Largest number."""


class UnusableError(Exception):
    """A description says what cannot be; the message says what was expected."""


@dataclass(frozen=True)
class Problem:
    """Something that was left out, and why."""

    path: Path
    message: str

    def __str__(self) -> str:
        return f"{self.path}: {self.message}"


def path_inside(folder: Path, name) -> Path | None:
    """Path of a name inside a folder; None if it is no name or leads out of it."""
    if not isinstance(name, str) or not name or "\0" in name:
        return None
    path = Path(os.path.normpath(folder / name))
    return path if path.is_relative_to(os.path.normpath(folder)) else None


def text_of(entry: dict, key: str, default: str = "") -> str:
    """Text of an entry, without space around it; the default if there is none.

    Raises
    ------
    UnusableError    It is something else.
    """
    value = entry.get(key, default)
    if not isinstance(value, str):
        raise UnusableError(f"'{key}' should be a text")
    return value.strip() or default


def is_number(value, low: float = -LARGEST, high: float = LARGEST) -> bool:
    """Tell whether a value is a finite number within bounds."""
    # JSON has whole numbers that no float can hold.
    is_one = isinstance(value, int | float) and not isinstance(value, bool)
    return is_one and low <= value <= high
