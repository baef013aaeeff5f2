"""Measurements of goniometers as text: Lumenray's own layout, tables of one plane, and texts like those of ASTM E1392.

Lumenray's layout (all of it in ``docs/goniometer_format.md``)::

    # lumenray goniometer 1
    # quantity: brdf                    brdf | luminance factor | percent | cosine-corrected brdf
    # kind: reflection                  reflection | transmission
    # angles: normal                    normal | specular
    theta_i phi_i theta_o phi_o 450 550 650
    30 0 0 180 0.318 0.318 0.318

Angles are in degrees. About the normal, ``phi_i`` and ``phi_o`` are azimuths from the sample's +x of where light comes from
and goes to. About the mirror direction (``specular``) the columns are ``sigma psi theta phi``, as of
`scene.scattering.ScatterTable`. Rows stand in any order.

Tables of one plane have a column with the angle of incidence and one with the angle at which is measured, which has a sign.
Texts like those of E1392 have ``VARS theta_i,phi_i,theta_s,phi_s,...`` and ``NUM_POINTS``.
"""

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from ...errors import FileFormatError
from ...reading.columns import Columns
from ...reading.remarks import Remark
from ...scene.scattering import ScatterTable
from ..data.direction_samples import (
    MOST_POINTS,
    SAME,
    PolarGrid,
    ScatteredSamples,
    fold_azimuth,
    grid_samples,
    merge_angles,
)
from ..data.record import ScatteringFile
from ..data.resampling import resample
from ..data.table import albedo_of
from ..measuring.raw_measurement import is_raw_measurement
from .checks import MOST_LIGHT, shares_of, tell_excess
from .goniometer_rows import (
    Measured,
    clean_rows,
    stated_quantity,
    stated_side,
    take_angles,
    take_values,
)
from .goniometer_text import LAYOUTS, is_goniometer, parse_goniometer
from .in_plane import make_plane_table

__all__ = ["is_goniometer", "read_goniometer"]

SCALES = {"brdf": 1.0, "cosine": 1.0, "factor": 1.0 / np.pi, "percent": 0.01 / np.pi}
"""By which values become a BRDF. [1/sr]"""

WORDS = {"brdf": "a BRDF in 1/sr", "factor": "luminance factors", "percent": "luminance factors in per cent"}  # fmt: skip

MOST_INCIDENCES = 400
"""Directions of incidence."""

MOST_VALUES = 1 << 25
"""Values of a table that is on the grid of its file."""


def read_goniometer(data: bytes, path, tolerance: float = 0.02) -> ScatteringFile:
    """Read a measurement and make a table of it.

    Angles of incidence are those of the file. Directions on a grid about the mirror direction become the table's grid;
    others are resampled.

    Parameters
    ----------
    data : bytes
    path : str or Path    For messages.
    tolerance : float    Wanted error of tables that are resampled, as of `resampling.resample`. [-]

    Raises
    ------
    FileFormatError    It is none of the layouts, or something in it is wrong; names the line.
    """
    if is_raw_measurement(data):
        raise FileFormatError(
            path, "holds the counts of an instrument; process them into a table first"
        )
    layout, columns = parse_goniometer(data, path)
    measured = take_angles(columns, layout)
    take_values(columns, measured)
    quantity = stated_quantity(columns) or ("brdf" if layout == LAYOUTS[2] else None)
    side = stated_side(columns)
    clean_rows(columns, measured, quantity, side)
    table = _make_table(columns, measured, tolerance)
    table = _scale(columns, measured, table, quantity)
    table = _repeat_rotations(columns, table)
    measured.remarks += tell_excess(side, shares_of(table))
    return ScatteringFile(
        Path(path),
        layout,
        {side: table},
        name=columns.head.get("name", columns.head.get("material", Path(path).stem))[:200],
        description=columns.head.get("description", "")[:2000],
        source=columns.head.get("source", columns.head.get("instrument", ""))[:200],
        incidences=table.incidences,
        remarks=tuple(measured.remarks),
    )


# ---- the table ----


