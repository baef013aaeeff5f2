"""Road surfaces: how much of a luminaire's light comes to a driver's eye, by tables of reduced luminance coefficients."""

import csv
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...libraries import roads
from ..errors import FileFormatError, SceneError
from ..reading.text import parse_number

LARGEST_FILE = 1 << 20
"""[byte]"""

SCALE = 1e-4
"""Tables hold the coefficients times 10 000."""


@dataclass(frozen=True, eq=False)
class RoadSurface:
    """Reduced luminance coefficients of a road's surface.

    Parameters
    ----------
    name : str
    tangents : (t,) float64 array    Of the angle between the incident light and the vertical, ascending from 0. [-]
    angles : (b,) float64 array    beta, between the vertical planes of observation and of incidence, 0 to 180. [deg]
    coefficients : (t, b) float64 array    r = q cos^3 gamma, 0 where the table has none. [1/sr]
    remarks : tuple of str    What has to be told beside results.

    References
    ----------
    CIE 144:2001, Road surface and road marking reflection characteristics
    """

    name: str
    tangents: np.ndarray
    angles: np.ndarray
    coefficients: np.ndarray
    remarks: tuple[str, ...] = ()

    def reduced_coefficient(self, tangent, angle) -> np.ndarray:
        """Return r, linear between the values of the table in both directions, 0 beyond it (EN 13201-3, 8.2). [1/sr]

        Parameters
        ----------
        tangent, angle : array    tan gamma [-] and beta. [deg]
        """
        tangent, angle = np.broadcast_arrays(np.asarray(tangent, float), np.asarray(angle, float))
        i, u = _place(self.tangents, tangent)
        j, v = _place(self.angles, angle)
        table = self.coefficients
        low = table[i, j] * (1.0 - v) + table[i, j + 1] * v
        high = table[i + 1, j] * (1.0 - v) + table[i + 1, j + 1] * v
        return np.where(tangent <= self.tangents[-1], low * (1.0 - u) + high * u, 0.0)


def read_surface(path) -> RoadSurface:
    """Read a table of reduced luminance coefficients times 10 000.

    Parameters
    ----------
    path : str or Path
        Comma-separated: a line of the angles beta in degrees, from 0 to 180, behind its first cell; then a line for each
        tan gamma from 0 on, which stands first. Cells may be empty: no light comes to the driver from there.

    Raises
    ------
    FileFormatError    It says the line, what was found and what was expected.
    """
    path = Path(path)
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise FileFormatError(path, f"is longer than {LARGEST_FILE} bytes")
        with path.open(newline="", encoding="utf-8") as file:
            rows = [row for row in csv.reader(file) if any(cell.strip() for cell in row)]
    except OSError as error:
        raise FileFormatError(path, f"cannot be read ({error.strerror})") from None
    except (csv.Error, UnicodeDecodeError) as error:
        raise FileFormatError(path, f"is no comma-separated text ({error})") from None
    if len(rows) < 3 or len(rows[0]) < 3:
        raise FileFormatError(
            path, "expected a line of angles and at least two lines of coefficients, found fewer"
        )
    width = len(rows[0])
    angles = _ascending(path, "angles beta", [_number(path, 1, cell) for cell in rows[0][1:]])
    if angles[0] != 0.0 or angles[-1] != 180.0:
        raise FileFormatError(
            path, f"line 1: angles go from {angles[0]:g} to {angles[-1]:g}, expected 0 to 180"
        )
    table = []
    for line, row in enumerate(rows[1:], start=2):
        if len(row) > width:
            raise FileFormatError(
                path, f"line {line} has {len(row)} cells, expected {width} at most"
            )
        cells = [_number(path, line, cell) for cell in row]
        table.append(cells + [0.0] * (width - len(cells)))
    table = np.array(table)
    tangents = _ascending(path, "tan gamma", table[:, 0])
    if tangents[0] != 0.0:
        raise FileFormatError(path, f"tan gamma begins with {tangents[0]:g}, expected 0")
    if not table[:, 1:].any():
        raise FileFormatError(path, "every coefficient is 0, expected some above 0")
    return RoadSurface(path.stem.upper(), tangents, angles, SCALE * table[:, 1:])


def find_surface(name: str) -> RoadSurface:
    """Return a surface by its name such as ``C2``, or read the table of a file.

    Raises
    ------
    SceneError    There is none of this name.
    FileFormatError    As of `read_surface`.
    """
    known = roads.files()
    if name.upper() in known:
        remark = roads.REMARKS.get(name.upper())
        return replace(read_surface(known[name.upper()]), remarks=(remark,) if remark else ())
    if Path(name).suffix.lower() == ".csv":
        return read_surface(name)
    there = ", ".join(known)
    raise SceneError(f"there is no road surface '{name}'; there are {there}, or name a .csv file")


def _place(grid: np.ndarray, value) -> tuple[np.ndarray, np.ndarray]:
    """Cell of a grid and place in it, 0 to 1."""
    cell = np.clip(np.searchsorted(grid, value, side="right") - 1, 0, len(grid) - 2)
    return cell, np.clip((value - grid[cell]) / (grid[cell + 1] - grid[cell]), 0.0, 1.0)


def _number(path: Path, line: int, cell: str) -> float:
    if not cell.strip():
        return 0.0
    value = parse_number(cell.strip())
    if value is None or not 0.0 <= value <= 1e6:
        raise FileFormatError(
            path, f"line {line}: expected a number from 0 on, found '{cell[:40]}'"
        )
    return value


def _ascending(path: Path, name: str, values) -> np.ndarray:
    values = np.asarray(values, dtype=np.float64)
    if not (np.diff(values) > 0.0).all():
        raise FileFormatError(path, f"{name} do not ascend")
    return values
