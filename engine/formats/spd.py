"""Spectra from files: two-column text or CSV, and IES TM-27-14 XML (.spdx)."""

import math
import re
from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..luminaires.safe_xml import parse_xml
from ..scene.spectrum import Tabulated

MAXIMUM_BYTES = 16 << 20
"""A spectrum is never larger than this; anything larger is another kind of file."""

MAXIMUM_ROWS = 200_000

_COMMENT = re.compile(r"^\s*(#|//|;|%|!)")


def read_spectrum(path) -> Tabulated:
    """Read a spectrum: wavelength in nm against value.

    Parameters
    ----------
    path : str or Path    ``.spdx`` is read as TM-27-14, everything else as text with two columns separated by blanks,
        tabs, commas or semicolons (with semicolons or tabs a comma is the decimal sign). Lines before the first row of
        numbers are a heading; lines that begin with ``#``, ``//``, ``;``, ``%`` or ``!`` are comments.

    Returns
    -------
    Tabulated    Ascending in wavelength, at least two rows. [nm -> as in the file]

    Raises
    ------
    FileFormatError    The file cannot be read as a spectrum; the message names the line and what was expected.
    """
    path = Path(path)
    try:
        if path.stat().st_size > MAXIMUM_BYTES:
            raise FileFormatError(path, "larger than 16 MiB, expected a table of a spectrum")
        data = path.read_bytes()
    except OSError as error:
        raise FileFormatError(path, f"cannot be opened ({error.strerror})") from None
    if path.suffix.lower() == ".spdx" or data.lstrip()[:5] == b"<?xml":
        rows = _rows_of_tm27(path, data)
    else:
        rows = _rows_of_text(path, data)
    return _table(path, rows)


def _decode(path, data: bytes) -> str:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise FileFormatError(path, "UTF-16 text, save it as UTF-8")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def _rows_of_text(path, data: bytes) -> list[tuple[int, float, float]]:
    rows = []
    for number, line in enumerate(_decode(path, data).splitlines(), start=1):
        if not line.strip() or _COMMENT.match(line):
            continue
        values = _numbers(line)
        if values is None or len(values) < 2:
            if rows:
                raise FileFormatError(
                    path, f"expected wavelength and value, found '{line.strip()[:60]}'", number
                )
            continue
        rows.append((number, values[0], values[1]))
        if len(rows) > MAXIMUM_ROWS:
            raise FileFormatError(path, f"more than {MAXIMUM_ROWS} rows", number)
    return rows


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


def _rows_of_tm27(path, data: bytes) -> list[tuple[int, float, float]]:
    root = parse_xml(data, path)
    if root.tag != "IESTM2714":
        raise FileFormatError(path, f"expected the root element IESTM2714, found {root.tag}")
    rows = []
    for element in root.iter():
        if element.tag != "SpectralData":
            continue
        try:
            rows.append((element.line, float(element.attrib["wavelength"]), float(element.text)))
        except (KeyError, TypeError, ValueError):
            message = f"SpectralData number {len(rows) + 1} has no wavelength or no value"
            raise FileFormatError(path, message, element.line) from None
    return rows


def _table(path, rows) -> Tabulated:
    if len(rows) < 2:
        raise FileFormatError(
            path, f"expected at least two rows of wavelength and value, found {len(rows)}"
        )
    for line, nm, value in rows:
        if not (math.isfinite(nm) and math.isfinite(value)):
            raise FileFormatError(path, "expected finite numbers, found NaN or infinity", line)
        if nm <= 0.0:
            raise FileFormatError(path, f"expected a wavelength above 0, found {nm:g}", line)
        if value < 0.0:
            raise FileFormatError(path, f"expected a value of at least 0, found {value:g}", line)
    rows = sorted(rows, key=lambda row: row[1])
    wavelengths = np.array([row[1] for row in rows])
    if wavelengths[-1] < 20.0:
        raise FileFormatError(
            path,
            f"wavelengths end at {wavelengths[-1]:g}: expected nanometres, these look like micrometres",
        )
    same = np.flatnonzero(np.diff(wavelengths) <= 0.0)
    if len(same):
        raise FileFormatError(
            path, f"wavelength {wavelengths[same[0]]:g} nm stands twice", rows[same[0] + 1][0]
        )
    values = np.array([row[2] for row in rows])
    return Tabulated(wavelengths, values, name=Path(path).name)
