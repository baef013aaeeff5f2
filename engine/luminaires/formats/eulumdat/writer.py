"""Luminaires as EULUMDAT files."""

from dataclasses import dataclass, replace

import numpy as np

from ....errors import LumenrayError
from ....reading.remarks import Remark
from ....reading.text import parse_number
from ....scene.distribution import IntensityDistribution
from ...coordinates import directions
from ...direct_ratios import direct_ratios
from ...distribution import flux, intensity, is_closed
from ..record import RADIANT, LampSet, LuminaireFile
from ..symmetry import expand_planes
from .head import (
    DATE,
    FILE,
    MANUFACTURER,
    MAXIMUM_LAMP_SETS,
    MEASUREMENT_TILT,
    NAME,
    NUMBER,
    REPORT,
)
from .planes import SYMMETRIES, holds_symmetry, planes_at

LONGEST_TEXT = 78
"""Longest line of text. [character]"""

DIGITS = 7
"""Digits of the largest intensity."""

ROTATIONAL_STEP = 15.0
"""Step of the C-planes that are listed for rotational symmetry, as usual. [degree]"""

ELONGATED = 2.5
"""Ratio of the sides from which a luminaire is a linear one."""

THINNEST = 1.0
"""Width of a luminous area that has none: 0 would mean round. [mm]"""

_STEPS = (0.5, 1.0, 2.5, 5.0)
"""Steps of the polar angles onto which other coordinate systems are brought. [degree]"""

_PLANE_STEPS = (1.0, 2.5, 5.0)
"""Steps of the C-planes for the same. [degree]"""

_SAME = 1e-6
"""Angles nearer than this are one. [degree]"""


@dataclass(frozen=True, eq=False)
class _Table:
    """All listed planes [degree], those stored, polar angles [degree], and intensities (stored, polar). [cd]"""

    isym: int
    planes: np.ndarray
    polars: np.ndarray
    values: np.ndarray


def write_eulumdat(file: LuminaireFile) -> tuple[bytes, list[Remark]]:
    """Return a luminaire as the content of a EULUMDAT file, and what could not be kept.

    Intensities that refer to a rated flux of lamps are written per 1000 lm of it. Absolute ones get -1 lamps with the flux
    of the luminaire. Light output ratio, downward flux fraction and direct ratios (see `direct_ratios`) are computed.

    Raises
    ------
    LumenrayError    The luminaire emits nothing, or its file holds radiant intensities.
    """
    if file.quantity == RADIANT:
        raise LumenrayError(
            "radiant intensities (W/sr) have no place in EULUMDAT, which holds candelas; write an .ies file"
        )
    remarks: list[Remark] = []
    distribution = _with_vertical_axis(file.distribution, remarks)
    total = flux(distribution)
    if total <= 0.0:
        raise LumenrayError("a luminaire that emits nothing cannot be written as EULUMDAT")
    table = _table(distribution)
    relative = not file.is_absolute and file.stated_flux is not None
    lamp_flux = file.stated_flux if relative else total
    lamps = _lamps(file, lamp_flux, relative, remarks)
    length, width, heights = _area(file, remarks)
    housing = _housing(file, length, width)
    down = flux(distribution, 0.0, 0.5 * np.pi)
    if file.tilt is not None:
        remarks.append(
            Remark("the factors for the tilt of the luminaire have no place in EULUMDAT")
        )
    if file.spectrum is not None:
        remarks.append(Remark("the spectrum has no place in EULUMDAT"))
    metadata = file.metadata
    lines = [
        metadata.get(MANUFACTURER, ""),
        _ityp(table.isym, max(length, housing[0]), max(width, housing[1])),
        table.isym,
        len(table.planes),
        _step(np.append(table.planes, 360.0)),
        len(table.polars),
        _step(table.polars),
        metadata.get(REPORT, ""),
        metadata.get(NAME, ""),
        metadata.get(NUMBER, ""),
        metadata.get(FILE, ""),
        metadata.get(DATE, ""),
        *housing,
        length,
        width,
        *heights,
        round(100.0 * down / total, 2),
        round(100.0 * total / lamp_flux, 2),
        1,
        parse_number(metadata.get(MEASUREMENT_TILT, "0")) or 0.0,
        len(lamps) // 6,
        *lamps,
        *np.round(direct_ratios(distribution), 3),
        *table.planes,
        *table.polars,
    ]
    texts = [_text(line, remarks) if isinstance(line, str) else _number(line) for line in lines]
    texts += _intensities(table.values * (1000.0 / lamp_flux))
    return "".join(f"{text}\r\n" for text in texts).encode("latin-1"), remarks


