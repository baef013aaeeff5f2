"""Tables of TM-33 documents by angle: checked, completed to a grid and brought onto the axes of the photometric type."""

from dataclasses import dataclass

import numpy as np

from ....errors import FileFormatError
from ....reading.remarks import Remark
from ....reading.safe_xml import XmlElement
from ..eulumdat.planes import holds_symmetry
from ..lm63.angles import mirror_half
from ..symmetry import POLE_TOLERANCE, average_poles, expand_planes
from .values import attribute, key_of, number_in, text_of

MAXIMUM_VALUES = 1_000_000
"""Largest table."""

FULL_TURN = 360.0
"""[degree]"""

LONGEST_WAVELENGTH = 1e6
"""[nm]"""

LARGEST = 1e30
"""Larger values, in any unit, are mistakes."""

NEAR = 1e-3
"""Angles this near are the same. [degree]"""

_RANGES = {
    "C": ((-180.0, 360.0), (0.0, 180.0)),
    "A": ((-180.0, 180.0), (-90.0, 90.0)),
    "B": ((-90.0, 90.0), (-180.0, 180.0)),
}
"""Within which h and v must lie. [degree]"""

_SYMMETRIES = {
    "symmnone": "none",
    "none": "none",
    "symmarbitrary": "none",
    "arbitrary": "none",
    "symmbi0": "C0-C180",
    "bi0": "C0-C180",
    "symmbi90": "C90-C270",
    "bi90": "C90-C270",
    "symmquad": "quadrant",
    "quad": "quadrant",
    "symmfull": "rotational",
    "full": "rotational",
}

_HALVES = {"C0-C180", "C90-C270"}

_ALLOWED = {
    "rotational": {"quadrant", *_HALVES, "none"},
    "quadrant": {*_HALVES, "none"},
    "C0-C180": {"none"},
    "C90-C270": {"none"},
    "none": set(),
}
"""As which less symmetric tables a symmetry may be stored."""


@dataclass(frozen=True, eq=False)
class Table:
    """Values by angle, and by wavelength if there are several.

    Parameters
    ----------
    horizontal, vertical : (h,), (v,) float64 array    Ascending. [degree]
    wavelengths : (w,) float64 array    Ascending, a single 0 if the values do not depend on it. [nm]
    values : (h, v, w) float64 array    Multiplied already, not negative.
    symmetry : str or None    As stated, by the names of `LuminaireFile`.
    line : int    Where it begins.
    """

    horizontal: np.ndarray
    vertical: np.ndarray
    wavelengths: np.ndarray
    values: np.ndarray
    symmetry: str | None
    line: int


@dataclass(frozen=True, eq=False)
class Grid:
    """Values on the grid of an `IntensityDistribution`: azimuth (a,) and polar (p,) [degree], values (a, p, w)."""

    azimuth: np.ndarray
    polar: np.ndarray
    values: np.ndarray
    symmetry: str


def read_table(path, element: XmlElement, remarks, spectral: bool = False) -> Table:
    """Read the data of an element, in any order.

    Parameters
    ----------
    element : XmlElement    Holds ``IntData`` with attributes h, v, and w if ``spectral``.
    remarks : list of Remark    Receives departures.

    Raises
    ------
    FileFormatError    Values are missing, doubled, negative or no numbers, or the stated counts are wrong; with the line.
    """
    data = element.findall("IntData")
    if not data:
        data = element.findall("IntensityData")
        if data:
            text = (
                "IntensityData with horz and vert, which the schema does not know, read as IntData"
            )
            remarks.append(Remark(text, data[0].line))
    if not data:
        raise FileFormatError(path, f"{element.tag} holds no IntData", element.line)
    rows = np.empty((len(data), 4))
    for row, item in zip(rows, data, strict=True):
        row[0] = attribute(path, item, "h", "horz")
        row[1] = attribute(path, item, "v", "vert")
        row[2] = attribute(path, item, "w") if spectral else 0.0
        if max(abs(row[0]), abs(row[1])) > FULL_TURN or not 0.0 <= row[2] <= LONGEST_WAVELENGTH:
            raise FileFormatError(
                path, f"{_place(row)}, expected angles in degrees and wavelengths in nm", item.line
            )
        row[3] = number_in(path, item, "an intensity")
        if row[3] < 0.0:
            raise FileFormatError(
                path,
                f"a negative intensity ({row[3]:g}) at {_place(row)}, expected 0 or more",
                item.line,
            )
    lines = [item.line for item in data]
    axes, values = _fill_grid(path, rows, lines, element.line, remarks)
    _check_counts(path, element, len(data), axes, spectral)
    multiplier = _multiplier(path, element)
    if values.max() > LARGEST / multiplier:
        raise FileFormatError(path, f"an intensity of {values.max():g} is too large", element.line)
    values *= multiplier
    if not values.any():
        raise FileFormatError(path, "all intensities are 0", element.line)
    return Table(*axes, values, _stated_symmetry(element, remarks), element.line)


