"""Tables of scattering in coordinates about the mirror direction: evaluation, integrals and checks, in double precision."""

from functools import lru_cache

import numpy as np

from ...errors import SceneError
from ...scene.scattering import ScatterTable

QUADRATURE, FINE_QUADRATURE = 4, 2
"""Points of Gauss and Legendre along both axes in each cell of a table: of few cells, and of many."""

MANY_CELLS = 4096
"""Cells of one incidence, radial angles times azimuths, from which on they are many."""

WIDEST = np.radians(7.5)
"""Cells are cut to this width along the azimuth to be integrated over: the horizon bends within wider ones. [rad]"""

MOST_VALUES, MOST_DIRECTIONS = 1 << 26, 1 << 18
"""Values that a table may have, and directions of each incidence."""

CLOSEST = 1e-6
"""Grid lines nearer than this share of the axis' range are one in single precision. [-]"""


def check_table(table: ScatterTable) -> None:
    """Refuse a table that breaks its own rules.

    Raises
    ------
    SceneError    Says what is wrong with it.
    """
    axes = (
        ("rotation", table.rotations, 0.0, 2.0 * np.pi),
        ("angle of incidence", table.incidences, 0.0, 0.5 * np.pi),
        ("radial angle", table.radials, 0.0, np.pi),
        ("azimuth", table.azimuths, 0.0, 2.0 * np.pi),
        ("wavelength", table.wavelengths, 100.0, 1e5),
    )
    for name, axis, low, high in axes:
        if axis.ndim != 1 or not axis.size or not np.isfinite(axis).all():
            raise SceneError(f"a scattering table has no {name}, or one that is no number")
        if np.any(np.diff(axis) <= CLOSEST * high) or axis[0] < low or axis[-1] > high + 1e-6:
            raise SceneError(
                f"a scattering table's {name}s must ascend strictly from {low:g} to {high:.4g}"
            )
    if table.rotations[-1] > table.rotations[0] + 2.0 * np.pi * (1.0 - CLOSEST):
        raise SceneError("a scattering table has its first rotation twice, at 0 and at 360 degrees")
    ends = table.rotations[[0, -1]] - [0.0, 0.5 * np.pi]
    if table.is_orthotropic and np.abs(ends).max() > CLOSEST:
        raise SceneError("an orthotropic scattering table's rotations must go from 0 to 90 degrees")
    shape = tuple(len(axis) for _, axis, _, _ in axes)
    if shape[2] * shape[3] > MOST_DIRECTIONS:
        raise SceneError(
            f"a scattering table has {shape[2]} x {shape[3]} directions, expected {MOST_DIRECTIONS} at most"
        )
    if table.values.shape != shape or table.values.size > MOST_VALUES:
        raise SceneError(
            f"a scattering table has values of shape {table.values.shape}, expected {shape} by its axes"
        )
    if len(table.azimuths) < 2 or len(table.radials) < 2:
        raise SceneError("a scattering table needs two azimuths and two radial angles at least")
    if table.azimuths[0] != 0.0 or min(abs(table.azimuths[-1] - np.pi * k) for k in (1, 2)) > 1e-6:
        raise SceneError("a scattering table's azimuths must go from 0 to pi or to 2 pi")
    if table.radials[0] != 0.0:
        raise SceneError("a scattering table's radial angles must begin with 0")
    if not np.isfinite(table.values).all() or table.values.min() < 0.0:
        raise SceneError("a scattering table has a value that is negative or no finite number")
    direct = table.direct
    if direct is not None and (
        direct.shape != (shape[0], shape[1], shape[4])
        or not np.isfinite(direct).all()
        or direct.min() < 0.0
        or direct.max() > 1.0
    ):
        raise SceneError("a scattering table's direct shares must be 0 to 1, one per incidence")


def is_symmetric(table: ScatterTable) -> bool:
    """Whether both sides of the plane of incidence are alike."""
    return bool(table.azimuths[-1] < 1.5 * np.pi)