def _number(value) -> str:
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _text(text: str, remarks) -> str:
    """One line of Latin-1 of the allowed length."""
    line = " ".join(text.split())
    encoded = line.encode("latin-1", errors="replace").decode("latin-1")
    if encoded != line:
        remarks.append(Remark(f"characters that Latin-1 lacks are replaced in '{encoded}'"))
    if len(encoded) > LONGEST_TEXT:
        remarks.append(Remark(f"the text '{encoded[:20]}...' is cut to {LONGEST_TEXT} characters"))
    return encoded[:LONGEST_TEXT]


def _intensities(values) -> list[str]:
    """Intensities without exponents, with so many decimals that the largest has `DIGITS` digits."""
    decimals = max(0, DIGITS - 1 - int(np.floor(np.log10(values.max()))))
    return [f"{value:.{decimals}f}" for value in values.ravel()]


def _step(angles) -> float:
    """The step of even angles, 0 of others. [degree]"""
    steps = np.diff(angles)
    return float(steps[0]) if np.ptp(steps) < _SAME else 0.0


def _table(distribution: IntensityDistribution) -> _Table:
    """The planes to be listed and stored, of a distribution whose frame is the luminaire's."""
    azimuths, values = np.rad2deg(distribution.azimuth), distribution.intensity
    polars = np.rad2deg(distribution.polar)
    isym = next((i for i in (1, 4, 2, 3) if holds_symmetry(azimuths, values, SYMMETRIES[i])), 0)
    if isym == 1:
        return _Table(1, np.arange(0.0, 360.0, ROTATIONAL_STEP), polars, values[:1])
    # The number of stored planes follows from that of all, so mirrors must have as many planes on both sides; for Isym 3
    # the format counts as if all four quadrants had as many.
    images = {
        0: (azimuths,),
        2: (azimuths, -azimuths, (0.0, 180.0)),
        3: (azimuths, -azimuths, 180.0 - azimuths, 180.0 + azimuths, (0.0, 90.0, 180.0, 270.0)),
        4: (azimuths, -azimuths, 180.0 - azimuths, 180.0 + azimuths, (0.0, 90.0, 180.0, 270.0)),
    }[isym]
    planes = _distinct(np.concatenate(images))
    match isym:
        case 4:
            stored = planes[planes < 90.0 + _SAME]
        case 3:
            stored = np.concatenate([planes[planes > 270.0 - _SAME], planes[planes < 90.0 + _SAME]])
        case 2:
            stored = planes[planes < 180.0 + _SAME]
        case _:
            stored = planes
    return _Table(isym, planes, polars, planes_at(azimuths, values, stored))


def _distinct(angles) -> np.ndarray:
    """Angles within a turn, ascending, each once. [degree]"""
    angles = np.mod(angles, 360.0)
    angles[angles > 360.0 - _SAME] = 0.0
    angles = np.sort(angles)
    return angles[np.concatenate([[True], np.diff(angles) > _SAME])]


def _with_vertical_axis(distribution: IntensityDistribution, remarks) -> IntensityDistribution:
    """The distribution on C-planes of the whole turn, in the luminaire's own frame."""
    frame = distribution.frame
    if frame[2, 2] < 1.0 - 1e-9 or not is_closed(distribution):
        return _resampled(distribution, remarks)
    if len(distribution.azimuth) == 1:
        return replace(distribution, frame=np.eye(3))
    # Turned about the vertical or mirrored, the planes lie elsewhere but are the same.
    turn = np.arctan2(frame[1, 0], frame[0, 0])
    moved = turn + np.sign(np.linalg.det(frame)) * distribution.azimuth[:-1]
    azimuth, values = expand_planes(np.rad2deg(moved), distribution.intensity[:-1], "none")
    return IntensityDistribution(np.deg2rad(azimuth), distribution.polar, values)


