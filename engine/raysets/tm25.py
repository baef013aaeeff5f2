"""IES TM-25: ray files of measured and computed sources (.TM25RAY).

References
----------
ANSI/IES TM-25-13 and TM-25-20: Ray File Format for the Description of the Emission Property of Light Sources.
"""

import math

import numpy as np

from ..errors import FileFormatError
from ..luminaires.spectrum_checks import NANOMETRES, tell_oddities
from ..reading.content import open_file
from ..reading.remarks import Remark
from .binary import Head, check_count, read_rows
from .record import LUMINOUS, RADIANT, UNITS, Columns, RayFile

MAGIC = b"TM25"

VERSIONS = {2013: "TM-25-13", 2020: "TM-25-20"}

TEXTS = (
    "SOURCE", "MANUFACTURER", "MODEL_CREATOR", "FILE_CREATOR", "EQUIPMENT", "CAMERA", "OPERATION", "INFORMATION",
    "GEOMETRY",
)  # fmt: skip
"""Keys of the nine texts of the head."""

TEXT_SIZE, TEXTS_START, TABLES_START = 4000, 288, 36288

BLOCK = 32
"""Spectral tables are filled up to a multiple of it. [byte]"""

MOST_TOLD = 3
"""Remarks on spectra: where each ray has a table of its own, many may be odd in the same way."""

COLUMN_NAME = 512
"""Of an additional column. [byte]"""

MOST_TABLES, MOST_ENTRIES, MOST_COLUMNS, MOST_TEXT = 10_000, 100_000, 1_000, 64 << 20

NO_SPECTRUM, ONE_WAVELENGTH, WAVELENGTH_BY_RAY, ONE_TABLE, TABLE_BY_RAY = range(5)
"""Spectral data identifiers."""


def is_tm25(head: Head) -> bool:
    """Whether a file says that it is one."""
    return head.data[:4] == MAGIC


def read_tm25(path) -> RayFile:
    """Read the head of a TM-25 file.

    Raises
    ------
    FileFormatError    It is cut short, contradicts itself, or states what the standard does not know.
    """
    head = Head(path, TABLES_START)
    version, _ = head.numbers("ii", 4)
    lumens, watts = (_known(value) for value in head.numbers("ff", 12))
    count = head.number("Q", 20)
    check_count(path, count)
    kind = head.number("i", 60)
    single = head.number("f", 64)
    tables, more, text = head.numbers("iii", 76)
    flags = head.numbers("8i", 256)
    remarks = []
    if version not in VERSIONS:
        remarks.append(Remark(f"states version {version}, read like 2013"))
    _check_flags(path, flags, kind)
    for name, value, most in (
        ("spectral tables", tables, MOST_TABLES),
        ("additional columns", more, MOST_COLUMNS),
        ("bytes of additional text", text, MOST_TEXT),
    ):
        if not 0 <= value <= most:
            raise FileFormatError(path, f"states {value} {name}, expected 0 to {most}")
    spectra, end = _read_tables(path, head.length, tables)
    remarks += _remark_tables(path, spectra)
    columns = _find_columns(flags, more)
    start = end + COLUMN_NAME * more + text
    size = 4 * columns.count * count
    if head.length == start + size + 3 * text:
        # One writer counts the text in characters of four bytes.
        start += 3 * text
    head.expect_length(
        start + size, f"{count} rays of {columns.count} numbers after {start} bytes of head"
    )
    if kind in {ONE_TABLE, TABLE_BY_RAY} and not spectra:
        raise FileFormatError(path, f"says that it has spectra (identifier {kind}), but holds none")
    metadata = {
        key: head.text(TEXTS_START + TEXT_SIZE * number, TEXT_SIZE, "utf-32-le")
        for number, key in enumerate(TEXTS)
    }
    metadata["DATE"] = head.text(28, 28)
    return RayFile(
        head.path,
        VERSIONS.get(version, "TM-25"),
        count,
        columns,
        lambda: read_rows(path, start, count, columns.count),
        UNITS["mm"],
        RADIANT if flags[2] else LUMINOUS,
        luminous_flux=lumens,
        radiant_flux=watts,
        wavelength=_known(single) if kind == ONE_WAVELENGTH else None,
        spectra=spectra,
        metadata={key: value for key, value in metadata.items() if value},
        remarks=tuple(remarks),
    )