def direction_of(incidence, radial, azimuth) -> np.ndarray:
    """Direction at a radial angle and azimuth, light coming in the xz-plane; arrays that fit together. (..., 3)"""
    sin_s, cos_s = np.sin(incidence), np.cos(incidence)
    cos_t, sin_t = np.cos(radial), np.sin(radial)
    across, aside = sin_t * np.cos(azimuth), sin_t * np.sin(azimuth)
    parts = (-sin_s * cos_t - cos_s * across, aside, cos_s * cos_t - sin_s * across)
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def turned(directions: np.ndarray, rotation) -> np.ndarray:
    """Directions (n, 3) turned about the normal by angles (n,). [rad]"""
    cos_r, sin_r = np.cos(rotation), np.sin(rotation)
    x, y, z = directions.T
    return np.stack([cos_r * x - sin_r * y, sin_r * x + cos_r * y, z], axis=1)


def coordinates_of(wi, wo) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rotation, incidence, radial angle and azimuth of pairs of directions. (n, 3) each -> (n,) each [rad]"""
    wi, wo = np.asarray(wi, dtype=np.float64), np.asarray(wo, dtype=np.float64)
    sine = np.hypot(wi[..., 0], wi[..., 1])
    incidence = np.arctan2(sine, wi[..., 2])
    rotation = np.where(sine > 0.0, np.arctan2(wi[..., 1], wi[..., 0]), 0.0) % (2.0 * np.pi)
    cos_r, sin_r = np.cos(rotation), np.sin(rotation)
    x = cos_r * wo[..., 0] + sin_r * wo[..., 1]
    y = cos_r * wo[..., 1] - sin_r * wo[..., 0]
    sin_s, cos_s = np.sin(incidence), np.cos(incidence)
    centre = -sin_s * x + cos_s * wo[..., 2]
    outward = -cos_s * x - sin_s * wo[..., 2]
    radial = np.arctan2(np.hypot(outward, y), centre)
    azimuth = np.arctan2(y, outward) % (2.0 * np.pi)
    return rotation, incidence, radial, azimuth


def place_on(axis: np.ndarray, value) -> tuple[np.ndarray, np.ndarray]:
    """Number of the grid point below values and the share of the next; the ends hold beyond. (n,), (n,)"""
    if len(axis) == 1:
        return np.zeros(np.shape(value), dtype=np.int64), np.zeros(np.shape(value))
    below = np.clip(np.searchsorted(axis, value, side="right") - 1, 0, len(axis) - 2)
    share = (value - axis[below]) / (axis[below + 1] - axis[below])
    return below, np.clip(share, 0.0, 1.0)


def fold_rotation(rotation) -> tuple[np.ndarray, np.ndarray]:
    """Rotations of the first quarter at which an orthotropic surface does the same, and whether it does it mirrored."""
    half = np.asarray(rotation) % np.pi
    return np.minimum(half, np.pi - half), half > 0.5 * np.pi


def rotations_around(table: ScatterTable) -> np.ndarray:
    """Rotations of all that a table tells, those of all quarters. [rad]"""
    if not table.is_orthotropic:
        return table.rotations
    half = np.concatenate([table.rotations, np.pi - table.rotations[-2:0:-1]])
    return np.concatenate([half, half + np.pi])


def _places_of_rotation(table: ScatterTable, rotation):
    """The two grid points about rotations and the share of the second; the axis closes on itself, or ends at a quarter."""
    axis = table.rotations
    if table.is_orthotropic:
        below, share = place_on(axis, rotation)
        return below, below + 1, share
    closed = np.append(axis, axis[0] + 2.0 * np.pi)
    turned = np.where(rotation < axis[0], rotation + 2.0 * np.pi, rotation)
    below, share = place_on(closed, turned)
    return below, (below + 1) % len(axis), share


def evaluate_table(table: ScatterTable, wi, wo) -> np.ndarray:
    """Values for pairs of directions at the table's wavelengths. (n, 3), (n, 3) -> (n, w) float64 [1/sr]"""
    wi, wo = np.asarray(wi, dtype=np.float64), np.asarray(wo, dtype=np.float64)
    above = (wo[:, 2] > 0.0) & (wi[:, 2] > 0.0)
    return np.where(above[:, None], interpolate(table, *coordinates_of(wi, wo)), 0.0)