def _place(row) -> str:
    place = f"h={row[0]:g}, v={row[1]:g}"
    return f"{place}, w={row[2]:g}" if row[2] else place


def _fill_grid(path, rows, lines, line, remarks) -> tuple[list[np.ndarray], np.ndarray]:
    """Axes and values (h, v, w) of rows of h, v, w and value in any order."""
    rows[:, :3] = np.round(rows[:, :3], 6)
    axes, places = zip(
        *(np.unique(rows[:, axis], return_inverse=True) for axis in range(3)), strict=True
    )
    shape = tuple(len(axis) for axis in axes)
    size = int(np.prod(shape, dtype=np.int64))
    index = (places[0] * shape[1] + places[1]) * shape[2] + places[2]
    distinct, first = np.unique(index, return_index=True)
    if len(distinct) < size or size > MAXIMUM_VALUES:
        missing = _first_missing(distinct)
        h, v, w = np.unravel_index(missing, shape)
        message = (
            f"{size - len(distinct)} of {size} intensities are missing, the first at"
            f" {_place((axes[0][h], axes[1][v], axes[2][w]))}; expected every h with every v"
        )
        if size > MAXIMUM_VALUES:
            message = (
                f"a grid of {' x '.join(map(str, shape))}, expected at most {MAXIMUM_VALUES} values"
            )
        raise FileFormatError(path, message, line)
    values = np.empty(size)
    values[distinct] = rows[first, 3]
    if len(distinct) < len(rows):
        differing = np.flatnonzero(values[index] != rows[:, 3])
        if len(differing):
            at = differing[0]
            raise FileFormatError(
                path, f"two different intensities at {_place(rows[at])}", lines[at]
            )
        remarks.append(Remark(f"{len(rows) - len(distinct)} intensities stand twice", line))
    return list(axes), values.reshape(shape)


def _first_missing(distinct) -> int:
    wrong = np.flatnonzero(distinct != np.arange(len(distinct)))
    return int(wrong[0]) if len(wrong) else len(distinct)


def _check_counts(path, element, count, axes, spectral) -> None:
    expected = {
        "NumberHorz": (len(axes[0]), "angles h"),
        "NumberVert": (len(axes[1]), "angles v"),
    }
    if spectral:
        expected["NumberWavelength"] = (len(axes[2]), "wavelengths")
        # Some count the directions, some all values.
        directions = {len(axes[0]) * len(axes[1]), count}
    else:
        directions = {count}
    for name, (found, what) in expected.items():
        stated = element.find(name)
        if stated is not None and number_in(path, stated, name) != found:
            raise FileFormatError(
                path,
                f"{name} says {text_of(element, name)}, but there are {found} {what}",
                stated.line,
            )
    stated = element.find("NumberMeasured")
    if stated is not None and number_in(path, stated, "NumberMeasured") not in directions:
        raise FileFormatError(
            path,
            f"NumberMeasured says {text_of(element, 'NumberMeasured')}, but there are {count} intensities",
            stated.line,
        )


def _multiplier(path, element) -> float:
    found = element.find("Multiplier")
    if found is None:
        return 1.0
    value = number_in(path, found, "Multiplier")
    if not 0.0 < value <= 1e12:
        raise FileFormatError(
            path, f"{value:g} as Multiplier of the intensities, expected more than 0", found.line
        )
    return value


def _stated_symmetry(element, remarks) -> str | None:
    for name in ("Symm", "SymmType"):
        found = element.find(name)
        if found is None:
            continue
        symmetry = _SYMMETRIES.get(key_of(found.text or ""))
        if symmetry is None:
            text = f"'{text_of(element, name)}' as {name}; the symmetry is taken from the angles"
            remarks.append(Remark(text, found.line))
        return symmetry
    return None


