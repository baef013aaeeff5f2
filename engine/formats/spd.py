"""Spectra from files: two-column text or CSV, and IES TM-27-14 XML (.spdx)."""

import math
from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..luminaires.safe_xml import parse_xml
from ..reading.content import read_bytes
from ..scene.spectrum import Tabulated
from .text_table import MAXIMUM_BYTES, parse_rows


def read_spectrum(path) -> Tabulated:
    """Read a spectrum: wavelength in nm against value.

    Parameters
    ----------
    path : str or Path    ``.spdx`` is read as TM-27-14, everything else as text with two columns, as `parse_rows` does.

    Returns
    -------
    Tabulated    Ascending in wavelength, at least two rows. [nm -> as in the file]

    Raises
    ------
    FileFormatError    The file cannot be read as a spectrum; the message names the line and what was expected.
    """
    path = Path(path)
    data = read_bytes(path, MAXIMUM_BYTES)
    if path.suffix.lower() == ".spdx" or data.lstrip()[:5] == b"<?xml":
        rows = _rows_of_tm27(path, data)
    else:
        rows = parse_rows(path, data, 2, "wavelength and value")
    return _table(path, rows)


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