def interpolate(table: ScatterTable, rotation, incidence, radial, azimuth) -> np.ndarray:
    """What a table says at coordinates, above the horizon or not. (n,) each -> (n, w) float64 [1/sr]"""
    if table.is_orthotropic:
        rotation, is_mirrored = fold_rotation(rotation)
        azimuth = np.where(is_mirrored, 2.0 * np.pi - azimuth, azimuth)
    if is_symmetric(table):
        azimuth = np.where(azimuth > np.pi, 2.0 * np.pi - azimuth, azimuth)
    first, second, turn = _places_of_rotation(table, rotation)
    s, s_share = place_on(table.incidences, incidence)
    t, t_share = place_on(table.radials, radial)
    a, a_share = place_on(table.azimuths, azimuth)
    found = np.zeros((len(radial), len(table.wavelengths)))
    rotations = ((first, 1.0),)
    if len(table.rotations) > 1:
        rotations = ((first, 1.0 - turn), (second, turn))
    for p, p_weight in rotations:
        for ds, s_weight in corners(s, s_share, len(table.incidences)):
            for dt, t_weight in corners(t, t_share, len(table.radials)):
                for da, a_weight in corners(a, a_share, len(table.azimuths)):
                    weight = p_weight * s_weight * t_weight * a_weight
                    found += weight[:, None] * table.values[p, ds, dt, da]
    return found


def corners(below, share, count):
    """Grid lines around places as `place_on` gives them, each with its weight; one line is all there is of a grid of one."""
    if count == 1:
        return ((below, np.ones_like(share)),)
    return ((below, 1.0 - share), (below + 1, share))


def direct_share(table: ScatterTable, wi) -> np.ndarray:
    """Share of light from directions that is reflected as by a mirror or passes straight. (n, 3) -> (n, w) [-]"""
    wi = np.asarray(wi, dtype=np.float64)
    if table.direct is None:
        return np.zeros((len(wi), len(table.wavelengths)))
    rotation, incidence, _, _ = coordinates_of(wi, wi)
    if table.is_orthotropic:
        rotation, _ = fold_rotation(rotation)
    first, second, turn = _places_of_rotation(table, rotation)
    s, s_share = place_on(table.incidences, incidence)
    found = np.zeros((len(wi), len(table.wavelengths)))
    for p, p_weight in ((first, 1.0 - turn), (second, turn)):
        for ds, s_weight in corners(s, s_share, len(table.incidences)):
            found += (p_weight * s_weight)[:, None] * table.direct[p, ds]
    return found


def albedo_of(table: ScatterTable, incidence: float, rotation: float = 0.0) -> np.ndarray:
    """Share of light from one direction that is scattered, without the direct part: integral of f cos. (w,) [-]"""
    return albedos_of(table, [incidence], [rotation])[0, 0]


def albedos_of(table: ScatterTable, incidences, rotations) -> np.ndarray:
    """Shares of light that are scattered, without the direct part. (s,), (p,) -> (p, s, w) [-]"""
    folded = np.asarray(rotations, dtype=np.float64) % (2.0 * np.pi)
    if table.is_orthotropic:
        # The mirror image scatters as much.
        folded, _ = fold_rotation(folded)
    first, second, turn = _places_of_rotation(table, folded)
    turn = turn[:, None]
    made = np.zeros((len(folded), len(incidences), len(table.wavelengths)))
    for k, incidence in enumerate(incidences):
        weights = grid_weights(table, incidence)
        for s, share in corners(*place_on(table.incidences, incidence), len(table.incidences)):
            each = share * np.tensordot(table.values[:, s], weights, ((1, 2), (0, 1)))
            made[:, k] += (1.0 - turn) * each[first] + turn * each[second]
    return made


def has_many_cells(table: ScatterTable) -> bool:
    """Whether the cells are so many, and so small, that few points of each do."""
    return len(table.radials) * len(table.azimuths) > MANY_CELLS


