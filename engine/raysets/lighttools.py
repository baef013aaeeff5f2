"""Ray files of LightTools, binary (.ray)."""

from ..errors import FileFormatError
from ..reading.content import open_file
from ..reading.remarks import Remark
from .binary import Head, check_count, read_rows
from .record import LUMINOUS, RADIANT, UNITS, Columns, RayFile

MAGIC, END = b"LTRF", b"LTRFEND"

HEAD, POLARISED_HEAD = 44, 48

NO_COLOUR, TRISTIMULUS, WAVELENGTH = range(3)

UNIT_CODES = ("mm", "mm", "cm", "m", "inch", "foot", "um", "nm")
"""The first one stands for the unit of the program's system, which the file does not tell."""


def is_lighttools(head: Head) -> bool:
    """Whether a file says that it is a binary one."""
    return head.data[:4] == MAGIC


def read_lighttools(path) -> RayFile:
    """Read the head of a binary ray file.

    Raises
    ------
    FileFormatError    It is cut short, or holds what has no public description.
    """
    head = Head(path, POLARISED_HEAD)
    major, minor, quantity, far, colour, unit = head.numbers("6I", 4)
    if major != 2:
        what = "polarised rays (version 3)" if major == 3 else f"version {major}"
        raise FileFormatError(path, f"holds {what}, expected version 2; export it unpolarised")
    if quantity not in {0, 1}:
        raise FileFormatError(
            path, f"byte 12: data type {quantity}, expected 0 (watts) or 1 (lumens)"
        )
    if colour not in {NO_COLOUR, WAVELENGTH}:
        raise FileFormatError(
            path,
            f"byte 20: colour information {colour}, expected 0 (none) or 2 (wavelength); export it so",
        )
    if unit >= len(UNIT_CODES):
        raise FileFormatError(path, f"byte 24: unit code {unit}, expected 0 to 7")
    if far not in {0, 1}:
        raise FileFormatError(path, f"byte 16: far field {far}, expected 0 or 1")
    remarks = []
    if unit == 0:
        remarks.append(Remark("does not tell its unit of length; taken as mm"))
    first = 0 if far else 3
    columns = Columns(
        first + 4 + (colour == WAVELENGTH),
        None if far else 0,
        first,
        first + 3,
        first + 4 if colour == WAVELENGTH else None,
    )
    count, is_ended = _count_rays(path, head.length, columns.count)
    if not is_ended:
        # The format states no number of rays, so what is there can be used.
        remarks.append(
            Remark(f"does not end with {END.decode()}: it is cut short after {count} rays")
        )
    origin, total = head.numbers("3f", 28), head.number("f", 40)
    if any(origin):
        remarks.append(Remark(f"states the origin {origin}, which is not applied"))
    total = total if 0.0 < total < float("inf") else None
    return RayFile(
        head.path,
        f"LightTools binary {major}.{minor}",
        count,
        columns,
        lambda: read_rows(path, HEAD, count, columns.count),
        UNITS[UNIT_CODES[unit]],
        LUMINOUS if quantity == 1 else RADIANT,
        luminous_flux=total if quantity == 1 else None,
        radiant_flux=None if quantity == 1 else total,
        remarks=tuple(remarks),
    )


def _count_rays(path, length: int, numbers: int) -> tuple[int, bool]:
    """Rays of so many numbers in a file of a length [byte], and whether it ends as it should."""
    row = 4 * numbers
    with open_file(path) as file:
        file.seek(max(length - len(END), 0))
        is_ended = file.read() == END
    body = length - HEAD - (len(END) if is_ended else 0)
    count, rest = divmod(body, row)
    if count <= 0 or (is_ended and rest):
        raise FileFormatError(
            path, f"has {body} bytes of rays, expected a multiple of {row} ({numbers} numbers each)"
        )
    check_count(path, count)
    return count, is_ended
