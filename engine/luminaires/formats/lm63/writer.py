"""Luminaires written as IES LM-63-2002, which most programs read.

What LM-63 has no place for is left out: spectrum, housing, all lamp sets but the first.
"""

import textwrap
import unicodedata
from dataclasses import replace

import numpy as np

from ....errors import LumenrayError
from ...coordinates import FRAMES
from ...distribution import is_closed
from ..radiant import UNIT_KEY, WRITTEN, radiant_unit
from ..record import RADIANT, LuminaireFile
from ..symmetry import expand_planes
from .header import GENERATION_TYPE, KEYWORDS, LABEL, REQUIRED
from .opening import signed_size

LINE = 130
"""Longest line, without its end."""

EDGE = 1e-3
"""Width over which the intensity falls to 0 where the distribution ends between the angles of the standard. [degree]"""

_TYPES = {"C": 1, "B": 2, "A": 3}

_NEAR = 1e-6


def write_lm63(file: LuminaireFile) -> bytes:
    """Return the content of an LM-63-2002 file; intensities keep nine digits, all factors are 1.

    Radiant ones are in the unit that the file's own text tells, or in mW/sr with a keyword that tells so.

    Parameters
    ----------
    file : LuminaireFile    Its distribution may be turned about the vertical or mirrored.

    Raises
    ------
    LumenrayError    The distribution is turned in a way that none of the three photometric types knows.
    """
    kind, vertical, horizontal, candela = _grid(file)
    lamp = file.lamps[0] if file.lamps else None
    count = max(lamp.count, 1) if lamp else 1
    is_relative = file.stated_flux is not None and not file.is_absolute
    lumens = file.stated_flux / count if is_relative else -1.0
    if file.quantity == RADIANT:
        file, size = _with_unit(file)
        candela, lumens = candela / size, lumens / size if is_relative else lumens
    lines = ["IESNA:LM-63-2002", *_keyword_lines(file), *_tilt_lines(file.tilt)]
    sizes = signed_size(file.opening, kind)
    counts = len(vertical), len(horizontal)
    lines += _number_lines([count, lumens, 1, *counts, _TYPES[kind], 2, *sizes])
    lines += _number_lines([1, 1, file.watts or 0])
    for row in (vertical, horizontal, *candela):
        lines += _number_lines(row)
    return "".join(f"{line}\r\n" for line in lines).encode("ascii")


def _with_unit(file: LuminaireFile) -> tuple[LuminaireFile, float]:
    """A radiant file whose text tells a unit, and that unit. [W/sr]"""
    unit = radiant_unit(file.metadata)
    if unit is None:
        file = replace(file, metadata={**file.metadata, UNIT_KEY: WRITTEN})
        unit = radiant_unit(file.metadata)
    return file, unit[1]


def _keyword_lines(file: LuminaireFile) -> list[str]:
    """Lines of the keywords: required ones first if they are missing, others in order."""
    present = {key.upper() for key in file.metadata}
    lines = [f"[{key}] not stated" for key in REQUIRED if key not in present]
    for key, text in file.metadata.items():
        name = _keyword(key, file.format.startswith("LM-63"))
        for part in text.split("\n"):
            lines += _wrapped(name, _ascii(part))
            name = "MORE"
    return lines