def grid_weights(table: ScatterTable, incidence: float) -> np.ndarray:
    """Weights of a table's radial angles and azimuths in the integral of its values times the cosine of wo. (t, a) [sr]"""
    points = FINE_QUADRATURE if has_many_cells(table) else QUADRATURE
    return weights_of_points(table, *quadrature(table, incidence, points))


def weights_of_points(table: ScatterTable, radial, azimuth, weight) -> np.ndarray:
    """Weights of a table's radial angles and azimuths in an integral over points, as of `quadrature`. (t, a)"""
    t, t_share = place_on(table.radials, radial)
    a, a_share = place_on(table.azimuths, azimuth)
    shape = len(table.radials), len(table.azimuths)
    made = np.zeros(shape[0] * shape[1])
    for dt, t_weight in corners(t, t_share, shape[0]):
        for da, a_weight in corners(a, a_share, shape[1]):
            made += np.bincount(dt * shape[1] + da, weight * t_weight * a_weight, len(made))
    return made.reshape(shape)


def quadrature(table: ScatterTable, incidence: float, points: int = QUADRATURE):
    """Radial angles, azimuths and weights that integrate a function with the kinks of a table times the cosine of wo.

    By Gauss and Legendre in every cell, cells cut where the horizon crosses them. Of a table with alike sides the points
    are on one of them, with the weights of both. A single point is as good as two along both axes for what is 0 at the
    corners of the cells, see `_nodes`.

    Returns
    -------
    (n,), (n,), (n,) float64 arrays    [rad], [rad], [sr]
    """
    gaps = np.diff(table.azimuths)
    counts = np.ceil(gaps / WIDEST).astype(int)
    before = np.repeat(np.cumsum(counts) - counts, counts)
    pieces = np.repeat(table.azimuths[:-1], counts)
    pieces += (np.arange(counts.sum()) - before) * np.repeat(gaps / counts, counts)
    azimuths, azimuth_weights = _cells(np.append(pieces, table.azimuths[-1]), points)
    # Below this radial angle directions are above the horizon: cos t cos s = sin t cos a sin s there.
    horizon = np.arctan2(
        np.full_like(azimuths, np.cos(incidence)), np.cos(azimuths) * np.sin(incidence)
    )
    radials = np.append(table.radials, np.pi) if table.radials[-1] < np.pi else table.radials
    low, high = radials[:-1, None], np.minimum(radials[1:, None], horizon)
    length = np.maximum(high - low, 0.0)
    nodes, weights = _nodes(len(radials) - 1, points)
    radial = low[..., None] + 0.5 * length[..., None] * (nodes[:, None] + 1.0)
    weight = 0.5 * length[..., None] * weights * azimuth_weights[:, None]
    azimuth = np.broadcast_to(azimuths[:, None], radial.shape)
    used = weight > 0.0
    radial, azimuth, weight = radial[used], azimuth[used], weight[used]
    cosine = np.cos(radial) * np.cos(incidence) - np.sin(radial) * np.cos(azimuth) * np.sin(
        incidence
    )
    sides = 2.0 if is_symmetric(table) else 1.0
    return radial, azimuth, sides * weight * np.sin(radial) * np.maximum(cosine, 0.0)


@lru_cache(maxsize=64)
def _nodes(cells: int, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of Gauss and Legendre between -1 and 1 in each of some cells, and their weights. (cells, points), (points,)

    A single one lies in turn at the one and the other of two: there a parabola that is 0 at both ends, like the error of
    what is linear between them, has its mean. In the middle it has its peak.
    """
    nodes, weights = np.polynomial.legendre.leggauss(points if points > 1 else 2)
    if points > 1:
        return np.broadcast_to(nodes, (cells, points)), weights
    return nodes[np.arange(cells) % 2, None], weights[:1] * 2.0


def _cells(axis: np.ndarray, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights of a quadrature in every cell of an axis."""
    nodes, weights = _nodes(len(axis) - 1, points)
    low, length = axis[:-1, None], np.diff(axis)[:, None]
    return (low + 0.5 * length * (nodes + 1.0)).ravel(), (0.5 * length * weights).ravel()
