"""Data blocks of WINDOW XML: their text, and the numbers in it."""

import re
from dataclasses import dataclass

import numpy as np

from ...errors import FileFormatError
from ...reading.remarks import Remark
from ...reading.safe_xml import XmlElement

NEUTRAL = 555.0
"""Wavelength of values that hold for all. [nm]"""

LONGEST_TEXT = 100
"""Of names. [character]"""

LARGEST = 1e30
"""Bound of values, well within single precision. [1/sr]"""


@dataclass(frozen=True)
class Block:
    """One side's data: ``element`` is its WavelengthDataBlock."""

    band: str
    direction: str
    element: XmlElement


def text_of(element: XmlElement | None) -> str:
    """Text of an element in one line, as much as a message or a name may hold."""
    return "" if element is None else " ".join((element.text or "").split())[:LONGEST_TEXT]


def values_of(block: Block, foreign: re.Pattern, path) -> tuple[str, int]:
    """Text of the values, and the line where it begins.

    Raises
    ------
    FileFormatError    There are none, or among them is what a pattern calls foreign.
    """
    element = block.element.find("ScatteringData")
    if element is None or not (element.text or "").strip():
        raise FileFormatError(
            path, f"has no ScatteringData for {block.direction}", block.element.line
        )
    text, line = element.text, element.line
    if odd := foreign.search(text):
        line += text.count("\n", 0, odd.start())
        raise FileFormatError(path, f"has {odd.group()!r} among ScatteringData", line)
    return text, line


def clip(values: np.ndarray, block: Block, remarks: list[Remark]) -> np.ndarray:
    """Values as stored, none below 0."""
    below = int((values < 0.0).sum())
    if below:
        remarks.append(
            Remark(
                f"{below} values of {block.direction} are negative; taken as 0", block.element.line
            )
        )
    return np.maximum(values, 0.0).astype(np.float32)


def parse_value(token: str) -> float | None:
    """The number that a token stands for; None if it is none, or too large for single precision."""
    try:
        value = float(token)
    except ValueError:
        return None
    return value if abs(value) < LARGEST else None