def _make_table(columns: Columns, measured: Measured, tolerance: float) -> ScatterTable:
    """The table of all rows, in the file's quantity."""
    rotations, incidences, slices = _cut_slices(columns, measured)
    if measured.is_in_plane:
        for piece in slices:
            whole = np.isfinite(piece.values).all(axis=1)
            if not whole.any():
                told = np.degrees(piece.incidence[0])
                columns.fail(f"has no row with all values for the incidence {told:g}°")
            piece.keep(whole)
        table = make_plane_table(rotations, incidences, slices, measured.remarks)
        if len(table.radials) < 2:
            columns.fail("has a single outgoing direction, expected several")
        return table
    made = [_hold(columns, piece) for piece in slices]
    if measured.is_specular and all(isinstance(each, PolarGrid) for each in made):
        return _on_own_grid(columns, measured, rotations, incidences, made)
    return _resampled(measured, rotations, incidences, made, tolerance)


def _cut_slices(columns: Columns, measured: Measured):
    """Rotations (p,) and incidences (s,) [rad], and the rows of each pair, those of a rotation together."""
    incidences, incidence = merge_angles(measured.incidence)
    tilted = measured.incidence > SAME
    rotations, rotation = merge_angles(measured.rotation)
    used = np.unique(rotation[tilted]) if tilted.any() else rotation[:1]
    count = len(incidences) * len(used)
    if count > MOST_INCIDENCES:
        columns.fail(f"has {count} directions of incidence, expected at most {MOST_INCIDENCES}")
    slices = []
    for p, (s, angle) in product(used, enumerate(incidences)):
        rows = incidence == s
        if angle > SAME:
            rows &= rotation == p
        if not rows.any():
            told = np.degrees([angle, rotations[p]])
            columns.fail(f"lacks the incidence {told[0]:g}° at the rotation {told[1]:g}°")
        piece = replace(measured)
        piece.keep(rows)
        if angle <= SAME and len(used) > 1:
            # Light along the normal has no azimuth: the same data, counted from every rotation.
            turn = piece.rotation - rotations[p]
            piece.azimuth = piece.azimuth + (-turn if measured.is_specular else turn)
        slices.append(piece)
    return (rotations[used] if len(used) > 1 else np.zeros(1)), incidences, slices


def _hold(columns: Columns, piece: Measured) -> PolarGrid | ScatteredSamples:
    """What was measured for one direction of incidence, made continuous."""
    for band in range(piece.values.shape[1]):
        if not np.isfinite(piece.values[:, band]).any():
            columns.fail(
                f"has no value at {piece.wavelengths[band]:g} nm for the incidence "
                f"{np.degrees(piece.incidence[0]):g}°"
            )
    made = grid_samples(piece.radial, piece.azimuth, piece.values)
    if made is not None:
        return made
    # Every band has its own holes only on a grid.
    piece.keep(np.isfinite(piece.values).all(axis=1))
    count = len(piece.values)
    if not 3 <= count <= MOST_POINTS:
        columns.fail(
            f"has {count} directions that lie on no grid for the incidence "
            f"{np.degrees(piece.incidence[:1]).sum():g}°, expected 3 to {MOST_POINTS}"
        )
    directions, values = piece.direction(), piece.values
    if fold_azimuth(piece.azimuth)[1]:
        directions = np.concatenate([directions, directions * np.array([1.0, -1.0, 1.0])])
        values = np.concatenate([values, values])
    return ScatteredSamples(directions, values)


def _on_own_grid(columns, measured, rotations, incidences, made) -> ScatterTable:
    """The table on all radial angles and azimuths that occur: exact."""
    is_symmetric = all(each.is_symmetric for each in made)
    radials = merge_angles(np.concatenate([each.radials for each in made]))[0]
    azimuths = np.concatenate([each.azimuths for each in made])
    if not is_symmetric:
        mirrored = [2.0 * np.pi - each.azimuths for each in made if each.is_symmetric]
        azimuths = np.concatenate([azimuths, *mirrored])
    azimuths = merge_angles(azimuths)[0]
    azimuths[[0, -1]] = 0.0, np.pi if is_symmetric else 2.0 * np.pi
    size = len(made) * len(radials) * len(azimuths) * len(measured.wavelengths)
    if size > MOST_VALUES:
        columns.fail(f"needs a table of {size} values, expected at most {MOST_VALUES}")
    radial, azimuth = (m.ravel() for m in np.meshgrid(radials, azimuths, indexing="ij"))
    # The last azimuth is a whole turn, which is the first again.
    values = np.stack([each.read(radial, azimuth) for each in made])
    shape = len(rotations), len(incidences), len(radials), len(azimuths), -1
    return ScatterTable(
        rotations,
        incidences,
        np.append(0.0, radials[1:]),
        azimuths,
        measured.wavelengths,
        values.reshape(shape).astype(np.float32),
    )