def _keyword(key: str, is_keyword: bool) -> str:
    """LM-63's word for a key of the metadata."""
    if key in {LABEL, GENERATION_TYPE}:
        return "FILEGENINFO" if key == GENERATION_TYPE else "OTHER"
    name = _ascii(key).replace("[", "(").replace("]", ")").strip()
    if not is_keyword:
        name = name.upper()
        name = name if name in KEYWORDS else "_" + name.lstrip("_").replace(" ", "_")
    return name[: LINE // 2]


def _ascii(text: str) -> str:
    """Text without accents, signs of other alphabets and control characters."""
    for sign, words in (("°", " deg"), ("ß", "ss"), ("µ", "u"), ("μ", "u")):
        text = text.replace(sign, words)
    plain = unicodedata.normalize("NFKD", text)
    plain = plain.encode("ascii", "ignore").decode("ascii")
    return "".join(sign if sign.isprintable() else " " for sign in plain)


def _wrapped(name: str, text: str) -> list[str]:
    line = f"[{name}] {text}".rstrip()
    if len(line) <= LINE:
        return [line]
    parts = textwrap.wrap(text, LINE - max(len(name), 4) - 3)
    return [f"[{'MORE' if n else name}] {part}" for n, part in enumerate(parts)]


def _tilt_lines(tilt) -> list[str]:
    if tilt is None:
        return ["TILT=NONE"]
    lines = ["TILT=INCLUDE", str(tilt.geometry), str(len(tilt.angles))]
    return lines + _number_lines(tilt.angles) + _number_lines(tilt.factors)


def _number_lines(values) -> list[str]:
    """Numbers with blanks between, in lines that are not too long."""
    lines, parts, length = [], [], 0
    for value in values:
        token = f"{value:.9g}"
        if length + len(token) > LINE:
            lines.append(" ".join(parts))
            parts, length = [], 0
        parts.append(token)
        length += len(token) + 1
    return [*lines, " ".join(parts)]


def _grid(file: LuminaireFile):
    """Type, vertical and horizontal angles [degree], and candelas (horizontal, vertical), by symmetry as few as will do."""
    distribution = file.distribution
    for kind in sorted(FRAMES, key=lambda other: other != file.photometric_type):
        turn = FRAMES[kind].T @ distribution.frame
        if abs(abs(turn[2, 2]) - 1.0) < _NEAR:
            break
    else:
        raise LumenrayError(
            "the distribution is turned about another axis than the vertical, which LM-63 cannot"
            " say; turn it back before writing"
        )
    sense = np.sign(turn[0, 0] * turn[1, 1] - turn[0, 1] * turn[1, 0])
    offset = np.degrees(np.arctan2(turn[1, 0], turn[0, 0]))
    around = np.round(offset + sense * np.degrees(distribution.azimuth), 9)
    across = np.round(np.degrees(distribution.polar), 9)
    table = distribution.intensity
    if turn[2, 2] < 0.0:
        across, table = 180.0 - across[::-1], table[:, ::-1]
    if sense < 0.0:
        around, table = around[::-1], table[::-1]
    if kind == "C":
        across, table = _standard_polars(across, table)
        return kind, across, *_fewest_planes(*_whole_turn(around, table, is_closed(distribution)))
    around, table = _about_beam(around, table, is_closed(distribution))
    across = across - 90.0
    if kind == "A":
        return kind, *_right_half(across, around, table)
    return kind, *_right_half(around, across, table.T)


def _whole_turn(azimuth, table, is_closed):
    """Planes from 0 to 360; outside of a part of a turn there are planes of darkness."""
    if len(azimuth) == 1:
        return np.array([0.0, 360.0]), np.repeat(table, 2, axis=0)
    if not is_closed:
        dark = np.zeros((1, table.shape[1]))
        azimuth = np.concatenate([[azimuth[0] - EDGE], azimuth, [azimuth[-1] + EDGE]])
        table = np.concatenate([dark, table, dark])
    return expand_planes(azimuth, table, "none")


def _with_planes(azimuth, table, extra):
    """Add interpolated planes where there are none, which leaves the bilinear interpolant as it was."""
    for angle in extra:
        if np.abs(azimuth - angle).min() > _NEAR:
            at = int(np.searchsorted(azimuth, angle))
            share = (angle - azimuth[at - 1]) / (azimuth[at] - azimuth[at - 1])
            row = table[at - 1] * (1.0 - share) + table[at] * share
            azimuth, table = np.insert(azimuth, at, angle), np.insert(table, at, row, axis=0)
    return azimuth, table


def _fewest_planes(azimuth, table):
    """Planes 0, 0..90, 0..180 or 0..360 of a whole turn, the fewest that symmetry allows."""
    tolerance = 1e-9 * table.max()
    if np.all(np.abs(table - table[0]) <= tolerance):
        return azimuth[:1], table[:1]
    halves = _with_planes(azimuth, table, (180.0,))
    if not _is_mirrored(*halves, 360.0, tolerance):
        return azimuth, table
    quarters = _with_planes(*halves, (90.0, 270.0))
    # Of what is already the same about the C0-C180 plane, half a turn tells whether C90-C270 mirrors too.
    half = quarters[0] < 180.0 + _NEAR
    if _is_mirrored(quarters[0][half], quarters[1][half], 180.0, tolerance):
        few, last = quarters, 90.0
    else:
        few, last = halves, 180.0
    kept = few[0] < last + _NEAR
    return few[0][kept], few[1][kept]


def _is_mirrored(angles, table, total, tolerance) -> bool:
    """Whether ascending angles and their rows read backwards the same; an angle and its image have the sum ``total``."""
    return bool(
        np.all(np.abs(angles + angles[::-1] - total) < _NEAR)
        and np.all(np.abs(table - table[::-1]) <= tolerance)
    )


def _standard_polars(polar, table):
    """Angles from 0 or 90 to 90 or 180, with darkness added where the distribution has none."""
    first = 0.0 if polar[0] < 90.0 - _NEAR else 90.0
    last = 180.0 if polar[-1] > 90.0 + _NEAR else 90.0
    below = [a for a in (first, polar[0] - EDGE) if first - _NEAR < a < polar[0] - _NEAR]
    above = [a for a in (polar[-1] + EDGE, last) if polar[-1] + _NEAR < a < last + _NEAR]
    table = np.pad(table, ((0, 0), (len(below), len(above))))
    return np.concatenate([below, polar, above]), table


def _about_beam(azimuth, table, is_closed):
    """Angles within -180 to 180; part of a turn stays as it is, for nothing is emitted outside of what is given."""
    moved = azimuth - 360.0 * np.round((azimuth[0] + azimuth[-1]) / 720.0)
    if not is_closed and moved[0] > -180.0 - _NEAR and moved[-1] < 180.0 + _NEAR:
        return moved, table
    azimuth, table = _with_planes(*_whole_turn(azimuth, table, is_closed), (180.0,))
    behind, before = azimuth > 180.0 - _NEAR, azimuth < 180.0 + _NEAR
    azimuth = np.concatenate([azimuth[behind][:-1] - 360.0, azimuth[before]])
    return azimuth, np.concatenate([table[behind][:-1], table[before]])


def _right_half(vertical, horizontal, candela):
    """Leave out the left half where it mirrors the right one; a range that begins at 0 would be mirrored by readers."""
    if np.any(np.abs(horizontal) < _NEAR) and _is_mirrored(
        horizontal, candela, 0.0, 1e-9 * candela.max()
    ):
        right = horizontal > -_NEAR
        return vertical, horizontal[right], candela[right]
    if abs(horizontal[0]) < _NEAR:
        horizontal = np.concatenate([[-EDGE], horizontal])
        candela = np.pad(candela, ((1, 0), (0, 0)))
    if abs(vertical[0]) < _NEAR:
        vertical = np.concatenate([[-EDGE], vertical])
        candela = np.pad(candela, ((0, 0), (1, 0)))
    return vertical, horizontal, candela