def to_grid(path, table: Table, photometric_type: str, remarks) -> Grid:
    """Bring a table onto the grid of its photometric type, all around.

    Raises
    ------
    FileFormatError    Angles lie outside what the type allows, or leave a part of the turn out; with the line.
    """
    for angles, (low, high), name in zip(
        (table.horizontal, table.vertical), _RANGES[photometric_type], "hv", strict=True
    ):
        if angles[0] < low - NEAR or angles[-1] > high + NEAR:
            raise FileFormatError(
                path,
                f"angles {name} from {angles[0]:g} to {angles[-1]:g}, expected {low:g} to {high:g} of type"
                f" {photometric_type}",
                table.line,
            )
    if len(table.vertical) < 2:
        raise FileFormatError(path, "a single angle v, expected at least two", table.line)
    if photometric_type == "C":
        azimuth, polar, values, symmetry = _around(path, table, remarks)
    else:
        azimuth, polar, values, symmetry = _sides(path, table, photometric_type, remarks)
    count = values.shape[2]
    flat = values.reshape(len(azimuth), -1)
    worst = 0.0
    if count == 1:
        flat, worst = average_poles(azimuth, polar, flat)
    if worst > POLE_TOLERANCE:
        text = (
            f"the planes differ by up to {100 * worst:.1f} % at a pole; their mean is taken there"
        )
        remarks.append(Remark(text, table.line))
    return Grid(azimuth, polar, flat.reshape(len(azimuth), len(polar), count), symmetry)


def _around(path, table: Table, remarks):
    """Grid of type C."""
    stored = _symmetry_of_angles(path, table)
    stated = table.symmetry
    if stated is not None and stated != stored and stored not in _ALLOWED[stated]:
        if stored != "rotational":
            raise FileFormatError(
                path,
                f"the angles h go from {table.horizontal[0]:g} to {table.horizontal[-1]:g}, which is not enough"
                f" for the stated symmetry ({stated})",
                table.line,
            )
        text = f"a single plane with the stated symmetry {stated}, taken as symmetric about the vertical"
        remarks.append(Remark(text, table.line))
    shape = table.values.shape
    flat = table.values.reshape(shape[0], -1)
    azimuth, values = expand_planes(table.horizontal, flat, stored)
    symmetry = stored
    if stated is not None and stored in _ALLOWED[stated]:
        held = holds_symmetry(azimuth, values, stated)
        symmetry = stated if held else stored
        text = f"more planes than the stated symmetry ({stated}) needs; they are used"
        text += "" if held else ", and are not symmetric as stated"
        remarks.append(Remark(text, table.line))
    return azimuth, table.vertical, values.reshape(len(azimuth), *shape[1:]), symmetry


def _symmetry_of_angles(path, table: Table) -> str:
    """How planes of type C stand for the turn, as in LM-63."""
    angles = table.horizontal
    first, span = angles[0], angles[-1] - angles[0]
    if len(angles) == 1:
        return "rotational"
    if abs(first) < NEAR and abs(span - 90.0) < NEAR:
        return "quadrant"
    if abs(span - 180.0) < NEAR and abs(first) < NEAR:
        return "C0-C180"
    if abs(span - 180.0) < NEAR and abs(abs(first) - 90.0) < NEAR:
        return "C90-C270"
    seam = 360.0 - span
    if -NEAR < seam <= max(90.0, 2.0 * np.diff(angles).max()) + NEAR:
        return "none"
    raise FileFormatError(
        path,
        f"the angles h go from {angles[0]:g} to {angles[-1]:g}, expected 0, or 0 to 90, 180 or 360, or 90 to"
        " 270",
        table.line,
    )


def _sides(path, table: Table, photometric_type: str, remarks):
    """Grid of types A and B, whose angles go to both sides of the beam."""
    horizontal, vertical = table.horizontal, table.vertical
    if len(horizontal) < 2:
        raise FileFormatError(
            path, f"a single angle h, expected at least two of type {photometric_type}", table.line
        )
    shape = table.values.shape
    values = table.values
    mirrored = [False, False]
    if table.symmetry != "none" and abs(horizontal[0]) < NEAR:
        horizontal, flat = mirror_half(horizontal, values.reshape(shape[0], -1))
        values = flat.reshape(len(horizontal), *shape[1:])
        mirrored[0] = True
    if table.symmetry != "none" and abs(vertical[0]) < NEAR:
        turned = values.transpose(1, 0, 2)
        vertical, flat = mirror_half(vertical, turned.reshape(len(turned), -1))
        values = flat.reshape(len(vertical), len(horizontal), shape[2]).transpose(1, 0, 2)
        mirrored[1] = True
        text = "angles v begin at 0; the lower half is taken as the mirror image of the upper one"
        remarks.append(Remark(text, table.line))
    symmetry = {
        (True, True): "quadrant",
        (True, False): "C90-C270",
        (False, True): "C0-C180",
        (False, False): "none",
    }[tuple(mirrored)]
    if photometric_type == "A":
        return horizontal, 90.0 + vertical, values, symmetry
    return vertical, 90.0 + horizontal, values.transpose(1, 0, 2), symmetry
