"""Source files of Zemax OpticStudio: binary (.dat, with wavelengths .sdf)."""

import math

from ..errors import FileFormatError
from ..reading.remarks import Remark
from .binary import Head, check_count, read_rows
from .record import LUMINOUS, RADIANT, UNITS, Columns, RayFile

IDENTIFIERS = (1010, 8675309)

HEAD = 208

UNIT_CODES = ("m", "inch", "cm", "foot", "mm")

FLUX_ONLY, WITH_WAVELENGTH = 0, 2
"""Ray formats."""

MICROMETRE = 1000.0
"""Wavelengths are in it. [nm]"""


def is_zemax(head: Head) -> bool:
    """Whether a file has the identifier, and rows of 7 or 8 numbers after the head as it states."""
    if len(head.data) < HEAD or head.number("i", 0) not in IDENTIFIERS:
        return False
    return head.length - HEAD in {28 * head.number("I", 4), 32 * head.number("I", 4)}


def read_zemax(path) -> RayFile:
    """Read the head of a binary source file.

    Raises
    ------
    FileFormatError    It is cut short, or has codes that are not known.
    """
    head = Head(path, HEAD)
    count = head.number("I", 4)
    check_count(path, count)
    unit = head.number("I", 136)
    if unit >= len(UNIT_CODES):
        raise FileFormatError(
            path, f"byte 136: unit code {unit}, expected 0 to 4 (m, inch, cm, feet, mm)"
        )
    kind, quantity = head.numbers("ii", 192)
    if kind not in {FLUX_ONLY, WITH_WAVELENGTH}:
        raise FileFormatError(
            path, f"byte 192: ray format {kind}, expected 0 (flux only) or 2 (with wavelength)"
        )
    remarks = []
    if quantity not in {0, 1}:
        raise FileFormatError(
            path, f"byte 196: flux type {quantity}, expected 0 (watts) or 1 (lumens)"
        )
    if kind == WITH_WAVELENGTH and quantity == 1:
        remarks.append(Remark("states lumens beside wavelengths, where watts are meant"))
        quantity = 0
    columns = Columns(8, 0, 3, 6, 7) if kind == WITH_WAVELENGTH else Columns(7, 0, 3, 6)
    size = 4 * columns.count * count
    head.expect_length(
        HEAD + size, f"{count} rays of {columns.count} numbers after {HEAD} bytes of head"
    )
    total, wavelength = head.number("f", 112), head.number("f", 116)
    total = total if math.isfinite(total) and total > 0.0 else None
    is_one = kind == FLUX_ONLY and math.isfinite(wavelength) and wavelength > 0.0
    return RayFile(
        head.path,
        "Zemax binary",
        count,
        columns,
        lambda: read_rows(path, HEAD, count, columns.count),
        UNITS[UNIT_CODES[unit]],
        LUMINOUS if quantity == 1 else RADIANT,
        luminous_flux=total if quantity == 1 else None,
        radiant_flux=None if quantity == 1 else total,
        wavelength=MICROMETRE * wavelength if is_one else None,
        wavelength_scale=MICROMETRE,
        metadata={"DESCRIPTION": head.text(8, 100)} if head.text(8, 100) else {},
        remarks=tuple(remarks),
    )
