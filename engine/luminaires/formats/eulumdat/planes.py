"""The table of a EULUMDAT file: C-planes, polar angles, and the intensities of those planes that are stored."""

from dataclasses import dataclass

import numpy as np

from ....errors import FileFormatError
from ....reading.remarks import Remark
from ....reading.text import parse_number
from ..symmetry import expand_planes
from .fields import ANGLE_OR_INTENSITY, Fields, shortened

MAXIMUM_PLANES = 3601
MAXIMUM_POLARS = 1801
MAXIMUM_VALUES = 1_000_000
"""Largest table; the format's own programs stop at 721 planes of 361 values."""

SYMMETRIES = ("none", "rotational", "C0-C180", "C90-C270", "quadrant")
"""Symmetry by Isym."""

NEAR = 1e-4
"""Angles this near are the same. [degree]"""

_DIRECT_RATIOS = (10, 0, 11, *range(1, 10), 12)
"""How many direct ratios there may be; the format says 10."""


@dataclass(frozen=True, eq=False)
class Planes:
    """The stored planes.

    Parameters
    ----------
    azimuths : (n,) float64 array    As stored, in the file's order. [degree]
    polars : (p,) float64 array    Ascending. [degree]
    values : (n, p) float64 array    As stored.
    symmetry : str    As of `LuminaireFile`, by which they stand for the whole turn.
    lines : (int, int, int)    Where C-planes, polar angles and intensities begin.
    """

    azimuths: np.ndarray
    polars: np.ndarray
    values: np.ndarray
    symmetry: str
    lines: tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class _Layout:
    """A way to read the numbers behind the lamps; ``stored`` are the places of the stored planes in the list of planes."""

    ratios: int
    azimuths: np.ndarray
    polars: np.ndarray
    stored: np.ndarray
    symmetry: str


def read_planes(
    path, rows, isym: int, plane_count: int, polar_count: int, end: int, remarks
) -> Planes:
    """Read everything behind the lamps: direct ratios (which are skipped), angles and intensities.

    Parameters
    ----------
    rows : list of (int, str)    Line numbers and texts.
    isym, plane_count, polar_count : int    As the head of the file says.
    end : int    Last line of the file.
    remarks : list of Remark    Receives departures.

    Raises
    ------
    FileFormatError    Numbers are missing, are too many or do not make sense; says the line and what would fit.
    """
    numbers, lines = _read_numbers(path, rows, remarks)
    layout = None
    for ratios in _DIRECT_RATIOS:
        layout = _fitting_layout(numbers, ratios, isym, plane_count, polar_count)
        if layout is not None:
            break
    if layout is None:
        _refuse(path, numbers, [*lines, end], isym, plane_count, polar_count)
    if layout.ratios != 10:
        text = f"{layout.ratios} direct ratios instead of 10, or a line above is missing or doubled"
        remarks.append(Remark(text, lines[0]))
    start = layout.ratios + plane_count + polar_count
    values = numbers[start:].reshape(len(layout.stored), polar_count)
    listed = numbers[layout.ratios : layout.ratios + plane_count]
    planes = Planes(
        listed[layout.stored],
        layout.polars,
        values,
        layout.symmetry,
        (lines[layout.ratios], lines[layout.ratios + plane_count], lines[start]),
    )
    _check_values(path, values.ravel(), lines[start:])
    _remark_on_planes(path, layout, planes, isym, listed, remarks)
    _remark_on_polars(planes, remarks)
    return planes


def _read_numbers(path, rows, remarks) -> tuple[np.ndarray, list[int]]:
    """All numbers with their lines. Blank lines are left out: they are no values, and the counts tell if one is missing."""
    filled = [row for row in rows if row[1].strip()]
    behind = len(filled)
    while behind and not any(character.isdigit() for character in filled[behind - 1][1]):
        behind -= 1
    if behind < len(filled):
        line, text = filled[behind]
        remarks.append(Remark(f"'{shortened(text.strip())}' behind the values, ignored", line))
    filled = filled[:behind]
    fields = Fields(path, filled)
    numbers = []
    for line, text in filled:
        if len(text.split()) > 1 and _is_several(text):
            raise FileFormatError(
                path,
                f"several values on one line ('{shortened(text.strip())}'), expected one",
                line,
            )
        numbers.append(fields.number("an angle or an intensity", ANGLE_OR_INTENSITY))
    remarks += fields.remarks()
    return np.array(numbers), [line for line, _ in filled]


def _is_several(text: str) -> bool:
    return sum(parse_number(token.replace(",", ".")) is not None for token in text.split()) > 1


