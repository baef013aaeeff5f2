"""The polar solid of a luminaire as geometry: every direction reaches as far out as its intensity, the peak to 1.

All in the luminaire's own axes. Where to draw it is the business of `luminaire_places`, how of the user interface.
"""

from dataclasses import dataclass

import numpy as np

from ...engine.luminaires.coordinates import directions
from ...engine.luminaires.distribution import TURN, intensity, intensity_at, is_closed, peak
from ...engine.luminaires.sections import section
from ...engine.scene.distribution import IntensityDistribution, Opening

PLANES = (0.0, 0.5 * np.pi)
"""C of the two planes whose curves are drawn: C0-C180 and C90-C270. [rad]"""

LIGHT = np.array([0.35, -0.5, 0.79])
"""Direction that the shading of the solid takes its light from, unit length."""

SHADOW = 0.4
"""Brightness of what faces away from `LIGHT`, where 1 faces it."""

EVEN_SHARE = 0.25
"""Share of the samples that is spread evenly over the angles; the rest goes where the surface is long."""


@dataclass(frozen=True, eq=False)
class Solid:
    """Closed surface of triangles.

    Parameters
    ----------
    vertices : (n, 3) float32 array    Direction times intensity over peak. [-]
    triangles : (m, 3) int32 array    Counter-clockwise seen from outside.
    brightness : (n,) float32 array    `SHADOW` to 1, the more it faces `LIGHT`.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    brightness: np.ndarray


def make_solid(distribution: IntensityDistribution, columns: int, rows: int) -> Solid:
    """Build the solid of a distribution from about ``columns`` times ``rows`` directions.

    The directions are closest where the surface bends or reaches far out, so that narrow beams keep their shape. A dark
    distribution has no triangles.
    """
    largest, peak_azimuth, peak_polar = peak(distribution)
    if largest <= 0.0:
        nothing = np.zeros((0, 3), np.float32)
        return Solid(nothing, nothing.astype(np.int32), np.zeros(0, np.float32))
    azimuth = _sample_azimuths(distribution, columns, peak_azimuth)
    polar = _sample_polars(distribution, rows, peak_polar)
    share = intensity_at(distribution, azimuth[:, None], polar[None, :]) / largest
    azimuth, polar, share = _close(distribution, azimuth, polar, share)
    points = directions(azimuth[:, None], polar[None, :], distribution.frame) * share[..., None]
    triangles = _triangles(len(azimuth), len(polar), is_closed(distribution))
    # A grid that is mirrored by its frame would turn its inside out.
    if np.linalg.det(distribution.frame) < 0.0:
        triangles = triangles[:, ::-1]
    vertices = points.reshape(-1, 3)
    triangles = triangles[_areas(vertices, triangles) > 1e-12]
    normals = _normals(points.shape[:2], vertices, triangles, polar)
    brightness = SHADOW + (1.0 - SHADOW) * (0.5 + 0.5 * normals @ LIGHT)
    return Solid(
        vertices.astype(np.float32), triangles.astype(np.int32), brightness.astype(np.float32)
    )


def make_curve(distribution: IntensityDistribution, plane: float, count: int) -> np.ndarray:
    """Return the curve in the plane of C and C + 180 deg as a closed line. (count + 1, 3), [-]

    Parameters
    ----------
    distribution : IntensityDistribution
    plane : float    C, in the luminaire's axes. [rad]
    count : int    Number of segments.
    """
    largest, _, _ = peak(distribution)
    if largest <= 0.0:
        return np.zeros((0, 3))
    angle, values = section(distribution, plane)
    gamma = _equidistribute(angle, _lengths(angle, values[None] / largest), count + 1)
    top = angle[np.argmax(values)]
    gamma[np.argmin(np.abs(gamma - top))] = top
    reach = intensity(distribution, directions(plane, gamma)) / largest
    curve = directions(plane, gamma) * reach[:, None]
    curve[-1] = curve[0]
    return curve


def make_outline(opening: Opening) -> np.ndarray:
    """Return the edges of the luminous opening as pairs of points. (n, 2, 3), [m]"""
    half = 0.5 * np.asarray(opening.size)
    match opening.shape:
        case "rectangle":
            lines = [_square(opening.axis, 0.0)]
        case "ellipse":
            lines = [_circle(opening.axis, 0.0)]
        case "box":
            lines = [_square("z", -1.0), _square("z", 1.0), _bars(_square("z", 0.0), "z")]
        case "cylinder":
            axis = opening.axis
            lines = [_circle(axis, -1.0), _circle(axis, 1.0), _bars(_circle(axis, 0.0)[::8], axis)]
        case "ellipsoid":
            lines = [_circle(axis, 0.0) for axis in "xyz"]
        case _:
            return np.zeros((0, 2, 3))
    return np.concatenate(lines) * half


# ---- choice of directions ----


def _sample_polars(distribution, count: int, wanted: float) -> np.ndarray:
    grid = distribution.polar
    fine = _merge(grid, np.linspace(grid[0], grid[-1], 181))
    columns = distribution.azimuth[:: max(1, len(distribution.azimuth) // 90)]
    reach = intensity_at(distribution, columns[:, None], fine[None, :])
    return _merge(_equidistribute(fine, _lengths(fine, reach), count), [wanted])


def _sample_azimuths(distribution, count: int, wanted: float) -> np.ndarray:
    """Azimuths, the end of a full turn left out."""
    grid = distribution.azimuth
    if len(grid) == 1:
        return np.linspace(0.0, TURN, count, endpoint=False)
    fine = _merge(grid, np.linspace(grid[0], grid[-1], 181))
    rows = distribution.polar[:: max(1, len(distribution.polar) // 90)]
    reach = intensity_at(distribution, fine[:, None], rows[None, :]).T
    chosen = _equidistribute(fine, _lengths(fine, reach, np.sin(rows)), count + 1)
    if is_closed(distribution):
        return _merge(chosen[:-1], [wanted if wanted < chosen[-1] - 1e-9 else chosen[0]])
    return _merge(chosen, [wanted])


def _lengths(angle: np.ndarray, reach: np.ndarray, lever=1.0) -> np.ndarray:
    """Length of the curves between neighbouring angles, the longest of all curves. (n - 1,)"""
    along = 0.5 * (reach[:, 1:] + reach[:, :-1]) * np.diff(angle) * np.reshape(lever, (-1, 1))
    return np.hypot(np.diff(reach, axis=1) * np.reshape(lever, (-1, 1)), along).max(axis=0)


def _equidistribute(angle: np.ndarray, lengths: np.ndarray, count: int) -> np.ndarray:
    """Angles between which the lengths are alike, both ends included. (count,)"""
    even = np.diff(angle) / (angle[-1] - angle[0])
    total = lengths.sum()
    density = even if total <= 0.0 else EVEN_SHARE * even + (1.0 - EVEN_SHARE) * lengths / total
    place = np.concatenate([[0.0], np.cumsum(density)])
    return np.interp(np.linspace(0.0, place[-1], count), place, angle)


def _merge(*angles) -> np.ndarray:
    """Return all angles, ascending, those that are the same but for rounding once."""
    merged = np.sort(np.concatenate([np.asarray(some, dtype=np.float64) for some in angles]))
    return merged[np.concatenate([[True], np.diff(merged) > 1e-9])]


# ---- surface ----


def _close(distribution, azimuth, polar, share):
    """Add rows and columns of no intensity where the grid ends with light, so that no hole is left."""
    if distribution.polar[0] > 1e-9:
        polar, share = np.r_[polar[:1], polar], np.pad(share, ((0, 0), (1, 0)))
    if distribution.polar[-1] < np.pi - 1e-9:
        polar, share = np.r_[polar, polar[-1:]], np.pad(share, ((0, 0), (0, 1)))
    if not is_closed(distribution):
        azimuth, share = np.r_[azimuth[:1], azimuth, azimuth[-1:]], np.pad(share, ((1, 1), (0, 0)))
    return azimuth, polar, share


def _triangles(columns: int, rows: int, closed: bool) -> np.ndarray:
    column = np.arange(columns if closed else columns - 1)[:, None]
    row = np.arange(rows - 1)[None, :]
    following = (column + 1) % columns
    a, b = column * rows + row, following * rows + row
    halves = np.stack([a, b, b + 1], axis=-1), np.stack([a, b + 1, a + 1], axis=-1)
    return np.concatenate([half.reshape(-1, 3) for half in halves])


def _areas(vertices, triangles) -> np.ndarray:
    return np.linalg.norm(_crosses(vertices, triangles), axis=1)


def _crosses(vertices, triangles) -> np.ndarray:
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def _normals(shape, vertices, triangles, polar) -> np.ndarray:
    """Normals of the vertices, unit length; those at a pole are one. (n, 3)"""
    crosses = _crosses(vertices, triangles)
    normals = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], crosses)
    table = normals.reshape(*shape, 3)
    for row in np.flatnonzero(np.sin(polar) < 1e-9):
        table[:, row] = table[:, row].sum(axis=0)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


# ---- outlines, within -1..1 ----


def _ring(angle: np.ndarray, radius: float, axis: str, place: float) -> np.ndarray:
    """Closed line around an axis as pairs of points. (n, 2, 3)"""
    flat = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = np.insert(flat, "xyz".index(axis), place, axis=1)
    return np.stack([points, np.roll(points, -1, axis=0)], axis=1)


def _square(axis: str, place: float) -> np.ndarray:
    return _ring(np.pi / 4.0 + np.pi / 2.0 * np.arange(4), 2.0**0.5, axis, place)


def _circle(axis: str, place: float) -> np.ndarray:
    return _ring(TURN * np.arange(32) / 32.0, 1.0, axis, place)


def _bars(ring: np.ndarray, axis: str) -> np.ndarray:
    """Lines along an axis through the first points of a ring's pairs."""
    ends = np.repeat(ring[:, :1], 2, axis=1)
    ends[:, :, "xyz".index(axis)] = (-1.0, 1.0)
    return ends
