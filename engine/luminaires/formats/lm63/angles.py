"""Angles of LM-63 files: what lists are allowed, and which symmetry they tell."""

import numpy as np

from ....errors import FileFormatError
from ....reading.remarks import Remark
from .numbers import Numbers

NEAR = 1e-3
"""Angles this near are the same in the comparison with the ends that the standard allows. [degree]"""

APART = 1e-6
"""Neighbouring angles must differ by more. [degree]"""

_RANGES = {
    "C": ((0.0, 180.0), (-360.0, 720.0)),
    "A": ((-90.0, 90.0), (-180.0, 180.0)),
    "B": ((-180.0, 180.0), (-90.0, 90.0)),
}
"""Within which the vertical and the horizontal angles must lie. [degree]"""


def read_angles(numbers: Numbers, count: int, photometric_type: str, which: str) -> np.ndarray:
    """Take and check a list of angles.

    Parameters
    ----------
    count : int
    photometric_type : str
    which : str    ``vertical`` or ``horizontal``.

    Returns
    -------
    (count,) float64 array    [degree]

    Raises
    ------
    FileFormatError    There are too few, or they do not ascend or lie outside what the type allows; with the line.
    """
    start = numbers.position
    angles = numbers.numbers(count, f"{which} angles")
    low, high = _RANGES[photometric_type][which == "horizontal"]
    outside = np.flatnonzero((angles < low - APART) | (angles > high + APART))
    if len(outside):
        at = outside[0]
        numbers.fail(
            f"the {which} angle {angles[at]:g} lies outside {low:g} to {high:g}, which type"
            f" {photometric_type} allows",
            start + at,
        )
    wrong = np.flatnonzero(np.diff(angles) <= APART)
    if len(wrong):
        at = wrong[0]
        numbers.fail(
            f"the {which} angle {angles[at + 1]:g} follows {angles[at]:g}, expected ascending angles,"
            " each once",
            start + at + 1,
        )
    return np.clip(angles, low, high)


def fits_angles(tokens: np.ndarray, vertical_count: int, photometric_type: str) -> bool:
    """Whether numbers look like a list of vertical and one of horizontal angles.

    Parameters
    ----------
    tokens : (n,) array    The vertical angles and all others behind them.
    """
    for angles, bounds in zip(
        (tokens[:vertical_count], tokens[vertical_count:]), _RANGES[photometric_type], strict=True
    ):
        if np.any(np.diff(angles) <= APART) or angles[0] < bounds[0] or angles[-1] > bounds[1]:
            return False
    return True


def _is(angle, *expected) -> bool:
    return any(abs(angle - value) < NEAR for value in expected)


def check_vertical(angles, photometric_type, line, remarks) -> bool:
    """Remark on vertical angles that do not begin or end where the standard says; return whether they do."""
    if photometric_type == "C":
        usual = _is(angles[0], 0.0, 90.0) and _is(angles[-1], 90.0, 180.0)
        expected = "0 or 90 to 90 or 180"
    else:
        usual = _is(angles[0], -90.0, 0.0) and _is(angles[-1], 90.0)
        expected = "-90 or 0 to 90"
    if not usual:
        text = (
            f"vertical angles from {angles[0]:g} to {angles[-1]:g} instead of {expected};"
            " nothing is emitted outside"
        )
        remarks.append(Remark(text, line))
    return usual


def side_symmetry(vertical, horizontal, line, remarks) -> tuple[str, bool]:
    """Return the symmetry that the angles of types A and B tell, and whether they are as the standard says.

    Horizontal angles from 0 are mirrored left and right, about the plane that type C calls C90-C270. Of vertical ones from 0
    the standard does not say what is below; they are mirrored too.
    """
    is_usual = _is(horizontal[0], -90.0, 0.0) and _is(horizontal[-1], 90.0)
    if not is_usual:
        text = (
            f"horizontal angles from {horizontal[0]:g} to {horizontal[-1]:g} instead of -90 or 0 to"
            " 90; nothing is emitted outside"
        )
        remarks.append(Remark(text, line))
    if _is(vertical[0], 0.0):
        remarks.append(Remark("vertical angles from 0: the lower half mirrors the upper one", line))
        return ("quadrant" if _is(horizontal[0], 0.0) else "C0-C180"), False
    return ("C90-C270" if _is(horizontal[0], 0.0) else "none"), is_usual


def plane_symmetry(path, angles, year, line, remarks) -> tuple[str, bool]:
    """Return the symmetry that the horizontal angles of type C tell, and whether the standard knows them.

    Raises
    ------
    FileFormatError    They cover neither the turn nor a part that symmetry completes.
    """
    first, last = angles[0], angles[-1]
    span = last - first
    text = f"horizontal angles from {first:g} to {last:g}"
    if len(angles) == 1:
        if not _is(first, 0.0):
            text = f"a single plane at {first:g} instead of 0, taken for all"
            remarks.append(Remark(text, line))
        return "rotational", _is(first, 0.0)
    if span > 360.0 + NEAR:
        raise FileFormatError(path, f"{text}, expected at most a full turn", line)
    symmetry = {90.0: "quadrant", 180.0: "C0-C180", 360.0: "none"}.get(round(span, 2))
    if symmetry in {"quadrant", "C0-C180"} and not _is(first % 90.0, 0.0, 90.0):
        symmetry = None
    if symmetry == "C0-C180" and _is(first % 180.0, 90.0):
        symmetry = "C90-C270"
    if symmetry and (_is(first, 0.0) or (year < 2002 and _is(first, 90.0) and _is(span, 180.0))):
        return symmetry, True
    if symmetry:
        meaning = {"none": "all around"}.get(symmetry, f"symmetric ({symmetry})")
        remarks.append(
            Remark(f"{text}, which LM-63-{year} does not know, taken as {meaning}", line)
        )
        return symmetry, False
    gap = 360.0 - span
    if gap > max(90.0, np.diff(angles).max()) + NEAR:
        raise FileFormatError(path, f"{text}, expected 0 to 0, 90, 180 or 360, or 90 to 270", line)
    text += f"; the {gap:g} degrees from the last to the first are interpolated"
    remarks.append(Remark(text, line))
    return "none", False


def mirror_half(angles, values) -> tuple[np.ndarray, np.ndarray]:
    """Add the mirror image of angles that begin at 0, with their rows of values (n, m).

    Returns
    -------
    (2 n - 1,) array, (2 n - 1, m) array
    """
    return np.concatenate([-angles[:0:-1], angles]), np.concatenate([values[:0:-1], values])
