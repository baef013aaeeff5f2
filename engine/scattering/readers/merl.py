"""Measured reflection of MERL's database (.binary): three colours on a grid of half and difference angles.

Cells are even in the difference angles and finer towards the mirror direction in the half angle. Isotropic and reciprocal.

References
----------
Matusik et al., A data-driven reflectance model, doi:10.1145/882262.882343
Rusinkiewicz, A new change of variables for efficient BRDF representation, doi:10.1007/978-3-7091-6453-2_2
"""

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import FileFormatError
from ...reading.remarks import Remark
from ..data.record import ScatteringFile
from ..data.resampling import resample
from .colour import spectra_of_rgb

SHAPE = 90, 90, 180
"""Cells in theta of the half vector, theta of the difference, and phi of the difference."""

HEAD = 12

SIZE = HEAD + 3 * 8 * SHAPE[0] * SHAPE[1] * SHAPE[2]
"""Of a file. [byte]"""

SCALES = 1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0
"""By which stored red, green and blue become a BRDF. [1/sr]"""

LARGEST = 1e6
"""Value that no material reaches. [1/sr]"""


def is_merl(data: bytes) -> bool:
    """Whether the file begins with the grid of these files, or has their size."""
    if len(data) < HEAD:
        return False
    return struct.unpack_from("<3i", data) == SHAPE or len(data) == SIZE


def read_merl(data: bytes, path, tolerance: float = 0.02) -> ScatteringFile:
    """Read a file and make a table of it.

    Parameters
    ----------
    data : bytes
    path : str or Path    For messages.
    tolerance : float    Wanted error of the table, as of `resampling.resample`. [-]

    Raises
    ------
    FileFormatError    Its grid or size is another, or it has values that cannot be.
    """
    material = parse_merl(data, path)
    wavelengths = spectra_of_rgb(np.zeros((1, 3)))[0]
    table = resample(
        lambda wi, wo: spectra_of_rgb(material.evaluate(wi, wo))[1],
        wavelengths,
        tolerance=tolerance,
        hints=np.radians([0.25, 0.5, 1.5, 3.0]),
    )
    remarks = [Remark("holds colours of unknown primaries, taken as linear Rec. 709")]
    if material.missing > 0.0:
        remarks.append(
            Remark(
                f"has no data in {100.0 * material.missing:.2g} % of the cells above the horizon; "
                "the nearest cell with data stands for them"
            )
        )
    return ScatteringFile(
        Path(path),
        "MERL",
        {"front_reflection": table},
        name=Path(path).stem,
        incidences=table.incidences,
        remarks=tuple(remarks),
    )


@dataclass(frozen=True, eq=False)
class MerlMaterial:
    """What a file holds.

    Parameters
    ----------
    values : (90, 90, 180, 3) float32 array    Red, green, blue in the cells; every cell has a value. [1/sr]
    missing : float    Share of the cells above the horizon for which the file has none. [-]
    """

    values: np.ndarray
    missing: float

    def evaluate(self, wi, wo) -> np.ndarray:
        """Red, green and blue for pairs of directions, linear between middles of cells. (n, 3), (n, 3) -> (n, 3) [1/sr]"""
        half, difference, turn = half_angles(np.asarray(wi, float), np.asarray(wo, float))
        places = (
            SHAPE[0] * np.sqrt(half / (0.5 * np.pi)) - 0.5,
            SHAPE[1] * difference / (0.5 * np.pi) - 0.5,
            SHAPE[2] * (turn % np.pi) / np.pi - 0.5,
        )
        corners = [(np.zeros((3, 1), dtype=np.int64), 1.0)]
        for axis, place in enumerate(places):
            below = np.floor(place).astype(np.int64)
            share, count = place - below, SHAPE[axis]
            pair = np.stack([below, below + 1])
            # The turn begins again after half of it; the ends of the others hold.
            pair = pair % count if axis == 2 else np.clip(pair, 0, count - 1)
            step = np.zeros((3, 1), dtype=np.int64)
            step[axis] = 1
            corners = [
                (number + step * cell, weight * part)
                for number, weight in corners
                for cell, part in zip(pair, (1.0 - share, share), strict=True)
            ]
        found = np.zeros((len(half), 3))
        for number, weight in corners:
            found += weight[:, None] * self.values[tuple(number)]
        above = (np.asarray(wi)[:, 2] > 0.0) & (np.asarray(wo)[:, 2] > 0.0)
        return np.where(above[:, None], found, 0.0)