def _fitting_layout(numbers, ratios, isym, plane_count, polar_count) -> _Layout | None:
    rest = len(numbers) - ratios - plane_count - polar_count
    if rest <= 0 or rest % polar_count:
        return None
    azimuths = _ascending(numbers[ratios : ratios + plane_count])
    polars = numbers[ratios + plane_count : ratios + plane_count + polar_count]
    if azimuths is None or _first_wrong_polar(polars) is not None:
        return None
    if ratios != 10 and not _is_usual(azimuths, polars):
        # A list that is read from a wrong place on can ascend too.
        return None
    stored, symmetry = _stored_planes(azimuths, isym, rest // polar_count)
    if stored is None:
        return None
    return _Layout(ratios, azimuths, polars, stored, symmetry)


def _is_usual(azimuths, polars) -> bool:
    """Whether angles begin and end as the format says."""
    ends = (azimuths[0], 0.0), (polars[0] % 90.0, 0.0), (polars[-1] % 90.0, 0.0)
    return all(abs(angle - expected) < NEAR for angle, expected in ends) and polars[-1] > NEAR


def _ascending(azimuths) -> np.ndarray | None:
    """The list of planes ascending, past 360 if it starts elsewhere than at 0; None if it is none."""
    if azimuths.min() < 0.0 or azimuths.max() > 360.0 + NEAR:
        return None
    turned = azimuths.copy()
    steps = np.flatnonzero(np.diff(azimuths) <= 0.0)
    if len(steps) == 1 and steps[0] == 0 and abs(azimuths[0] - 360.0) < NEAR:
        turned[0] = 0.0
    elif len(steps) == 1:
        turned[steps[0] + 1 :] += 360.0
    if np.any(np.diff(turned) < NEAR) or turned[-1] - turned[0] > 360.0 + NEAR:
        return None
    return turned


def _first_wrong_polar(polars) -> int | None:
    """Place of the first polar angle that does not ascend or lies outside 0 to 180."""
    wrong = (polars < 0.0) | (polars > 180.0)
    wrong[1:] |= np.diff(polars) < NEAR
    found = np.flatnonzero(wrong)
    return int(found[0]) if len(found) else None


def _stored_planes(azimuths, isym, count) -> tuple[np.ndarray | None, str]:
    """Places of the stored planes in the list, and how they stand for the turn; None if no way fits their number."""
    everything = np.arange(len(azimuths))
    if count == 1 and (isym == 1 or len(azimuths) == 1):
        return everything[:1], "rotational"
    part = _part(azimuths, isym)
    if len(part) == count:
        return part, SYMMETRIES[isym]
    if count == len(azimuths):
        return everything, "none"
    return None, ""


def _part(azimuths, isym) -> np.ndarray:
    """Places of the planes that are stored for a symmetry, in the order of their values."""

    def between(low, high):
        return np.flatnonzero((azimuths > low - NEAR) & (azimuths < high + NEAR))

    match isym:
        case 1:
            return np.arange(1)
        case 2:
            return between(0.0, 180.0)
        case 3 if abs(azimuths[0] - 90.0) < NEAR:
            return between(90.0, 270.0)
        case 3 if azimuths[-1] > 360.0 + NEAR:
            return between(270.0, 450.0)
        case 3:
            # C270 to C360, then from C0, which is left out where the list has C360 too.
            after = between(0.0, 90.0)
            whole = abs(azimuths[-1] - azimuths[0] - 360.0) < NEAR
            return np.concatenate([between(270.0, 360.0), after[1:] if whole else after])
        case 4:
            return between(0.0, 90.0)
    return np.arange(len(azimuths))


def _refuse(path, numbers, lines, isym, plane_count, polar_count):
    """Say what is wrong, read in the way that the format says."""
    end = lines[-1]
    needed = 10 + plane_count + polar_count
    if len(numbers) <= needed:
        what = "C-planes" if len(numbers) < 10 + plane_count else "polar angles or intensities"
        raise FileFormatError(
            path,
            f"the file ends in the {what}: {len(numbers)} numbers are there behind the lamps, expected"
            f" 10 direct ratios, {plane_count} C-planes, {polar_count} polar angles and the intensities",
            end,
        )
    azimuths = numbers[10 : 10 + plane_count]
    turned = _ascending(azimuths)
    if turned is None:
        outside = np.flatnonzero((azimuths < 0.0) | (azimuths > 360.0 + NEAR))
        at = int(outside[0] if len(outside) else np.flatnonzero(np.diff(azimuths) < NEAR)[0] + 1)
        raise FileFormatError(
            path,
            f"{azimuths[at]:g} as C-plane {at + 1} of {plane_count}, expected ascending angles from 0"
            " to 360",
            lines[10 + at],
        )
    at = _first_wrong_polar(numbers[10 + plane_count : needed])
    if at is not None:
        raise FileFormatError(
            path,
            f"{numbers[10 + plane_count + at]:g} as polar angle {at + 1} of {polar_count}, expected"
            " ascending angles from 0 to 180",
            lines[10 + plane_count + at],
        )
    found = len(numbers) - needed
    expected = len(_part(turned, isym))
    message = (
        f"{found} intensities, expected {expected * polar_count} ({expected} planes of {polar_count}"
        f" for Isym {isym}, {plane_count} C-planes)"
    )
    fitting = [
        str(other)
        for other in range(5)
        if _stored_planes(turned, other, found / polar_count)[0] is not None
    ]
    if fitting:
        message += f"; their number fits Isym {' or '.join(fitting)}"
    raise FileFormatError(path, message, end)


def _check_values(path, values, lines) -> None:
    negative = np.flatnonzero(values < 0.0)
    if len(negative):
        at = negative[0]
        raise FileFormatError(
            path,
            f"{len(negative)} negative intensities, the least {values.min():g}, the first"
            f" {values[at]:g}; expected 0 or more",
            lines[at],
        )
    if not values.any():
        raise FileFormatError(path, "all intensities are 0", lines[0])


def _remark_on_planes(path, layout, planes, isym, listed, remarks) -> None:
    """Remark on what the list of C-planes and their number say against the format.

    Parameters
    ----------
    listed : (n,) array    The C-planes as they stand in the file. [degree]
    """
    line, first = planes.lines[0], layout.azimuths[0]
    count, stored = len(listed), len(layout.stored)
    if first != listed[0]:
        remarks.append(Remark("the list of C-planes begins with 360, taken as 0", line))
    elif first > NEAR and count > 1:
        remarks.append(Remark(f"the list of C-planes begins at {first:g} instead of 0", line))
    if stored == 1:
        if isym != 1:
            text = f"Isym {isym} with a single C-plane, taken as symmetric about the vertical"
            remarks.append(Remark(text, line))
        return
    azimuths = layout.azimuths[layout.stored]
    # Those of Isym 3 go on behind C360 from C0.
    azimuths = np.where(azimuths < azimuths[0], azimuths + 360.0, azimuths)
    _check_turn(path, azimuths, layout.symmetry, line)
    if isym and layout.symmetry == "none":
        held = holds_symmetry(
            *expand_planes(planes.azimuths, planes.values, "none"), SYMMETRIES[isym]
        )
        text = f"all {count} C-planes are stored although Isym is {isym}; they are used"
        text += "" if held else f", and are not symmetric as Isym {isym} says"
        remarks.append(Remark(text, planes.lines[2]))
    divisor = {2: 2, 3: 2, 4: 4}.get(isym)
    if divisor and layout.symmetry != "none" and stored != count / divisor + 1:
        text = (
            f"{stored} of {count} listed C-planes are stored, expected 1/{divisor} of them and one"
        )
        remarks.append(Remark(text, line))


def _check_turn(path, azimuths, symmetry, line) -> None:
    """Refuse planes that leave a part of the turn out which no symmetry completes."""
    whole = {"none": 360.0, "quadrant": 90.0}.get(symmetry, 180.0)
    span, step = azimuths[-1] - azimuths[0], np.diff(azimuths).max()
    if whole - span <= (max(90.0, 2.0 * step) if symmetry == "none" else step) + NEAR:
        return
    fitting = {90.0: "; Isym 4 would fit", 180.0: "; Isym 2 or 3 would fit"}.get(round(span, 3), "")
    raise FileFormatError(
        path,
        f"the stored C-planes go from {azimuths[0]:g} to {azimuths[-1]:g} only, expected a span of"
        f" {whole:g}{fitting if symmetry == 'none' else ''}",
        line,
    )


def _remark_on_polars(planes, remarks) -> None:
    first, last = planes.polars[0], planes.polars[-1]
    if not _is_usual(np.zeros(1), planes.polars):
        text = (
            f"polar angles from {first:g} to {last:g} instead of 0 or 90 to 90 or 180; nothing is"
            " emitted outside"
        )
        remarks.append(Remark(text, planes.lines[1]))


def holds_symmetry(azimuths, values, symmetry: str, tolerance: float = 1e-6) -> bool:
    """Whether planes of the whole turn have a symmetry.

    Parameters
    ----------
    azimuths : (a,) array    From 0 to 360. [degree]
    values : (a, p) array
    symmetry : str    As of `LuminaireFile`.
    tolerance : float    Largest difference, in parts of the largest value.
    """
    allowed = tolerance * values.max()
    if symmetry == "rotational":
        return bool(np.ptp(values, axis=0).max() <= allowed)
    mirrors = {"C0-C180": (0.0,), "C90-C270": (180.0,), "quadrant": (0.0, 180.0)}.get(symmetry, ())
    # Both interpolants are linear between the planes and their images, so their values at the planes decide.
    for offset in mirrors:
        image = planes_at(azimuths, values, offset - azimuths)
        if np.abs(image - values).max() > allowed:
            return False
    return True


def planes_at(azimuths, values, places) -> np.ndarray:
    """Planes interpolated at other azimuths.

    Parameters
    ----------
    azimuths : (a,) array    From 0 to 360, or a single one. [degree]
    values : (a, p) array
    places : (m,) array    [degree]

    Returns
    -------
    (m, p) float64 array
    """
    if len(azimuths) == 1:
        return np.repeat(values, len(places), axis=0)
    places = np.mod(places, 360.0)
    low = np.clip(np.searchsorted(azimuths, places, side="right") - 1, 0, len(azimuths) - 2)
    share = ((places - azimuths[low]) / (azimuths[low + 1] - azimuths[low]))[:, None]
    return values[low] * (1.0 - share) + values[low + 1] * share