def _resampled(measured, rotations, incidences, made, tolerance) -> ScatterTable:
    """The table of directions about the normal, or of those on no grid."""

    def evaluate(wi, wo):
        turn = np.arctan2(wi[:, 1], wi[:, 0])
        s = np.abs(np.arccos(np.clip(wi[:, 2], -1.0, 1.0))[:, None] - incidences).argmin(axis=1)
        apart = (turn[:, None] - rotations + np.pi) % (2.0 * np.pi) - np.pi
        p = np.abs(apart).argmin(axis=1)
        # Light along the normal has the azimuth of the rotation that is asked for, as far as rounding tells it.
        azimuth = np.arctan2(wo[:, 1], wo[:, 0]) - np.where(
            incidences[s] > SAME, turn, rotations[p]
        )
        sine = np.hypot(wo[:, 0], wo[:, 1])
        found = np.zeros((len(wi), len(measured.wavelengths)))
        for number in np.unique(p * len(incidences) + s):
            rows = p * len(incidences) + s == number
            source = made[number]
            if isinstance(source, PolarGrid) and not measured.is_specular:
                polar = np.arctan2(sine[rows], wo[rows, 2])
                found[rows] = source.read(polar, azimuth[rows])
                continue
            flat = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), wo[:, 2]], axis=1)
            found[rows] = _read_anywhere(source, flat[rows], incidences[s[rows][0]])
        return found

    return resample(
        evaluate,
        measured.wavelengths,
        incidences=incidences,
        rotations=tuple(rotations),
        is_symmetric=fold_azimuth(measured.azimuth)[1],
        tolerance=tolerance,
    )


def _read_anywhere(source, wo, incidence: float) -> np.ndarray:
    """Values in directions, light coming over +x, of samples that may be about the mirror direction."""
    if isinstance(source, ScatteredSamples):
        return source.read(wo)
    sin_s, cos_s = np.sin(incidence), np.cos(incidence)
    outward = -cos_s * wo[:, 0] - sin_s * wo[:, 2]
    radial = np.arctan2(np.hypot(outward, wo[:, 1]), cos_s * wo[:, 2] - sin_s * wo[:, 0])
    return source.read(radial, np.arctan2(wo[:, 1], outward))


def _scale(columns, measured, table: ScatterTable, quantity: str | None) -> ScatterTable:
    """Values as a BRDF; where the file does not say what they are, by their sum."""
    if quantity is None:
        share = float(np.median([albedo_of(table, s).mean() for s in table.incidences]))
        quantity = next((q for q in ("brdf", "factor", "percent") if share * SCALES[q] <= MOST_LIGHT), None)  # fmt: skip
        if quantity is None:
            columns.fail(
                f"has values that sum up to {share:.3g} times the light; state '# quantity: ...'"
            )
        measured.remarks.append(
            Remark(f"does not say what its values are; by their sum taken as {WORDS[quantity]}")
        )
    values = table.values * np.float32(SCALES[quantity])
    return replace(table, values=values)


def _repeat_rotations(columns: Columns, table: ScatterTable) -> ScatterTable:
    """Rotations of samples that look the same after a part of a turn."""
    period = columns.number("rotation period", 360.0, 1.0, 360.0)
    times = round(360.0 / period)
    if len(table.rotations) == 1 or times == 1:
        return table
    if abs(times * period - 360.0) > 1e-3 or np.degrees(np.ptp(table.rotations)) > period - 1e-3:
        columns.fail(
            f"states the rotation period {period:g}°, which does not fit into a turn or its data"
        )
    turns = [table.rotations + k * 2.0 * np.pi / times for k in range(times)]
    if turns[-1][-1] >= 2.0 * np.pi:
        columns.fail("has rotations beyond the first rotation period; count them from 0")
    values = np.concatenate([table.values] * times)
    return replace(table, rotations=np.concatenate(turns), values=values)
