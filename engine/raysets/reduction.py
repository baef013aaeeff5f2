"""A ray set reduced to what is seen of it from afar and from one direction: its intensity distribution, its luminances.

The luminaire's own axes, which photometric files and lights have, are those of the rays turned by half a turn about x: rays
go along +z by custom, luminaires shine along -z.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..luminaires.coordinates import angles
from ..luminaires.distribution import azimuth_weights, polar_weights
from ..luminaires.formats.record import LuminaireFile
from ..reading.remarks import Remark
from ..scene.distribution import IntensityDistribution, Opening

TO_LUMINAIRE = np.diag([1.0, -1.0, -1.0])
"""From the axes of the rays to those of the luminaire, and back."""

STEPS = (0.25, 0.5, 1.0, 2.5, 5.0)
"""Steps between angles that are chosen from. [degree]"""

ROTATIONAL = 0.02
"""Share of the flux by which the planes of a source that is the same all around may differ, beyond their noise. [-]"""


@dataclass(frozen=True, eq=False)
class Reduced:
    """An intensity distribution made of rays.

    Parameters
    ----------
    distribution : IntensityDistribution    Of the luminaire, in cd, or W/sr for rays in watts without a spectrum.
    standard_error : (a, p) float64 array    Of each value, from the scatter of the rays that made it.
    rays : int
    """

    distribution: IntensityDistribution
    standard_error: np.ndarray
    rays: int


def reduce_rays(
    pieces: Iterable[tuple[np.ndarray, np.ndarray]], polar_step: float = 2.5, planes: int = 24
) -> Reduced:
    """Make the intensity distribution of rays.

    Every ray is shared out among the four nearest directions of the grid, in the proportion in which these make up the
    value at its own direction: so the interpolant has the flux of all rays exactly.

    Parameters
    ----------
    pieces : iterable of ((n, 3), (n,)) arrays    Directions, unit vectors, and flux.
    polar_step : float    Between two angles gamma. [degree]
    planes : int    C-planes; 1: the same all around.
    """
    polar = np.deg2rad(np.linspace(0.0, 180.0, max(round(180.0 / polar_step), 1) + 1))
    azimuth = np.zeros(1) if planes == 1 else np.linspace(0.0, 2.0 * np.pi, planes + 1)
    shape = (planes, len(polar))
    sums, squares, count = np.zeros(shape), np.zeros(shape), 0
    for direction, flux in pieces:
        turn, gamma = angles(direction.astype(np.float64) @ TO_LUMINAIRE)
        row, v = _locate(polar, gamma)
        column, u = (
            (np.zeros(len(row), np.int64), np.zeros(len(row)))
            if planes == 1
            else _locate(azimuth, turn)
        )
        corners = (
            (0, 0, (1 - u) * (1 - v)),
            (0, 1, (1 - u) * v),
            (1, 0, u * (1 - v)),
            (1, 1, u * v),
        )
        for across, down, share in corners:
            place = (column + across) % planes * len(polar) + row + down
            part = flux * share
            sums += np.bincount(place, part, sums.size).reshape(shape)
            squares += np.bincount(place, part**2, sums.size).reshape(shape)
        count += len(flux)
    around = azimuth_weights(azimuth)
    if planes > 1:
        # The first and the last plane are one.
        around = np.concatenate([[around[0] + around[-1]], around[1:-1]])
    weights = np.outer(around, polar_weights(polar))
    values, errors = sums / weights, np.sqrt(squares) / weights
    for table in (values, errors):
        # A pole is one direction.
        for end in (0, -1):
            table[:, end] = around @ table[:, end] / around.sum()
    if planes > 1:
        values, errors = (np.concatenate([table, table[:1]]) for table in (values, errors))
    return Reduced(IntensityDistribution(azimuth, polar, values), errors, count)


def choose_step(pieces: Iterable[tuple[np.ndarray, np.ndarray]]) -> float:
    """Choose the step between angles for `reduce_rays`, a tenth of the beam's half angle. [degree]

    The beam is the cone with the solid angle in which the intensity is above half of the largest.
    """
    fine = reduce_rays(pieces, STEPS[0], 12).distribution
    weights = np.outer(azimuth_weights(fine.azimuth), polar_weights(fine.polar))
    # One direction with few rays must not pass for the peak.
    level = np.sort(fine.intensity.ravel())[-len(fine.azimuth) * 4]
    angle = float(weights[fine.intensity >= 0.5 * level].sum())
    half = np.arccos(np.clip(1.0 - angle / (2.0 * np.pi), -1.0, 1.0))
    return max((step for step in STEPS if step <= 0.1 * np.rad2deg(half)), default=STEPS[0])


def is_rotational(reduced: Reduced) -> bool:
    """Whether the planes differ by no more than their noise, or by very little."""
    table, errors = reduced.distribution.intensity, reduced.standard_error
    if len(table) == 1:
        return True
    weights = polar_weights(reduced.distribution.polar)
    mean = table.mean(axis=0)
    apart = np.maximum(np.abs(table - mean) - 3.0 * errors, 0.0).mean(axis=0)
    return bool(apart @ weights <= ROTATIONAL * (mean @ weights))


def to_luminaire(
    reduced: Reduced,
    size: tuple[float, float, float],
    metadata: dict[str, str],
    watts: float | None = None,
    spectrum=None,
    remarks: tuple[Remark, ...] = (),
) -> LuminaireFile:
    """Return a reduced ray set as a photometric file that can be written.

    Parameters
    ----------
    reduced : Reduced    In cd.
    size : (float, float, float)    Extent of the starting points along the axes of the rays. [m]
    metadata : dict of str to str    Keywords of LM-63 and texts.
    watts : float or None    Electrical. [W]
    spectrum : ((k,), (k,)) arrays or None    Wavelengths [nm] and relative spectral power.
    remarks : tuple of Remark
    """
    distribution = reduced.distribution
    return LuminaireFile(
        format="ray set",
        photometric_type="C",
        symmetry="rotational" if len(distribution.azimuth) == 1 else "none",
        distribution=distribution,
        opening=_opening(size),
        stored_azimuths=np.rad2deg(distribution.azimuth),
        stored_polars=np.rad2deg(distribution.polar),
        is_absolute=True,
        watts=watts,
        spectrum=spectrum,
        metadata=metadata,
        remarks=remarks,
    )


@dataclass(frozen=True, eq=False)
class LuminanceImage:
    """What a source looks like from a direction, from far away.

    Parameters
    ----------
    luminance : (h, w) float64 array    Row 0 at the top. [cd/m2], or W/(m2 sr)
    width, height : float    Of what it shows, at right angles to the direction. [m]
    rays : int    That made it.
    """

    luminance: np.ndarray
    width: float
    height: float
    rays: int


def view_rays(
    pieces: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]],
    towards: np.ndarray,
    centre: np.ndarray,
    size: float,
    pixels: int = 128,
    cone: float = 5.0,
) -> LuminanceImage:
    """Make an image of the luminances of a source: flux over projected area and solid angle of the rays within a cone.

    Parameters
    ----------
    pieces : iterable of ((n, 3) [m], (n, 3), (n,)) arrays    Starting points, directions, flux.
    towards : (3,) array    From the source to the eye.
    centre : (3,) array    In the middle of the image. [m]
    size : float    Side of what the square image shows. [m]
    pixels : int    Along a side.
    cone : float    Half angle: the wider, the less noise, and the less sharp what lies off the plane through the centre.
        [degree]
    """
    axis = np.asarray(towards, dtype=np.float64)
    axis = axis / np.linalg.norm(axis)
    up = np.array([0.0, 1.0, 0.0] if abs(axis[1]) < 0.9 else [0.0, 0.0, 1.0])
    right = np.cross(up, axis)
    right /= np.linalg.norm(right)
    up = np.cross(axis, right)
    least = np.cos(np.deg2rad(cone))
    total, count = np.zeros((pixels, pixels)), 0
    for position, direction, flux in pieces:
        cosine = direction @ axis
        seen = cosine > least
        away = position[seen] - centre
        # Back along the ray to the plane through the centre, on which the image is sharp.
        away = away - ((away @ axis) / cosine[seen])[:, None] * direction[seen]
        column = np.floor((away @ right / size + 0.5) * pixels).astype(np.int64)
        row = np.floor((0.5 - away @ up / size) * pixels).astype(np.int64)
        inside = (column >= 0) & (column < pixels) & (row >= 0) & (row < pixels)
        place = row[inside] * pixels + column[inside]
        total += np.bincount(place, flux[seen][inside], total.size).reshape(total.shape)
        count += int(inside.sum())
    # Projected solid angle of the cone; flux through a plane at right angles to it is luminance times area times this.
    angle = np.pi * np.sin(np.deg2rad(cone)) ** 2
    return LuminanceImage(total / ((size / pixels) ** 2 * angle), size, size, count)


def _locate(grid: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cell of an even grid, and the place in it, 0 to 1."""
    place = np.clip((value - grid[0]) / (grid[1] - grid[0]), 0.0, len(grid) - 1.0)
    cell = np.minimum(place.astype(np.int64), len(grid) - 2)
    return cell, place - cell


def _opening(size: tuple[float, float, float]) -> Opening:
    """The body of the starting points, flat where they lie in a plane."""
    largest = max(size)
    if largest <= 0.0:
        return Opening()
    flat = [axis for axis, side in zip("xyz", size, strict=True) if side < 1e-3 * largest]
    if len(flat) > 1:
        return Opening()
    if flat:
        kept = tuple(
            0.0 if axis == flat[0] else side for axis, side in zip("xyz", size, strict=True)
        )
        return Opening("rectangle", kept, flat[0])
    return Opening("box", size)
