"""Spectra from files: columns of text or CSV, CGATS text of instruments, and IES TM-27-14 XML (.spdx)."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..luminaires.spectrum_checks import check_powers, check_wavelengths, tell_range
from ..reading.content import read_bytes
from ..reading.remarks import Remark
from ..reading.safe_xml import parse_xml
from ..reading.text_table import MAXIMUM_BYTES, parse_table
from ..scene.spectrum import Tabulated
from .cgats import is_cgats, read_cgats
from .spectrum_rows import SpectrumRows, check_column


@dataclass(frozen=True, eq=False)
class SpectrumFile:
    """A spectrum as its file holds it.

    Parameters
    ----------
    path : Path
    format : str    For people.
    table : Tabulated    Ascending in wavelength, at least two rows, none below 0. [nm -> as in the file]
    column, columns : int    Which column of values, or sample, was taken, from 1, and how many there are.
    names : tuple of str    Of the columns of values; empty where the file does not tell.
    spectra : str    What its columns of values are called, for messages.
    remarks : tuple of Remark    What is odd about it, and what was assumed.
    """

    path: Path
    format: str
    table: Tabulated
    column: int = 1
    columns: int = 1
    names: tuple[str, ...] = ()
    spectra: str = SpectrumRows.spectra
    remarks: tuple[Remark, ...] = ()


def read_spectrum(path, column: int | None = None) -> SpectrumFile:
    """Read a spectrum: wavelength in nm against value.

    Parameters
    ----------
    path : str or Path    Which of the formats it has, is told by its content, for TM-27-14 also by its name (``.spdx``).
    column : int or None    Of the values, or the sample, from 1; None: the first one, with a remark if there are others.

    Raises
    ------
    FileFormatError    The file cannot be read as a spectrum; the message names the line and what was expected.
    """
    path = Path(path)
    return parse_spectrum(path, read_bytes(path, MAXIMUM_BYTES), column)


def parse_spectrum(path: Path, data: bytes, column: int | None = None) -> SpectrumFile:
    """Return the spectrum that the content of a file holds, as `read_spectrum`.

    Parameters
    ----------
    path : Path    What the file is called; nothing is looked up there.
    data : bytes    Its content.
    column : int or None
    """
    read = next(read for is_one, read in _FORMATS if is_one(path, data))
    held = read(path, data, column)
    rows, names, count = held.rows, held.names, held.count
    remarks = list(held.remarks)
    if count > 1 and column is None:
        name = f" ('{names[0][:40]}')" if names else ""
        remarks.append(Remark(f"has {count} {held.spectra}, of which the first one{name} is taken"))
    if len(rows) < 2:
        raise FileFormatError(
            path, f"expected at least two rows of wavelength and value, found {len(rows)}"
        )
    lines, wavelengths, values = (np.array(each) for each in zip(*rows, strict=True))
    remarks += check_wavelengths(path, lines, wavelengths, values)
    values, told = check_powers(path, lines, values)
    order = np.argsort(wavelengths)
    wavelengths, values = wavelengths[order], values[order]
    remarks += told + tell_range(path, wavelengths, values)
    label = path.name
    if count > 1:
        label += f", {names[(column or 1) - 1][:40]}" if names else f", column {column or 1}"
    table = Tabulated(wavelengths, values, name=label)
    return SpectrumFile(
        path, held.format, table, column or 1, count, names, held.spectra, tuple(remarks)
    )


def _read_text(path, data: bytes, column: int | None) -> SpectrumRows:
    table = parse_table(path, data, 2, "wavelength and value")
    if not table.rows:
        return SpectrumRows("text", [])
    count = len(table.rows[0][1]) - 1
    check_column(path, column, count)
    place, rows = column or 1, []
    for line, fields in table.rows:
        if len(fields) <= place or fields[0] is None or fields[place] is None:
            raise FileFormatError(
                path, f"expected wavelength and value, found nothing in column {place}", line
            )
        rows.append((line, fields[0], fields[place]))
    return SpectrumRows("text", rows, tuple(table.headings[1:]), count)


def _is_tm27(path: Path, data: bytes) -> bool:
    return path.suffix.lower() == ".spdx" or data.lstrip()[:5] == b"<?xml"


def _read_tm27(path, data: bytes, column: int | None) -> SpectrumRows:
    check_column(path, column, 1)
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
    return SpectrumRows("IES TM-27-14", rows)


_FORMATS = (
    (_is_tm27, _read_tm27),
    (lambda _, data: is_cgats(data), read_cgats),
    (lambda *_: True, _read_text),
)
"""How formats are told, in the order in which they are tried, and their readers."""
