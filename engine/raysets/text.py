"""Rays as text: Zemax, LightTools, TracePro, and rows of seven or eight numbers with any head.

Files are read line by line, so their size does not matter. What the head does not tell is taken from `Assumed`.
"""

import math
import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..reading.lines import read_lines
from ..reading.remarks import Remark
from ..reading.text import find_encoding, parse_number
from .binary import PIECE, check_count
from .record import LUMINOUS, RADIANT, UNITS, Columns, RayFile
from .zemax import MICROMETRE
from .zemax import UNIT_CODES as ZEMAX_UNITS

LONGEST_LINE = 4096
"""Of a text that can be rays. [character]"""

LONGEST_HEAD = 500
"""Lines before the first ray, at most."""

END = "lt_endofdata"
"""Line of LightTools after the last ray."""

LONGEST_MICROMETRES = 20.0
"""Wavelengths up to it are taken as micrometres where nothing tells."""

LIGHTTOOLS_UNITS = {
    "millimeters": "mm", "centimeters": "cm", "meters": "m", "inches": "inch", "feet": "foot", "micrometers": "um",
    "nanometers": "nm",
}  # fmt: skip

_KEY = re.compile(r"^(lt_\w+|dataname):\s*(.*)$")

_NO_NUMBER = re.compile(r"[+-]?(nan|inf(inity)?|1\.#\w+)(\(\w*\))?", re.IGNORECASE)
"""What programs write for the results of calculations that failed."""

_FACTOR = re.compile(r"conversion factor from meters\s*[:=]?\s*(\S+)", re.IGNORECASE)


@dataclass(frozen=True)
class Assumed:
    """What is taken of texts that do not tell.

    Parameters
    ----------
    unit : str    Of `UNITS`.
    quantity : str    `RADIANT` or `LUMINOUS`.
    """

    unit: str = "mm"
    quantity: str = RADIANT


def _lines(path, first: int = 0) -> Iterator[tuple[int, str]]:
    """Lines with their numbers from 1, from the one after ``first`` on."""
    for number, line in read_lines(path, LONGEST_LINE):
        if number > first:
            yield number, line.strip()


def _tokens(line: str) -> list[str]:
    return [token for token in re.split(r"[\s,;]+", line) if token]


def _number(token: str) -> float | None:
    """The number that a token stands for, NaN where a program says that it had none; None for other words."""
    return math.nan if _NO_NUMBER.fullmatch(token) else parse_number(token)


def _numbers(line: str) -> list[float] | None:
    """The numbers of a row; None where something else stands in it."""
    found = [_number(token) for token in _tokens(line)]
    return None if not found or any(value is None for value in found) else found


def is_text(data: bytes) -> bool:
    """Whether the first bytes of a file are text."""
    head = data[:4096]
    text = head.decode(find_encoding(head, is_whole=False), "ignore")
    return bool(text) and not any(
        unicodedata.category(c) == "Cc" for c in set(text) - {*"\t\n\r\f"}
    )


@dataclass
class _Beginning:
    """What stands before the first ray.

    Parameters
    ----------
    keys : dict of str to str    Of a LightTools text.
    factor : float or None    Units to a metre, as TracePro states it.
    zemax : list of float or None    First row of a Zemax text, in the line ``zemax_line``.
    line : int    Of the first ray.
    first : list of float    Its numbers.
    """

    keys: dict[str, str]
    factor: float | None = None
    zemax: list[float] | None = None
    zemax_line: int = 0
    line: int = 0
    first: list[float] = field(default_factory=list)

    @property
    def width(self) -> int:
        """Numbers in a row."""
        return len(self.first)


def read_text(path, assumed: Assumed | None = None) -> RayFile:
    """Read the head of a text, and count its rows.

    Raises
    ------
    FileFormatError    It has no rows of seven or eight numbers, or its head contradicts them.
    """
    begin = _read_beginning(path)
    is_far = begin.keys.get("lt_far_field_data", "no").lower() == "yes"
    base = 0 if is_far else 3
    if begin.width not in {base + 4, base + 5}:
        raise FileFormatError(
            path, f"has {begin.width} numbers, expected {base + 4} or {base + 5}", begin.line
        )
    has_wavelength = begin.width == base + 5
    columns = Columns(
        begin.width,
        None if is_far else 0,
        base,
        base + 3,
        base + 4 if has_wavelength else None,
    )
    count = sum(1 for _ in _rows(path, begin))
    check_count(path, count)
    if begin.keys:
        told = _read_lighttools(path, begin)
    elif begin.zemax is not None:
        told = _read_zemax(path, begin, count)
    else:
        told = _assume(begin, assumed or Assumed())
    return RayFile(
        path=Path(path),
        count=count,
        columns=columns,
        rows=lambda: _pieces(path, begin),
        **told,
    )


