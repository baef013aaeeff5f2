"""The numbers of an LM-63 file: counts, factors, opening, angles and intensities, checked."""

from dataclasses import dataclass

import numpy as np

from ....errors import FileFormatError
from ....reading.remarks import Remark
from ....reading.text import parse_number
from ..record import TiltTable
from .angles import check_vertical, fits_angles, plane_symmetry, read_angles, side_symmetry
from .header import TILT_LINE, Header
from .numbers import Numbers, commas_may_be_decimal

MAXIMUM_ANGLES = 10_000
"""Most angles of a kind."""

MAXIMUM_VALUES = 4_000_000
"""Most intensities."""

MAXIMUM_INTENSITY = 1e12
"""Brighter than anything that shines; more is a mistake. [cd]"""

UNUSUAL_INTENSITY = 1e8
"""More than of a strong searchlight. [cd]"""

MAXIMUM_FLUX = 1e12
"""Of a lamp. [lm]"""

MAXIMUM_FACTOR = 1e9
"""Of the factors on the intensities; its inverse is the smallest one."""

USUAL_BALLAST = (0.1, 2.0)
"""Ballast factors outside are remarked on."""

MAXIMUM_SIZE = 1000.0
"""Of the luminous opening. [m]"""

MAXIMUM_TILTS = 1000
"""Most angles of a TILT table."""

FOOT = 0.3048
"""[m]"""

_TYPES = {1: "C", 2: "B", 3: "A"}


@dataclass(eq=False)
class Data:
    """The numbers of a file, with what they mean.

    Parameters
    ----------
    lamps : int    Their number, 0 if unknown.
    lumens : float    Of one lamp [lm]; 0 or less: the photometry is absolute.
    photometric_type : str    ``A``, ``B`` or ``C``.
    size : (float, float, float)    Width, length and height of the opening, with their signs. [m]
    watts : float    0 if unknown. [W]
    vertical, horizontal : (n,), (m,) float64 array    [degree]
    symmetry : str    As of `LuminaireFile`.
    candela : (m, n) float64 array    With all factors but the tilt's. [cd]
    generation : str    How the file came to be, as LM-63-2019 tells.
    tilt : TiltTable or None
    size_line, angle_line : int    Where the size and the horizontal angles stand.
    """

    lamps: int
    lumens: float
    photometric_type: str
    size: tuple[float, float, float]
    watts: float
    vertical: np.ndarray
    horizontal: np.ndarray
    symmetry: str
    candela: np.ndarray
    generation: str
    tilt: TiltTable | None
    size_line: int
    angle_line: int


def read_content(path, header: Header, lines: list[str], remarks: list[Remark]) -> Data:
    """Read everything behind the TILT line; where commas cannot be separators, they are decimal signs.

    Parameters
    ----------
    path : str or Path    For messages.
    lines : list of str    Behind the TILT line.
    remarks : list of Remark    Departures are added.

    Raises
    ------
    FileFormatError    Anything that decides about light is missing or impossible; with the line.
    """
    first = header.tilt_line + 1
    found: list[Remark] = []
    try:
        content = _read_data(Numbers(path, lines, first), lines, header, found)
    except FileFormatError as error:
        if not commas_may_be_decimal(lines):
            raise
        line = first + next(row for row, line in enumerate(lines) if "," in line)
        found = [Remark("decimal commas instead of points", line)]
        try:
            content = _read_data(Numbers(path, lines, first, True), lines, header, found)
        except FileFormatError as other:
            # The reading that got further is the one that was meant.
            raise (other if (other.line or 0) > (error.line or 0) else error) from None
    remarks += found
    return content


def read_tilt(numbers: Numbers) -> TiltTable:
    """Take a TILT table.

    Raises
    ------
    FileFormatError    It is incomplete or impossible.
    """
    geometry = numbers.whole("the lamp-to-luminaire geometry")
    if geometry not in {1, 2, 3}:
        numbers.reject(f"lamp-to-luminaire geometry {geometry}, expected 1, 2 or 3")
    count = numbers.whole("the number of tilt angles")
    if not 1 <= count <= MAXIMUM_TILTS:
        numbers.reject(f"{count} tilt angles, expected 1 to {MAXIMUM_TILTS}")
    angles = numbers.numbers(count, "tilt angles")
    if np.any(np.diff(angles) <= 0.0) or angles[0] < 0.0 or angles[-1] > 180.0:
        numbers.reject("the tilt angles do not ascend within 0 to 180")
    factors = numbers.numbers(count, "tilt factors")
    if factors.min() < 0.0 or factors.max() > MAXIMUM_FACTOR:
        numbers.reject(f"a tilt factor of {factors.min():g}, expected 0 or more")
    return TiltTable(geometry, angles, factors)