def _known(value: float) -> float | None:
    """A stated amount; None where it is not stated."""
    return value if math.isfinite(value) and value > 0.0 else None


def _check_flags(path, flags, kind: int) -> None:
    position, direction, radiant, wavelength, luminous, _stokes, tristimulus, spectrum = flags
    if any(flag not in {0, 1} for flag in flags):
        raise FileFormatError(path, f"has the flags {flags} for its columns, expected 0 or 1 each")
    if not (position and direction):
        raise FileFormatError(path, "has no column of positions or directions")
    if not (radiant or luminous):
        raise FileFormatError(path, "has a column neither of radiant nor of luminous flux")
    if not NO_SPECTRUM <= kind <= TABLE_BY_RAY:
        raise FileFormatError(path, f"has the spectral data identifier {kind}, expected 0 to 4")
    if (kind == WAVELENGTH_BY_RAY) != bool(wavelength):
        raise FileFormatError(
            path,
            f"has the spectral data identifier {kind} and {'a' if wavelength else 'no'} column of wavelengths",
        )
    if (kind == TABLE_BY_RAY) != bool(spectrum):
        raise FileFormatError(
            path,
            f"has the spectral data identifier {kind} and {'a' if spectrum else 'no'} column of spectra",
        )
    if tristimulus and not luminous:
        raise FileFormatError(path, "has tristimulus values without a column of luminous flux")


def _find_columns(flags, more: int) -> Columns:
    _, _, radiant, wavelength, luminous, stokes, tristimulus, spectrum = flags
    place, found = 6, {}
    for name, is_there, size in (
        ("radiant", radiant, 1),
        ("wavelength", wavelength, 1),
        ("luminous", luminous, 1),
        ("stokes", stokes, 6),
        ("tristimulus", tristimulus, 2),
        ("spectrum", spectrum, 1),
    ):
        if is_there:
            found[name] = place
            place += size
    return Columns(
        place + more,
        0,
        3,
        found.get("radiant", found.get("luminous")),
        found.get("wavelength"),
        found.get("spectrum"),
    )


def _remark_tables(path, spectra) -> list[Remark]:
    """What is odd about spectra, of the first few that are."""
    told = []
    for number, (wavelengths, weights) in enumerate(spectra, 1):
        if len(told) >= MOST_TOLD:
            break
        if len(wavelengths) > 1:
            nowhere = np.zeros(len(wavelengths), dtype=int)
            name = f"spectral table {number}"
            told += map(Remark, tell_oddities(path, nowhere, wavelengths, weights, name))
    return told[:MOST_TOLD]


def _read_tables(path, length: int, tables: int):
    """Spectra, and the byte after them."""
    spectra, place = [], TABLES_START
    with open_file(path) as file:
        for number in range(tables):
            file.seek(place)
            entries = np.fromfile(file, dtype="<i4", count=1)
            if len(entries) == 0:
                raise FileFormatError(
                    path, f"ends at byte {length}, within spectral table {number + 1}"
                )
            count = int(entries[0])
            if not 1 <= count <= MOST_ENTRIES:
                raise FileFormatError(
                    path,
                    f"byte {place}: states {count} entries of a spectrum, expected 1 to {MOST_ENTRIES}",
                )
            with np.errstate(invalid="ignore"):
                values = np.fromfile(file, dtype="<f4", count=2 * count).astype(np.float64)
            if len(values) < 2 * count:
                raise FileFormatError(
                    path, f"ends at byte {length}, within spectral table {number + 1}"
                )
            wavelengths, weights = values.reshape(-1, 2).T
            if not np.isfinite(values).all() or (weights < 0.0).any() or weights.max() <= 0.0:
                raise FileFormatError(
                    path,
                    f"spectral table {number + 1} holds numbers that are none, negative ones or zeros alone",
                )
            if (np.diff(wavelengths) <= 0.0).any() or wavelengths[0] <= 0.0:
                raise FileFormatError(
                    path, f"the wavelengths of spectral table {number + 1} do not ascend"
                )
            if wavelengths[-1] < NANOMETRES:
                raise FileFormatError(
                    path,
                    f"the wavelengths of spectral table {number + 1} end at {wavelengths[-1]:g}, expected nanometres",
                )
            spectra.append((wavelengths, weights / weights.max()))
            place += 4 + 8 * count
    held = place - TABLES_START
    return tuple(spectra), TABLES_START + -(-held // BLOCK) * BLOCK
