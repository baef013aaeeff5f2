"""EULUMDAT: the photometric files of Europe (.ldt), one value a line.

Departures from the format are read as what is evidently meant, each with a remark. Nothing that decides about light is
guessed: such files are refused with the line and what was expected.

References
----------
A. W. Stockmar: EULUMDAT, ein Leuchtendatenformat für den europäischen Beleuchtungsplaner, Licht '90 (1990) 641-644.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....errors import FileFormatError
from ....reading.content import read_bytes
from ....reading.remarks import Remark
from ....reading.text import decode
from ....scene.distribution import IntensityDistribution, Opening
from ...distribution import flux
from ..radiant import settle_unit
from ..record import LampSet, LuminaireFile
from ..symmetry import POLE_TOLERANCE, average_poles, expand_planes
from .fields import ANGLE, FLUX, LENGTH, PERCENT, POWER, Fields
from .planes import (
    MAXIMUM_PLANES,
    MAXIMUM_POLARS,
    MAXIMUM_VALUES,
    NEAR,
    Planes,
    holds_symmetry,
    read_planes,
)
from .planes import SYMMETRIES as SYMMETRIES_BY_ISYM

MAXIMUM_LAMP_SETS = 20

MAXIMUM_LAMPS = 100_000
"""Most lamps of a set."""

MINIMUM_INTENSITY, MAXIMUM_INTENSITY = 1e-12, 1e12
"""The peak lies between; more than a searchlight and less than anything that can be measured are mistakes. [cd]"""

MAXIMUM_LENGTH = 1e6
"""Longest side. [mm]"""

PLACEHOLDER_FLUX = 1.0
"""Lamps with no more are those of a form that was not filled in. [lm]"""

TOLERANCE = 0.05
"""How far the computed light output ratio and downward fraction may be off before it is remarked on."""

_SPLIT_HINT = "; perhaps a text above it is broken into two lines, or a line is missing"

_LINES_OF_HEAD = 26

MANUFACTURER, REPORT, NAME, NUMBER, FILE, DATE = (
    "MANUFAC",
    "TEST",
    "LUMINAIRE",
    "LUMCAT",
    "_FILE",
    "ISSUEDATE",
)
"""Keys of the metadata: those of LM-63 that mean the same, so that files convert."""

MEASUREMENT_TILT = "_MEASUREMENT_TILT"
"""Key of the metadata for the tilt of the luminaire in the goniometer. [degree]"""


@dataclass(frozen=True)
class _Head:
    """The first 26 lines; lengths in mm, 0 if not stated, fractions in percent; ``lines`` are their numbers."""

    lines: tuple[int, ...]
    isym: int
    plane_count: int
    plane_step: float
    polar_count: int
    polar_step: float
    metadata: dict[str, str]
    housing: tuple[float, float, float]
    area: tuple[float, float]
    heights: tuple[float, float, float, float]
    downward_fraction: float | None
    light_output_ratio: float | None
    factor: float
    lamp_sets: int


def read_eulumdat(path) -> LuminaireFile:
    """Read a file.

    Raises
    ------
    FileFormatError    It cannot be read safely: with the line, what was found and what was expected.
    """
    path = Path(path)
    return parse_eulumdat(read_bytes(path), path)


def parse_eulumdat(data: bytes, path) -> LuminaireFile:
    """Read the content of a file.

    Parameters
    ----------
    data : bytes
    path : str or Path    For messages only.

    Returns
    -------
    LuminaireFile    C0 is the luminaire's +x, C90 its +y; length lies along y, as usual where C0 is across the lamps.

    Raises
    ------
    FileFormatError    As of `read_eulumdat`.
    """
    remarks: list[Remark] = []
    rows = _rows(path, data, remarks)
    fields = Fields(path, rows)
    head = _read_head(fields)
    lamps, is_absolute = _read_lamps(fields, head.lamp_sets, remarks)
    planes = read_planes(
        path, fields.rest(), head.isym, head.plane_count, head.polar_count, rows[-1][0], remarks
    )
    remarks += fields.remarks()
    _compare_steps(head, planes, remarks)
    lamp_flux = lamps[0].luminous_flux
    distribution, symmetry = _distribution(path, head, planes, lamp_flux, remarks)
    _compare_flux(head, distribution, lamp_flux, remarks)
    file = LuminaireFile(
        format="EULUMDAT",
        photometric_type="C",
        symmetry=symmetry,
        distribution=distribution,
        opening=_opening(head, remarks),
        stored_azimuths=planes.azimuths,
        stored_polars=planes.polars,
        is_absolute=is_absolute,
        stated_flux=lamp_flux,
        light_output_ratio=_fraction(head.light_output_ratio),
        downward_fraction=_fraction(head.downward_fraction),
        watts=lamps[0].watts,
        lamps=lamps,
        housing=_housing(head),
        length_axis="y",
        metadata=head.metadata,
        remarks=tuple(sorted(remarks, key=lambda remark: remark.line)),
    )
    return settle_unit(path, file)


def looks_like_eulumdat(text: str) -> bool:
    """Whether lines 2 to 7 hold the numbers that only EULUMDAT has there, or nearly so."""
    rows = [(number, line) for number, line in enumerate(text.split("\n", 27)[:26], start=1)]
    rows = _without_doubled_ends(rows)
    good = 0
    for line, (low, high) in {2: (0, 3), 3: (0, 4), 4: (1, 3601), 6: (2, 1801)}.items():
        try:
            Fields("", rows[line - 1 : line]).whole("", low, high)
        except FileFormatError:
            continue
        good += 1
    return good >= 3


def _rows(path, data, remarks) -> list[tuple[int, str]]:
    """Lines with their numbers, without blank ones at the end."""
    text = decode(path, data)
    if text.count("\n") > 2 * MAXIMUM_VALUES:
        raise FileFormatError(
            path, f"has more than {2 * MAXIMUM_VALUES} lines, too many for EULUMDAT"
        )
    rows = list(enumerate(text.rstrip().split("\n"), start=1))
    single = _without_doubled_ends(rows)
    if len(single) < len(rows):
        remarks.append(Remark("every other line is blank, as doubled line ends make it", 2))
    return single


def _without_doubled_ends(rows) -> list[tuple[int, str]]:
    """The lines without every other one where all of these are blank."""
    if len(rows) > 12 and not any(text.strip() for _, text in rows[1::2]):
        return rows[::2]
    return rows


def _read_head(fields: Fields) -> _Head:
    lines = tuple(line for line, _ in fields.rest()[:_LINES_OF_HEAD])
    metadata = {MANUFACTURER: fields.text("the company (line 1)")}
    ityp = fields.whole("Ityp (the type of luminaire)", 0, 3, _SPLIT_HINT)
    isym = fields.whole("Isym (the symmetry)", 0, 4, _SPLIT_HINT)
    if ityp == 1 and isym != 1:
        fields.remark(f"Ityp 1 says symmetric about the vertical, Isym {isym} counts")
    plane_count = fields.whole("Mc (the number of C-planes)", 1, MAXIMUM_PLANES, _SPLIT_HINT)
    plane_step = fields.number("Dc (the step of the C-planes)", ANGLE, 0.0)
    polar_count = fields.whole("Ng (the number of polar angles)", 2, MAXIMUM_POLARS, _SPLIT_HINT)
    if plane_count * polar_count > MAXIMUM_VALUES:
        fields.fail(
            f"{plane_count} C-planes of {polar_count} intensities, expected at most"
            f" {MAXIMUM_VALUES} together"
        )
    polar_step = fields.number("Dg (the step of the polar angles)", ANGLE, 0.0)
    for key, name in (
        (REPORT, "the report number"),
        (NAME, "the name of the luminaire"),
        (NUMBER, "the number of the luminaire"),
        (FILE, "the name of the file"),
        (DATE, "date and user"),
    ):
        metadata[key] = fields.text(name)
    housing = tuple(_length(fields, f"{side} of the luminaire") for side in _SIDES)
    area = tuple(_length(fields, f"{side} of the luminous area") for side in _SIDES[:2])
    heights = tuple(_length(fields, f"height of the luminous area at {c}") for c in _HEIGHTS)
    downward = _percentage(fields, "the downward flux fraction DFF", 100.0)
    ratio = _percentage(fields, "the light output ratio LORL", 1000.0)
    if ratio == 0.0:
        fields.remark("a light output ratio LORL of 0 %, taken as not stated")
        ratio = None
    factor = fields.number("the conversion factor", default=1.0, assumed="1")
    if factor <= 0.0:
        fields.fail(
            f"{factor:g} as conversion factor of the intensities, expected more than 0, mostly 1"
        )
    tilt = fields.number("the tilt during measurement", ANGLE, 0.0)
    if tilt:
        metadata[MEASUREMENT_TILT] = f"{tilt:g}"
        fields.remark(
            f"measured at a tilt of {tilt:g} degrees; the intensities are taken as they are, so place the"
            " luminaire accordingly"
        )
    lamp_sets = fields.whole("the number of lamp sets", 0, MAXIMUM_LAMP_SETS)
    if lamp_sets == 0:
        fields.fail("no lamp set, so the intensities in cd per 1000 lm have no flux to refer to")
    return _Head(
        lines=lines,
        isym=isym,
        plane_count=plane_count,
        plane_step=plane_step,
        polar_count=polar_count,
        polar_step=polar_step,
        metadata={key: value for key, value in metadata.items() if value},
        housing=housing,
        area=area,
        heights=heights,
        downward_fraction=downward,
        light_output_ratio=ratio,
        factor=factor,
        lamp_sets=lamp_sets,
    )


_SIDES = ("the length", "the width", "the height")
_HEIGHTS = ("C0", "C90", "C180", "C270")


def _length(fields: Fields, name: str) -> float:
    value = fields.number(name, LENGTH, 0.0)
    if not 0.0 <= value <= MAXIMUM_LENGTH:
        fields.remark(f"{value:g} mm as {name}, taken as 0")
        return 0.0
    return value


def _percentage(fields: Fields, name: str, largest: float) -> float | None:
    value = fields.number(name, PERCENT, assumed="not stated")
    if value is not None and not 0.0 <= value <= largest:
        fields.remark(f"{value:g} % as {name}, taken as not stated")
        return None
    return value


def _read_lamps(fields: Fields, count: int, remarks) -> tuple[tuple[LampSet, ...], bool]:
    """The lamp sets, set after set or, in some files, all numbers, then all types and so on; whether they are absolute."""
    rows = fields.take(6 * count, f"{count} lamp sets of 6 lines")
    try:
        return _lamps(fields.path, rows, remarks)
    except FileFormatError as error:
        if count == 1:
            raise
        turned = [rows[item * count + lamp] for lamp in range(count) for item in range(6)]
        try:
            found = _lamps(fields.path, turned, remarks)
        except FileFormatError:
            raise error from None
        text = "the lamp sets stand line by line side by side instead of one after the other"
        remarks.append(Remark(text, rows[0][0]))
        return found


def _lamps(path, rows, remarks) -> tuple[tuple[LampSet, ...], bool]:
    """Lamp sets of six lines each; remarks are added only if all can be read."""
    fields = Fields(path, rows)
    lamps, signs = [], []
    for place in range(1, len(rows) // 6 + 1):
        lamp, sign = _lamp(fields, place)
        lamps.append(lamp)
        signs.append(sign)
    remarks += fields.remarks()
    return tuple(lamps), signs[0] < 0


def _lamp(fields: Fields, place: int) -> tuple[LampSet, int]:
    of = f"of lamp set {place}"
    count = fields.number(f"the number of lamps {of}", default=0.0, assumed="unknown")
    if abs(count) > MAXIMUM_LAMPS or abs(count - round(count)) > 1e-6:
        fields.fail(f"expected the number of lamps {of}, found {count:g}")
    name = fields.text(f"the type of the lamps {of}")
    flux_of_lamps = fields.number(f"the flux of the lamps {of}", FLUX, 0.0)
    if flux_of_lamps <= 0.0 and place == 1:
        fields.fail(
            f"{flux_of_lamps:g} lm as flux of the lamps {of}, expected more than 0: the intensities are in cd"
            " per 1000 lm of it"
        )
    if flux_of_lamps <= 0.0:
        fields.remark(f"{flux_of_lamps:g} lm as flux of the lamps {of}, taken as not stated")
    elif flux_of_lamps <= PLACEHOLDER_FLUX and place == 1:
        fields.remark(
            f"{flux_of_lamps:g} lm as flux of the lamps {of} is that of an empty form; the intensities are"
            " for it, so give the light its true flux"
        )
    colour = fields.text(f"the colour of the lamps {of}")
    rendering = fields.text(f"the colour rendering of the lamps {of}")
    watts = fields.number(f"the power {of}", POWER, 0.0, "not stated")
    if watts < 0.0:
        fields.remark(f"{watts:g} W as power {of}, taken as not stated")
    lamp = LampSet(
        count=abs(round(count)),
        luminous_flux=flux_of_lamps if flux_of_lamps > 0.0 else None,
        watts=watts if watts > 0.0 else None,
        colour_temperature=colour_temperature(colour),
        name=name,
        colour=colour,
        colour_rendering=rendering,
    )
    return lamp, round(count)


def colour_temperature(text: str) -> float | None:
    """Correlated colour temperature that a text tells, such as ``4000 K``, ``nw/4200`` or the code ``840``. [K]

    In the three digits of a lamp's code the first is the colour rendering in tens, the others are hundreds of kelvin.
    """
    joined = re.sub(r"(?<![0-9.,])([0-9]{1,2})[ .,]([0-9]{3})(?=\s*[kK]\b)", r"\1\2", text)
    match = re.search(r"(?<![0-9.,])([0-9]{4,5})(?![0-9])", joined)
    if match and 1000.0 <= float(match[1]) <= 25000.0:
        return float(match[1])
    match = re.search(r"(?<![0-9.,])[5-9]([0-9]{2})(?![0-9.,])", text)
    if match and 1800.0 <= 100.0 * float(match[1]) <= 10000.0:
        return 100.0 * float(match[1])
    return None


def _compare_steps(head: _Head, planes: Planes, remarks) -> None:
    """Remark on steps that the angles do not have; the angles count."""
    for name, line, step, angles in (
        ("Dc", 4, head.plane_step, planes.azimuths),
        ("Dg", 6, head.polar_step, planes.polars),
    ):
        if len(angles) < 2:
            continue
        steps = np.mod(np.diff(angles), 360.0)
        is_even = np.ptp(steps) < 0.01
        if step and (not is_even or abs(steps[0] - step) > 0.01):
            found = f"a step of {steps[0]:g}" if is_even else "uneven steps"
            text = f"{name} is {step:g}, but the angles have {found}; they count"
            remarks.append(Remark(text, head.lines[line]))
        elif not step and is_even:
            text = f"{name} is 0, which means uneven, but the angles have a step of {steps[0]:g}"
            remarks.append(Remark(text, head.lines[line]))


def _distribution(
    path, head: _Head, planes: Planes, lamp_flux, remarks
) -> tuple[IntensityDistribution, str]:
    """All planes in candela, and their symmetry."""
    scale = head.factor * lamp_flux / 1000.0
    brightest = float(planes.values.max())
    if not MINIMUM_INTENSITY <= brightest * scale <= MAXIMUM_INTENSITY:
        raise FileFormatError(
            path,
            f"a largest intensity of {brightest:g} cd/klm, which times the conversion factor and the flux"
            f" lies outside {MINIMUM_INTENSITY:g} to {MAXIMUM_INTENSITY:g} cd",
            planes.lines[2],
        )
    azimuths, values = expand_planes(planes.azimuths, planes.values, planes.symmetry)
    values, worst = average_poles(azimuths, planes.polars, values)
    if worst > POLE_TOLERANCE:
        text = (
            f"the planes differ by up to {100 * worst:.1f} % at a pole; their mean is taken there"
        )
        remarks.append(Remark(text, planes.lines[2]))
    symmetry, declared = planes.symmetry, SYMMETRIES_BY_ISYM[head.isym]
    if symmetry == "none" and head.isym and holds_symmetry(azimuths, values, declared):
        symmetry = declared
    distribution = IntensityDistribution(
        np.deg2rad(azimuths), np.deg2rad(planes.polars), values * scale
    )
    return distribution, symmetry


def _compare_flux(head: _Head, distribution, lamp_flux, remarks) -> None:
    """Remark where the intensities and the fractions of the head do not fit."""
    total = flux(distribution)
    ratio = total / lamp_flux
    stated = head.light_output_ratio
    if stated is not None and abs(ratio - stated / 100.0) > TOLERANCE * stated / 100.0:
        text = (
            f"the intensities give {total:.4g} lm, {100 * ratio:.1f} % of the lamps' {lamp_flux:g} lm,"
            f" but LORL says {stated:g} %; the intensities count"
        )
        remarks.append(Remark(text, head.lines[22]))
    down = flux(distribution, 0.0, 0.5 * np.pi) / total if total > 0.0 else 0.0
    stated = head.downward_fraction
    if stated is not None and abs(down - stated / 100.0) > TOLERANCE:
        text = (
            f"{100 * down:.1f} % of the flux goes downwards, but DFF says {stated:g} %;"
            " the intensities count"
        )
        remarks.append(Remark(text, head.lines[21]))


def _fraction(percentage) -> float | None:
    return None if percentage is None else percentage / 100.0


def _housing(head: _Head) -> tuple[float, float, float] | None:
    length, width, height = (side / 1000.0 for side in head.housing)
    if not any(head.housing):
        return None
    return (length, 0.0, height) if width == 0.0 else (width, length, height)


def _opening(head: _Head, remarks) -> Opening:
    """The luminous area as a body around the photometric centre."""
    length, width = (side / 1000.0 for side in head.area)
    height = float(np.mean(head.heights)) / 1000.0
    if np.ptp(head.heights) > NEAR:
        text = (
            "heights of the luminous area "
            + ", ".join(f"{side:g}" for side in head.heights)
            + f" mm at C0, C90, C180, C270; a mean of {1000 * height:g} mm is taken all around"
        )
        remarks.append(Remark(text, head.lines[17]))
    if length == 0.0:
        text = "the size of the luminous area is not stated, taken as a point"
        if width or height:
            text = f"a luminous area of {head.area[1]:g} mm x {1000 * height:g} mm without a length, taken as a point"
        remarks.append(Remark(text, head.lines[15]))
        return Opening()
    if width == 0.0:
        return Opening("cylinder" if height else "ellipse", (length, length, height), "z")
    return Opening("box" if height else "rectangle", (width, length, height), "z")