def _read_data(numbers: Numbers, lines, header: Header, remarks) -> Data:
    tilt = read_tilt(numbers) if header.tilt == "INCLUDE" else None
    lamps = _lamp_count(numbers, remarks)
    lumens = _lumens(numbers, remarks)
    multiplier = _factor(numbers, "the candela multiplier")
    counts = _count(numbers, "vertical", 2), _count(numbers, "horizontal", 1)
    if counts[0] * counts[1] > MAXIMUM_VALUES:
        numbers.reject(
            f"{counts[0]} x {counts[1]} intensities, expected at most {MAXIMUM_VALUES} altogether"
        )
    code = numbers.whole("the photometric type")
    if code not in _TYPES:
        numbers.reject(f"photometric type {code}, expected 1 (C), 2 (B) or 3 (A)")
    kind = _TYPES[code]
    if kind != "C" and counts[1] < 2:
        numbers.reject(f"one horizontal angle, but type {kind} needs at least 2")
    size_line, size = _size(numbers, remarks)
    start = numbers.position
    try:
        factor, watts, generation = _read_factors(numbers, header.year, remarks)
        vertical, horizontal, symmetry, is_usual, angle_line = _read_grid(
            numbers, counts, kind, header.year, remarks
        )
        at = numbers.position
        raw = numbers.numbers(
            counts[0] * counts[1], f"intensities ({counts[1]} planes of {counts[0]})"
        )
    except FileFormatError:
        if _lacks_factors(numbers, start, counts, kind):
            numbers.fail(
                "ballast factor, second factor and input watts are missing: the angles follow the height"
                " of the opening; expected these three numbers between them",
                start,
            )
        raise
    candela = _check_candela(numbers, raw, at, multiplier * factor, remarks)
    may_go_on = is_usual and not numbers.decimal_comma
    _check_rest(numbers, lines, header.tilt_line + 1, counts[0] if may_go_on else 0, remarks)
    return Data(
        lamps=lamps,
        lumens=lumens,
        photometric_type=kind,
        size=size,
        watts=watts,
        vertical=vertical,
        horizontal=horizontal,
        symmetry=symmetry,
        candela=candela.reshape(counts[1], counts[0]),
        generation=generation,
        tilt=tilt,
        size_line=size_line,
        angle_line=angle_line,
    )


def _lamp_count(numbers, remarks) -> int:
    count = numbers.whole("the number of lamps")
    if count < 1:
        remarks.append(Remark(f"{count} lamps, taken as unknown", numbers.last_line))
        return 0
    return count


def _lumens(numbers, remarks) -> float:
    lumens = numbers.number("the lumens per lamp")
    if lumens > MAXIMUM_FLUX:
        numbers.reject(f"{lumens:g} lumens per lamp, expected at most {MAXIMUM_FLUX:g}")
    if lumens <= 0.0 and lumens != -1.0:
        text = f"{lumens:g} lumens per lamp instead of -1, taken as absolute photometry"
        remarks.append(Remark(text, numbers.last_line))
    return lumens


def _factor(numbers, what) -> float:
    value = numbers.number(what)
    if not 1.0 / MAXIMUM_FACTOR <= value <= MAXIMUM_FACTOR:
        limits = f"{1.0 / MAXIMUM_FACTOR:g} to {MAXIMUM_FACTOR:g}"
        numbers.reject(f"{what} is {value:g}, expected a positive factor of {limits}")
    return value


def _count(numbers, which, fewest) -> int:
    count = numbers.whole(f"the number of {which} angles")
    if not fewest <= count <= MAXIMUM_ANGLES:
        numbers.reject(f"{count} {which} angles, expected {fewest} to {MAXIMUM_ANGLES}")
    return count


def _size(numbers, remarks) -> tuple[int, tuple[float, float, float]]:
    """Line and signed sizes of the opening. [m]"""
    code = numbers.number("the unit of length")
    if code not in {1.0, 2.0}:
        text = f"unit of length {code:g} instead of 1 (feet) or 2 (metres), taken as metres"
        remarks.append(Remark(text, numbers.last_line))
    unit = FOOT if code == 1.0 else 1.0
    line = numbers.line()
    size = []
    for what in ("width", "length", "height"):
        size.append(unit * numbers.number(f"the {what} of the opening"))
        if abs(size[-1]) > MAXIMUM_SIZE:
            numbers.reject(
                f"an opening of {size[-1]:g} m, expected at most {MAXIMUM_SIZE:g} m ({what})"
            )
    return line, tuple(size)