def _read_beginning(path) -> _Beginning:
    begin = _Beginning({})
    for number, line in _lines(path):
        if number > LONGEST_HEAD:
            break
        if found := _KEY.match(line):
            begin.keys[found[1]] = found[2]
            continue
        if found := _FACTOR.search(line):
            begin.factor = parse_number(found[1])
            continue
        values = _numbers(line)
        if values is None or len(values) < 4:
            continue
        if begin.zemax is None and not begin.keys and _is_zemax_head(values):
            begin.zemax, begin.zemax_line = values, number
            continue
        begin.line, begin.first = number, values
        return begin
    raise FileFormatError(path, "holds no rows of rays (x y z l m n flux, and a wavelength)")


def _read_lighttools(path, begin: _Beginning) -> dict:
    keys = begin.keys
    told = keys.get("lt_length_units", "").lower()
    if told not in LIGHTTOOLS_UNITS:
        raise FileFormatError(
            path, f"has the unit of length '{told}', expected one of {', '.join(LIGHTTOOLS_UNITS)}"
        )
    is_luminous = "luminous" in keys.get("lt_datatype", "")
    total = parse_number(keys.get("lt_luminous_flux", keys.get("lt_radiant_flux", "")))
    total = total if total is not None and total > 0.0 else None
    return {
        "format": "LightTools text",
        "scale": UNITS[LIGHTTOOLS_UNITS[told]],
        "quantity": LUMINOUS if is_luminous else RADIANT,
        "luminous_flux": total if is_luminous else None,
        "radiant_flux": None if is_luminous else total,
        "metadata": {key: value for key, value in keys.items() if value},
    }


def _read_zemax(path, begin: _Beginning, count: int) -> dict:
    head, line = begin.zemax, begin.zemax_line
    if round(head[0]) != count:
        raise FileFormatError(path, f"states {head[0]:g} rays, but holds {count}", line)
    code = round(head[1])
    is_luminous = len(head) > 3 and round(head[3]) == 1 and begin.width == 7
    return {
        "format": "Zemax text",
        "scale": UNITS[ZEMAX_UNITS[code]],
        "quantity": LUMINOUS if is_luminous else RADIANT,
        "wavelength_scale": MICROMETRE,
    }


def _assume(begin: _Beginning, assumed: Assumed) -> dict:
    """What is taken of rows without a head that tells."""
    is_scaled = begin.factor is not None and begin.factor > 0.0
    remarks = [
        f"states {begin.factor:g} units to a metre"
        if is_scaled
        else f"does not tell its unit of length; taken as {assumed.unit}",
        f"does not tell what its flux is; taken as {assumed.quantity}",
    ]
    scale = 1.0
    if begin.width in {5, 8}:
        scale = MICROMETRE if 0.0 < begin.first[-1] <= LONGEST_MICROMETRES else 1.0
        remarks.append(
            f"does not tell its unit of wavelength; taken as {'um' if scale > 1.0 else 'nm'}"
        )
    return {
        "format": "TracePro text" if is_scaled else "text of rays",
        "scale": 1.0 / begin.factor if is_scaled else UNITS[assumed.unit],
        "quantity": assumed.quantity,
        "wavelength_scale": scale,
        "remarks": tuple(Remark(text) for text in remarks),
    }


def _is_zemax_head(values: list[float]) -> bool:
    """Whether a row is the first of a Zemax text: number, unit, format, kind of flux, and perhaps zeros."""
    whole = all(float(value).is_integer() for value in values[:4])
    return whole and values[0] >= 1 and 0 <= values[1] <= 4 and not any(values[4:])


def _rows(path, begin: _Beginning) -> Iterator[list[float]]:
    """Rows from the first one on; the text that may follow the last one is left out.

    Raises
    ------
    FileFormatError    A row is damaged, or the file is cut short.
    """
    width, is_lighttools = begin.width, bool(begin.keys)
    count, is_past, is_complete = 0, False, not is_lighttools
    for number, line in _lines(path, begin.line - 1):
        if not line or line[0] in "#!":
            continue
        values = _numbers(line)
        if values is None:
            _refuse_damage(path, line, width, number)
            is_past = True
            is_complete |= line == END
            continue
        if is_past or len(values) != width:
            what = (
                "numbers after the end of the rays"
                if is_past
                else f"{len(values)} numbers, expected {width}"
            )
            raise FileFormatError(path, f"has {what}", number)
        count += 1
        yield values
    if not is_complete:
        # The total of its head is that of the whole, and nobody knows how much of it is missing.
        raise FileFormatError(
            path, f"is cut short after {count} rays: no line {END} follows; copy or export it again"
        )


def _refuse_damage(path, line: str, width: int, number: int) -> None:
    """Refuse what is no text behind the rays but one of them with something foreign in it."""
    tokens = _tokens(line)
    foreign = [token for token in tokens if _number(token) is None]
    if _number(tokens[0]) is not None or (len(tokens) == width and 2 * len(foreign) <= width):
        raise FileFormatError(path, f"has '{foreign[0][:40]}', expected a number", number)


def _pieces(path, begin: _Beginning) -> Iterator[np.ndarray]:
    rows = _rows(path, begin)
    while held := list(islice(rows, PIECE)):
        # What is too large becomes infinite, and is found so when rays are checked.
        with np.errstate(over="ignore"):
            yield np.array(held, dtype=np.float32)