def half_angles(wi, wo) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angle of the half vector to the normal, and the incoming direction's angle to it and azimuth about it. (n,) each [rad]

    The azimuth is 0 on the side of the half vector away from the normal.
    """
    half = wi + wo
    half = half / np.linalg.norm(half, axis=1, keepdims=True)
    flat = np.hypot(half[:, 0], half[:, 1])
    is_upright = flat < 1e-12
    safe = np.where(is_upright, 1.0, flat)
    cos_p = np.where(is_upright, 1.0, half[:, 0] / safe)
    sin_p = np.where(is_upright, 0.0, half[:, 1] / safe)
    # The frame of the half vector: its y lies level, its x points down.
    along = cos_p * wi[:, 0] + sin_p * wi[:, 1]
    y = cos_p * wi[:, 1] - sin_p * wi[:, 0]
    x = half[:, 2] * along - flat * wi[:, 2]
    z = flat * along + half[:, 2] * wi[:, 2]
    return np.arctan2(flat, half[:, 2]), np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)


def cell_middles() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles in the middle of cells: of the half vector (90,), of the difference (90,) and its azimuth (180,). [rad]"""
    half = 0.5 * np.pi * ((np.arange(SHAPE[0]) + 0.5) / SHAPE[0]) ** 2
    difference = 0.5 * np.pi * (np.arange(SHAPE[1]) + 0.5) / SHAPE[1]
    return half, difference, np.pi * (np.arange(SHAPE[2]) + 0.5) / SHAPE[2]


def directions_of(half, difference, turn) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions by their angles, the half vector over +x; arrays that fit together. (..., 3), (..., 3)"""
    half, difference, turn = np.broadcast_arrays(half, difference, turn)
    x = np.sin(difference) * np.cos(turn)
    y = np.sin(difference) * np.sin(turn)
    z = np.cos(difference)
    cos_h, sin_h = np.cos(half), np.sin(half)
    return tuple(
        np.stack([cos_h * sign * x + sin_h * z, sign * y, cos_h * z - sin_h * sign * x], axis=-1)
        for sign in (1.0, -1.0)
    )


def parse_merl(data: bytes, path) -> MerlMaterial:
    """Read the cells, and fill those for which there are no data.

    Raises
    ------
    FileFormatError    As `read_merl`.
    """
    if len(data) < HEAD:
        raise FileFormatError(path, f"has {len(data)} bytes, expected {SIZE} of a MERL file")
    found = struct.unpack_from("<3i", data)
    if found != SHAPE:
        wanted, got = (" x ".join(map(str, shape)) for shape in (SHAPE, found))
        raise FileFormatError(path, f"has a grid of {got} cells, expected {wanted}")
    if len(data) != SIZE:
        word = "is cut short" if len(data) < SIZE else "is too long"
        raise FileFormatError(path, f"{word}: it has {len(data)} bytes, expected {SIZE}")
    planes = np.frombuffer(data, "<f8", offset=HEAD).reshape(3, *SHAPE)
    # A comparison with what is no number is false, so it counts as no data.
    valid = ((planes >= 0.0) & (planes < LARGEST / SCALES[2])).all(axis=0)
    if not valid.any():
        raise FileFormatError(path, "has no data: every value is negative or no number")
    wi, wo = directions_of(*np.meshgrid(*cell_middles(), indexing="ij", sparse=True))
    above = (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
    missing = np.count_nonzero(above & ~valid) / np.count_nonzero(above)
    values = np.empty((*SHAPE, 3), dtype=np.float32)
    for band, scale in enumerate(SCALES):
        values[..., band] = np.where(valid, planes[band], 0.0) * scale
    # The turn about the half vector keeps the facets and their Fresnel reflectance, so it comes first.
    for axis, is_periodic in ((2, True), (1, False), (0, False)):
        values, valid = fill_nearest(values, valid, axis, is_periodic)
    # Both sides of the plane of incidence are alike, but for noise.
    return MerlMaterial(0.5 * (values + values[:, :, ::-1]), missing)


def fill_nearest(values, valid, axis: int, is_periodic: bool = False):
    """Fill cells from the nearest with data along an axis.

    Parameters
    ----------
    values : (..., b) array
    valid : (...) bool array    Which cells have data.
    axis : int    Of ``valid``.
    is_periodic : bool    Whether the first follows the last.

    Returns
    -------
    (..., b) array, (...) bool array    Cells of lines without any data stay as they are.
    """
    count = valid.shape[axis]
    line = np.moveaxis(valid, axis, -1)
    rounds = np.concatenate([line] * 3, axis=-1) if is_periodic else line
    number = np.arange(rounds.shape[-1])
    far = 4 * len(number)
    before = np.maximum.accumulate(np.where(rounds, number, -far), axis=-1)
    after = np.minimum.accumulate(np.where(rounds, number, far)[..., ::-1], axis=-1)[..., ::-1]
    nearest = np.where(number - before <= after - number, before, after)
    nearest = nearest[..., count : 2 * count] if is_periodic else nearest
    found = line.any(axis=-1, keepdims=True)
    source = np.where(found, nearest % count, np.arange(count))
    moved = np.moveaxis(values, axis, -2)
    filled = np.take_along_axis(moved, source[..., None], axis=-2)
    return np.moveaxis(filled, -2, axis), np.moveaxis(np.broadcast_to(found, line.shape), -1, axis)
