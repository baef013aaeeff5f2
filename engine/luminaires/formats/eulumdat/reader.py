"""EULUMDAT: the photometric files of Europe (.ldt), one value a line.

Departures from the format are read as what is evidently meant, each with a remark. Nothing that decides about light is
guessed: such files are refused with the line and what was expected.

References
----------
A. W. Stockmar: EULUMDAT, ein Leuchtendatenformat für den europäischen Beleuchtungsplaner, Licht '90 (1990) 641-644.
"""

import numpy as np

from ....errors import FileFormatError
from ....reading.remarks import Remark
from ....reading.text import decode
from ....scene.distribution import IntensityDistribution, Opening
from ...distribution import flux
from ..radiant import settle_unit
from ..record import LuminaireFile
from ..symmetry import POLE_TOLERANCE, average_poles, expand_planes
from .fields import Fields
from .head import Head, read_head
from .lamps import read_lamps
from .planes import MAXIMUM_VALUES, NEAR, Planes, holds_symmetry, read_planes
from .planes import SYMMETRIES as SYMMETRIES_BY_ISYM

MINIMUM_INTENSITY, MAXIMUM_INTENSITY = 1e-12, 1e12
"""The peak lies between; more than a searchlight and less than anything that can be measured are mistakes. [cd]"""

TOLERANCE = 0.05
"""How far the computed light output ratio and downward fraction may be off before it is remarked on."""


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
    FileFormatError    It cannot be read safely: with the line, what was found and what was expected.
    """
    remarks: list[Remark] = []
    rows = _rows(path, data, remarks)
    fields = Fields(path, rows)
    head = read_head(fields)
    lamps, is_absolute = read_lamps(fields, head.lamp_sets, remarks)
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


def _compare_steps(head: Head, planes: Planes, remarks) -> None:
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
    path, head: Head, planes: Planes, lamp_flux, remarks
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


def _compare_flux(head: Head, distribution, lamp_flux, remarks) -> None:
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


def _housing(head: Head) -> tuple[float, float, float] | None:
    length, width, height = (side / 1000.0 for side in head.housing)
    if not any(head.housing):
        return None
    return (length, 0.0, height) if width == 0.0 else (width, length, height)


def _opening(head: Head, remarks) -> Opening:
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