def _read_factors(numbers, year, remarks) -> tuple[float, float, str]:
    """Factor on the intensities, watts, and how the file came to be."""
    ballast = _factor(numbers, "the ballast factor")
    low, high = USUAL_BALLAST
    if not low <= ballast <= high:
        text = f"an unusual ballast factor of {ballast:g}, applied as it is"
        remarks.append(Remark(text, numbers.last_line))
    generation = ""
    if year < 1995:
        ballast *= _factor(numbers, "the ballast-lamp photometric factor")
    else:
        second = numbers.number("the number behind the ballast factor")
        generation = generation_type(second) if year == 2019 else ""
        if second != 1.0 and not generation:
            text = f"{second:g} behind the ballast factor instead of 1, ignored"
            remarks.append(Remark(text, numbers.last_line))
    watts = numbers.number("the input watts")
    if watts < 0.0:
        remarks.append(Remark(f"{watts:g} input watts, taken as unknown", numbers.last_line))
    return ballast, max(watts, 0.0), generation


def generation_type(code: float) -> str:
    """Return in words the file generation type of LM-63-2019, empty if there is no such code."""
    digits = f"{code:.5f}"
    if abs(code - float(digits)) > 1e-9 or digits[:2] != "1." or set(digits[2:]) - set("01"):
        return ""
    accredited, interpolated, scaled, simulated, undefined = (digit == "1" for digit in digits[2:])
    if undefined:
        return "undefined"
    if simulated:
        return "computer simulation"
    words = ["accredited laboratory" if accredited else "laboratory without accreditation"]
    words += ["interpolated angles"] * interpolated + ["scaled lumens"] * scaled
    return ", ".join(words)


def _read_grid(numbers, counts, kind, year, remarks):
    """Vertical and horizontal angles, symmetry, whether all is as usual, and the line of the horizontal angles."""
    line = numbers.line()
    vertical = read_angles(numbers, counts[0], kind, "vertical")
    is_usual = check_vertical(vertical, kind, line, remarks)
    line = numbers.line()
    horizontal = read_angles(numbers, counts[1], kind, "horizontal")
    if kind == "C":
        symmetry, is_known = plane_symmetry(numbers.path, horizontal, year, line, remarks)
    else:
        symmetry, is_known = side_symmetry(vertical, horizontal, line, remarks)
    return vertical, horizontal, symmetry, is_usual and is_known, line


def _lacks_factors(numbers, start, counts, kind) -> bool:
    """Whether the angles come where ballast factor, second factor and watts should be."""
    tokens = numbers.tokens[start:]
    angles = [parse_number(token) for token in tokens[: sum(counts)]]
    if len(angles) < sum(counts) or None in angles:
        return False
    if fits_angles(np.array(angles), counts[0], kind):
        found = sum(parse_number(token) is not None for token in tokens)
        return found < 3 + sum(counts) + counts[0] * counts[1]
    # Angles that do not ascend either: then as many numbers are missing, and the lines tell it.
    is_short_by_three = len(tokens) == sum(counts) + counts[0] * counts[1]
    on_lines = numbers.tokens_on_line(start), numbers.tokens_on_line(start + counts[0])
    return is_short_by_three and on_lines == counts != (3, 3)


def _check_candela(numbers, raw, start, factor, remarks) -> np.ndarray:
    """Return the intensities with the factor applied. [cd]"""
    negative = np.flatnonzero(raw < 0.0)
    if len(negative):
        numbers.fail(
            f"{len(negative)} negative intensities down to {raw.min():g}, expected none",
            start + negative[0],
        )
    peak = int(np.argmax(raw))
    if raw[peak] > MAXIMUM_INTENSITY / factor:
        numbers.fail(
            f"an intensity of {raw[peak]:g} x {factor:g} cd, expected at most"
            f" {MAXIMUM_INTENSITY:g} cd",
            start + peak,
        )
    candela = raw * factor
    if not candela.any():
        numbers.fail("all intensities are 0, expected some light", start)
    if candela[peak] > UNUSUAL_INTENSITY:
        text = f"a peak of {candela[peak]:.3g} cd, more than a strong searchlight's"
        remarks.append(Remark(text, numbers.line(start + peak)))
    return candela


def _check_rest(numbers, lines, first_line, allowed, remarks):
    """Refuse a second luminaire and numbers too many; fewer than ``allowed`` may follow on lines of their own."""
    if not numbers.remaining:
        return
    line, end = numbers.line(), numbers.last_line
    row = next(
        (row for row in range(line - first_line, len(lines)) if TILT_LINE.match(lines[row])), None
    )
    if row is not None:
        raise FileFormatError(
            numbers.path,
            "a second luminaire begins, expected one; split the file",
            first_line + row,
        )
    rest = numbers.tokens[numbers.position :]
    count = next((n for n, token in enumerate(rest) if parse_number(token) is None), len(rest))
    if not count:
        remarks.append(
            Remark(f"'{rest[0][:40]}' and what follows the intensities is ignored", line)
        )
        return
    stands_apart = line > end and numbers.tokens_on_line(numbers.position - 1) > 1
    if count >= allowed or not stands_apart:
        numbers.fail(f"{count} numbers more than the counts of angles announce")
    remarks.append(Remark(f"{count} numbers behind the intensities are ignored", line))
