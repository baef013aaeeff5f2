"""A distribution cut by a plane through the luminaire's vertical, and how wide its beam is there."""

import numpy as np

from ..scene.distribution import IntensityDistribution
from .coordinates import directions
from .distribution import TURN, intensity, is_closed

STEP = np.deg2rad(0.1)
"""Raster of a section, to which the angles of the grid are added. [rad]"""

_EDGE = np.deg2rad(1e-6)
"""How far beyond an edge of the grid, where the intensity drops to nothing, a section looks. [rad]"""

_SAME = 1e-9
"""Relative difference under which two maxima are alike."""


def section(distribution: IntensityDistribution, azimuth: float) -> tuple[np.ndarray, np.ndarray]:
    """Cut a distribution by a vertical plane.

    The angles of the grid are among those returned, so nothing is lost of the planes C0-C180 and C90-C270 of all three
    photometric types: there the intensity is linear between neighbours.

    Parameters
    ----------
    azimuth : float    C of the half-plane where the angle is positive. [rad]

    Returns
    -------
    (n,) float64 array    Angle from the luminaire's -z, ascending from -pi to pi. [rad]
    (n,) float64 array    [cd]
    """
    polar, around = distribution.polar, distribution.azimuth
    edges = [polar[0] - _EDGE, polar[-1] + _EDGE]
    if not is_closed(distribution):
        edges += [around[0] - _EDGE, around[-1] + _EDGE]
    # Of types A and B, the azimuth and the polar angle less 90 degrees count from -z, each in one of the two planes.
    grid = np.concatenate([polar, around, edges])
    grid = np.concatenate([grid, -grid, grid - 0.5 * np.pi, 0.5 * np.pi - grid])
    grid = np.mod(grid + np.pi, TURN) - np.pi
    raster = np.linspace(-np.pi, np.pi, round(TURN / STEP) + 1)
    angle = np.unique(np.concatenate([raster, grid]))
    return angle, intensity(distribution, directions(azimuth, angle))


def spread(angle: np.ndarray, values: np.ndarray, share: float) -> float | None:
    """Full angle of the beam in a section: where the intensity is at least a share of the section's largest.

    It goes from the outermost such direction on one side to the outermost on the other, whatever lies between, so the two
    lobes of a batwing are one beam. Of a luminaire that shines up and down, it is the beam on the side of the larger one.

    Parameters
    ----------
    angle, values : (n,) array    As of `section`. [rad], [cd]
    share : float    0.5: beam angle; 0.1: field angle.

    Returns
    -------
    float or None    [rad] 2 pi if it never falls below; None if nothing is emitted in the plane.

    References
    ----------
    ANSI/IES LS-1: angle between the two directions for which the intensity is 50 % (10 %) of the maximum intensity as
    measured in a plane through the nominal beam centreline. CIE S 017 (17-27-078) relates it to the centre-beam intensity,
    which is the same wherever the maximum is in the centre.
    """
    largest = values.max()
    if largest <= 0.0:
        return None
    threshold = share * largest
    if np.all(values >= threshold):
        return TURN
    down = np.abs(angle) <= 0.5 * np.pi
    shines_down = values[down].max() >= largest * (1.0 - _SAME)
    beams = [lobe[:2] for lobe in _lobes(angle, values, threshold) if lobe[2 if shines_down else 3]]
    axis = 0.0 if shines_down else np.pi
    ends = np.array([_near(axis, start, end) for start, end in beams])
    return float(min(ends[:, 1].max() - ends[:, 0].min(), TURN))


def _lobes(angle, values, threshold) -> list[tuple[float, float, bool, bool]]:
    """Start and end of each range at or above a threshold [rad], and whether it is largest below, and above, the horizontal.

    The section has a gap. A lobe as large on both sides belongs to both.
    """
    # The circle is opened at a direction below the threshold, so that no lobe is cut in two.
    first = int(np.argmin(values[:-1]))
    angle = np.concatenate([angle[first:-1], angle[: first + 1] + TURN])
    values = np.concatenate([values[first:-1], values[: first + 1]])
    above = values >= threshold
    rises = np.flatnonzero(~above[:-1] & above[1:])
    falls = np.flatnonzero(above[:-1] & ~above[1:])

    def crossing(i):
        share = (threshold - values[i]) / (values[i + 1] - values[i])
        return angle[i] + share * (angle[i + 1] - angle[i])

    lobes = []
    for rise, fall in zip(rises, falls, strict=True):
        inside = slice(rise + 1, fall + 1)
        cosine, own = np.cos(angle[inside]), values[inside]
        is_top = own >= own.max() * (1.0 - _SAME)
        sides = (is_top & (cosine >= -_SAME)).any(), (is_top & (cosine <= _SAME)).any()
        lobes.append((crossing(rise), crossing(fall), *map(bool, sides)))
    return lobes


def _near(axis: float, start: float, end: float) -> tuple[float, float]:
    """Shift a range by full turns so that its middle is nearest to the axis."""
    turns = TURN * np.round((0.5 * (start + end) - axis) / TURN)
    return start - turns, end - turns