def _resampled(distribution: IntensityDistribution, remarks) -> IntensityDistribution:
    """The distribution on an even grid about the vertical, as fine as its own."""
    finest = np.rad2deg(min(np.diff(distribution.polar).min(), np.diff(distribution.azimuth).min()))
    step = max((s for s in _STEPS if s <= finest + _SAME), default=_STEPS[0])
    plane_step = max((s for s in _PLANE_STEPS if s <= finest + _SAME), default=_PLANE_STEPS[0])
    azimuth = np.deg2rad(np.linspace(0.0, 360.0, round(360.0 / plane_step) + 1))
    polar = np.deg2rad(np.linspace(0.0, 180.0, round(180.0 / step) + 1))
    values = intensity(distribution, directions(azimuth[:, None], polar))
    values[:, [0, -1]] = values[:1, [0, -1]]
    values[-1] = values[0]
    even = IntensityDistribution(azimuth, polar, values)
    grid = directions(distribution.azimuth[:, None], distribution.polar, distribution.frame)
    worst = (
        np.abs(intensity(even, grid) - distribution.intensity).max() / distribution.intensity.max()
    )
    remarks.append(
        Remark(
            f"brought onto C-planes every {plane_step:g} and polar angles every {step:g} degrees about the"
            f" vertical; intensities differ by up to {100.0 * worst:.2g} % of the peak"
        )
    )
    return even


def _ityp(isym: int, length: float, width: float) -> int:
    """1 symmetric about the vertical, 2 linear, 3 anything else."""
    if isym == 1:
        return 1
    shorter, longer = sorted((length, width))
    return 2 if shorter > 0.0 and longer > ELONGATED * shorter else 3


def _lamps(file: LuminaireFile, lamp_flux: float, relative: bool, remarks) -> list:
    """Six lines for each lamp set."""
    sets = list(file.lamps[:MAXIMUM_LAMP_SETS]) or [LampSet()]
    if len(file.lamps) > len(sets):
        text = f"{len(file.lamps)} lamp sets, of which EULUMDAT takes {MAXIMUM_LAMP_SETS}"
        remarks.append(Remark(text))
    lines: list = []
    for place, lamp in enumerate(sets):
        watts = lamp.watts if lamp.watts is not None or place else file.watts
        colour = lamp.colour
        if not colour and lamp.colour_temperature is not None:
            colour = f"{lamp.colour_temperature:g} K"
        lines += [
            max(lamp.count, 1) if relative else -1,
            lamp.name,
            lamp_flux if place == 0 else lamp.luminous_flux or 0.0,
            colour,
            lamp.colour_rendering,
            watts or 0.0,
        ]
    return lines


def _area(file: LuminaireFile, remarks) -> tuple[float, float, tuple[float, ...]]:
    """Length (along y), width (along x, 0 if round) and heights of the luminous area. [mm]"""
    opening = file.opening
    x, y, z = (1000.0 * side for side in opening.size)
    heights = (z,) * 4
    if opening.shape == "point":
        return 0.0, 0.0, (0.0,) * 4
    is_round = opening.shape in {"ellipse", "cylinder", "ellipsoid"} and opening.axis == "z"
    if is_round and abs(x - y) < 1e-6 * x:
        if opening.shape == "ellipsoid":
            remarks.append(Remark("a round luminous body is written as a cylinder of its size"))
        return y, 0.0, heights
    if opening.shape not in {"rectangle", "box"}:
        remarks.append(Remark(f"a luminous {opening.shape} is written as a box of its size"))
    if min(x, y) < THINNEST:
        text = f"a luminous area thinner than {THINNEST:g} mm is written with {THINNEST:g} mm, as 0 means round"
        remarks.append(Remark(text))
    return max(y, THINNEST), max(x, THINNEST), heights


def _housing(file: LuminaireFile, length: float, width: float) -> tuple[float, float, float]:
    """Length (along y), width (along x, 0 if round) and height of the body; that of the luminous area if unknown. [mm]"""
    if file.housing is None:
        return length, width, 0.0
    x, y, z = (1000.0 * side for side in file.housing)
    return (x, 0.0, z) if y == 0.0 else (y, x, z)
