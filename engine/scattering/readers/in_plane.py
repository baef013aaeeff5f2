"""Tables of scattering from measurements in the plane of incidence alone."""

import numpy as np

from ...errors import SceneError
from ...reading.remarks import Remark
from ...scene.scattering import ScatterTable
from ..data.direction_samples import SAME, merge_angles
from ..data.table import MOST_VALUES, place_on

SHADOW = np.radians(12.0)
"""Zeros so near to the direction of the light are its detector's shadow."""

NEAR = np.radians(6.0)
"""Directions so near to the mirror direction tell on which side it is."""

CLEARLY = 1.5
"""Ratio by which the other side must be brighter before signs are turned."""

MOST_RADIALS = 2000
"""Radial angles of a table; closer ones are merged."""


def make_plane_table(rotations, incidences, slices, remarks: list[Remark]) -> ScatterTable:
    """Make a table in whose azimuths values go evenly from one half of the plane to the other.

    Where the half towards the horizon has no data, as it ends early at oblique incidence, the lobe is taken as round about
    the mirror direction.

    Parameters
    ----------
    rotations : (p,) array    [rad]
    incidences : (s,) array    [rad]
    slices : list of goniometer.Measured
        One for each rotation and incidence, the incidences of each rotation together; nothing is missing in their rows.
    remarks : list of Remark    To which is added.
    """
    lines = [_line(piece) for piece in slices]
    if not slices[0].is_specular and _is_turned(slices):
        lines = [_line(piece, is_turned=True) for piece in slices]
        remarks.append(Remark("has its mirror direction at negative angles; signs were turned"))
    angles = np.concatenate([np.zeros(1), *(np.abs(axis) for axis, _ in lines)])
    radials = merge_angles(angles)[0]
    if len(radials) > MOST_RADIALS:
        radials = np.linspace(0.0, radials[-1], MOST_RADIALS)
    if len(lines) * len(radials) * 2 * len(slices[0].wavelengths) > MOST_VALUES:
        raise SceneError(
            f"{len(lines)} angles of incidence, {len(radials)} angles and {len(slices[0].wavelengths)} bands are too much "
            "for a table; leave out some"
        )
    values = np.stack([_read_halves(radials, *line) for line in lines])
    remarks.append(
        Remark(
            "was measured in the plane of incidence alone; beside it values are taken to go evenly from "
            "one half of the plane to the other about the mirror direction"
        )
    )
    return ScatterTable(
        np.asarray(rotations),
        np.asarray(incidences),
        radials,
        np.array([0.0, np.pi]),
        slices[0].wavelengths,
        values.reshape(len(rotations), len(incidences), *values.shape[1:]).astype(np.float32),
    )


def _signed_polar(piece, is_turned: bool) -> np.ndarray:
    """Angles to the normal, positive on the side of the mirror direction. (n,)"""
    if piece.is_specular:
        return piece.incidence + np.where(np.cos(piece.azimuth) > 0.0, 1.0, -1.0) * piece.radial
    sign = np.where(np.cos(piece.azimuth) < 0.0, 1.0, -1.0)
    return (-sign if is_turned else sign) * piece.radial


def _line(piece, is_turned: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Angles from the mirror direction, ascending and positive towards the horizon, and values. (k,), (k, w)"""
    axis, number = merge_angles(_signed_polar(piece, is_turned) - piece.incidence)
    sums = np.zeros((len(axis), piece.values.shape[1]))
    np.add.at(sums, number, piece.values)
    return axis, sums / np.bincount(number)[:, None]


def _is_turned(slices) -> bool:
    """Whether light is mirrored to the side of negative angles."""
    here = there = 0.0
    for piece in slices:
        signed, centre = _signed_polar(piece, False), piece.incidence[0]
        bright = np.nan_to_num(piece.values).mean(axis=1)
        if centre > 2.0 * NEAR:
            here += bright[np.abs(signed - centre) < NEAR].max(initial=0.0)
            there += bright[np.abs(signed + centre) < NEAR].max(initial=0.0)
    return there > CLEARLY * here


def _read_halves(radials, axis, values) -> np.ndarray:
    """Values of both halves at all radial angles: (t, 2, w)."""
    inner, outer = (_interpolate(sign * radials, axis, values) for sign in (-1.0, 1.0))
    if axis[0] > -SAME:
        inner = outer
    known = radials <= max(axis[-1], 0.0) + SAME
    return np.stack([np.where(known[:, None], outer, inner), inner], axis=1)


def _interpolate(wanted, axis, values) -> np.ndarray:
    below, share = place_on(axis, wanted)
    above = np.minimum(below + 1, len(axis) - 1)
    return values[below] * (1.0 - share)[:, None] + values[above] * share[:, None]
