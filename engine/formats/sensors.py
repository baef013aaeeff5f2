"""Sensor lists as CSV: x, y, z, nx, ny, nz in; the same and the answers out."""

import csv
import math
from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..reading.lines import read_lines
from ..reading.whole_file import write_whole

COLUMNS = ("x", "y", "z", "nx", "ny", "nz")
"""Columns of a sensor list: position [m] and the direction that the sensor faces."""

MAXIMUM_SENSORS = 5_000_000
"""Longest list."""

LONGEST_LINE = 65536
"""Of a list. [character]"""


def read_sensors(path) -> np.ndarray:
    """Read a sensor list.

    Parameters
    ----------
    path : str or Path    Comma-separated; a first line of names may give the columns in any order, others are ignored.

    Returns
    -------
    (n, 6) float64 array    Position and normal. [m, -]

    Raises
    ------
    FileFormatError    With the line, what was found and what was expected.
    """
    path = Path(path)
    rows: list[list[float]] = []
    order = None
    reader = csv.reader(line for _, line in read_lines(path, LONGEST_LINE))
    try:
        for fields in reader:
            if not any(field.strip() for field in fields) or fields[0].lstrip().startswith("#"):
                continue
            if order is None:
                order = _order_of(path, fields, reader.line_num)
                if order is not None and not _is_number(fields[order[0]]):
                    continue
            rows.append(_row(path, fields, order, reader.line_num))
            if len(rows) > MAXIMUM_SENSORS:
                raise FileFormatError(path, f"more than {MAXIMUM_SENSORS} sensors")
    except csv.Error as error:
        raise FileFormatError(path, f"is not comma-separated text ({error})") from None
    if not rows:
        raise FileFormatError(path, "holds no sensor, expected rows of x,y,z,nx,ny,nz")
    return np.array(rows)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _order_of(path, fields, line) -> list[int]:
    """Positions of the six columns, from a line of names or from the first row of numbers."""
    if all(_is_number(field) for field in fields):
        return list(range(6))
    names = [field.strip().lower() for field in fields]
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise FileFormatError(
            path,
            f"the heading has no column {', '.join(missing)}, expected {','.join(COLUMNS)}",
            line,
        )
    return [names.index(name) for name in COLUMNS]


def _row(path, fields, order, line) -> list[float]:
    if len(fields) <= max(order):
        raise FileFormatError(path, f"expected {max(order) + 1} columns, found {len(fields)}", line)
    values = []
    for name, place in zip(COLUMNS, order, strict=True):
        text = fields[place].strip()
        if not _is_number(text) or not math.isfinite(float(text)):
            raise FileFormatError(path, f"expected a number for {name}, found '{text[:40]}'", line)
        values.append(float(text))
    if not any(values[3:]):
        raise FileFormatError(
            path, "the normal is 0,0,0, expected the direction that the sensor faces", line
        )
    return values


def write_measurements(
    path, sensors: np.ndarray, illuminance, standard_error, tristimulus=None, remarks=(), more=None
) -> Path:
    """Write sensors (n, 6) with their illuminance and its standard error (n,). [m, lx]

    ``tristimulus`` (n, 3) adds the chromaticity x, y of the light that arrives. ``remarks`` are lines of text that a
    reader of the numbers has to know; they stand before them, each behind a ``#``. ``more``: further columns (n,) by name,
    NaN where there is no value.

    Raises
    ------
    FileFormatError    The file cannot be written.
    """
    with write_whole(path, "utf-8") as file:
        file.writelines(f"# {remark}\n" for remark in remarks)
        writer = csv.writer(file, lineterminator="\n")
        colours = [()] * len(sensors) if tristimulus is None else _chromaticities(tristimulus)
        names = () if tristimulus is None else ("chromaticity_x", "chromaticity_y")
        more = more or {}
        others = np.array([*more.values()]).reshape(len(more), len(sensors)).T
        writer.writerow([*COLUMNS, "illuminance_lx", "standard_error_lx", *names, *more])
        for row, value, error, colour, rest in zip(
            sensors, illuminance, standard_error, colours, others, strict=True
        ):
            writer.writerow(
                [
                    *(f"{v:.9g}" for v in row),
                    f"{value:.7g}",
                    f"{error:.3g}",
                    *(f"{c:.5f}" for c in colour),
                    *(f"{c:.6g}" if np.isfinite(c) else "" for c in rest),
                ]
            )
    return Path(path)


def _chromaticities(tristimulus: np.ndarray) -> np.ndarray:
    """Chromaticity x, y of every row, not a number where there is no light. (n, 3) -> (n, 2)"""
    total = tristimulus.sum(axis=1, keepdims=True)
    return np.where(total > 0.0, tristimulus[:, :2] / np.where(total > 0.0, total, 1.0), np.nan)
