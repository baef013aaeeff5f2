"""Ray files of SPEOS (.ray): no signature, so they are known by their size and their unit directions."""

import numpy as np

from ..errors import FileFormatError
from .binary import Head, check_count, read_rows
from .record import RADIANT, UNITS, Columns, RayFile

HEAD, COLUMNS = 28, Columns(8, 0, 3, 7, 6)

PROBED = 1000
"""Rays whose directions are looked at."""

TOLERANCE = 1e-3
"""Of the length of directions."""


def is_speos(head: Head) -> bool:
    """Whether the size is right and the first rays have unit directions."""
    row = 4 * COLUMNS.count
    if head.length <= HEAD or (head.length - HEAD) % row:
        return False
    count = min((len(head.data) - HEAD) // row, PROBED)
    rows = np.frombuffer(head.data, "<f4", count * COLUMNS.count, HEAD).reshape(count, -1)
    with np.errstate(invalid="ignore", over="ignore"):
        length = np.sqrt((rows[:, 3:6].astype(np.float64) ** 2).sum(axis=1))
    return bool(count and (np.abs(length - 1.0) < TOLERANCE).all())


def read_speos(path) -> RayFile:
    """Read the head of a SPEOS file. Its rays' weights are relative; wavelengths are in nm.

    Raises
    ------
    FileFormatError    It is cut short or states no flux.
    """
    head = Head(path, HEAD)
    watts = head.number("f", 0)
    lumens = head.number("f", 24)
    count, rest = divmod(head.length - HEAD, 4 * COLUMNS.count)
    if rest:
        raise FileFormatError(
            path, f"has {head.length} bytes, expected {HEAD} and a multiple of {4 * COLUMNS.count}"
        )
    check_count(path, count)
    return RayFile(
        head.path,
        "SPEOS",
        count,
        COLUMNS,
        lambda: read_rows(path, HEAD, count, COLUMNS.count),
        UNITS["mm"],
        RADIANT,
        is_relative=True,
        luminous_flux=lumens if 0.0 < lumens < float("inf") else None,
        radiant_flux=watts if 0.0 < watts < float("inf") else None,
    )
