"""Charts while they are being found: which polygons they hold, and how these lie."""

from dataclasses import dataclass, replace

import numpy as np

from .topology import Topology, find_components, largest_by, sum_by


@dataclass(frozen=True)
class Units:
    """Polygons (or triangles, where there are none) as they hang together; no chart border passes through one.

    Parameters
    ----------
    topology : Topology
    rows : (r,) int64 array    Triangles with area.
    unit : (r,) int64 array    Unit of each of them.
    count : int
    normal : (u, 3) float64 array    Sum of areas times normals. [m2]
    area : (u,) float64 array    [m2]
    centre : (u, 3) float64 array    [m]
    joins : (j, 2) int64 array    Units that go on smoothly into each other.
    join_length : (j,) float64 array    Of their common edges. [m]
    """

    topology: Topology
    rows: np.ndarray
    unit: np.ndarray
    count: int
    normal: np.ndarray
    area: np.ndarray
    centre: np.ndarray
    joins: np.ndarray
    join_length: np.ndarray


def find_units(topology: Topology, cone: float) -> Units:
    """Gather units; edges at which the surface bends by more than the cone part them."""
    rows = np.flatnonzero(topology.area > 0.0)
    unit, count = topology.unit[rows], topology.unit_count
    area = topology.area[rows]
    centre = sum_by(unit, topology.corners[rows].mean(axis=1) * area[:, None], count)
    whole = sum_by(unit, area, count)
    a, b = topology.pairs.T
    ends = topology.unit[topology.pairs]
    smooth = angle_between(topology.normal[a], topology.normal[b]) <= cone
    smooth &= ends[:, 0] != ends[:, 1]
    return Units(
        topology,
        rows,
        unit,
        count,
        sum_by(unit, topology.normal[rows] * area[:, None], count),
        whole,
        centre / np.where(whole > 0.0, whole, 1.0)[:, None],
        ends[smooth],
        topology.pair_length[smooth],
    )


def angle_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angle between unit vectors, exact for small ones too. (n, 3), (n, 3) -> (n,) [rad]"""
    return 2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))


def split_apart(units: Units, label: np.ndarray) -> tuple[np.ndarray, int]:
    """Number the connected parts of equally labelled units; -1 stays -1. (u,) -> (u,), count"""
    same = label[units.joins[:, 0]] == label[units.joins[:, 1]]
    part = find_components(units.count, units.joins[same])
    wanted = label >= 0
    numbers, inverse = np.unique(part[wanted], return_inverse=True)
    made = np.full(units.count, -1, dtype=np.int64)
    made[wanted] = inverse.reshape(-1)
    return made, len(numbers)


@dataclass(frozen=True)
class Bend:
    """How far charts' triangles turn away from them.

    Parameters
    ----------
    direction : (c, 3) float64 array    Unit.
    deviation : (c,) float64 array    Largest angle between it and a triangle's normal, slivers apart. [rad]
    """

    direction: np.ndarray
    deviation: np.ndarray


def measure_bend(units: Units, label: np.ndarray, count: int) -> Bend:
    """Directions of charts, which are their mean normals, and how far their triangles turn away from them."""
    topology = units.topology
    wanted = label >= 0
    mean = to_unit(sum_by(label[wanted], units.normal[wanted], count))
    owner = label[units.unit]
    inside = (owner >= 0) & topology.is_reliable[units.rows]
    owner, normal = owner[inside], topology.normal[units.rows[inside]]
    angle = angle_between(mean[owner], normal)
    deviation = largest_by(owner, angle, count, 0.0)
    return Bend(mean, deviation)


def to_unit(vectors: np.ndarray) -> np.ndarray:
    """Unit vectors; upwards where there is no direction."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 0.0, vectors / np.where(length > 0.0, length, 1.0), (0.0, 0.0, 1.0))


def find_axes(direction: np.ndarray) -> np.ndarray:
    """Right-handed axes whose third one is given. (c, 3) -> (c, 3, 3), an axis per row"""
    helper = np.eye(3)[np.argmin(np.abs(direction), axis=1)]
    across = to_unit(np.cross(helper, direction))
    return np.stack([across, np.cross(direction, across), direction], axis=1)


def project(units: Units, label: np.ndarray, bend: Bend) -> np.ndarray:
    """Project triangles along the directions of their charts; all units must be labelled. (r, 3, 2) [m]"""
    axes = find_axes(bend.direction)[label[units.unit], :2]
    return np.einsum("tcx,tax->tca", units.topology.corners[units.rows], axes)


def lay_out_of(corners: np.ndarray) -> np.ndarray:
    """Lay triangles flat, each by itself: the first edge along x. (t, 3, 3) -> (t, 3, 2)"""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    length = np.linalg.norm(first, axis=1)
    height = np.linalg.norm(np.cross(first, second), axis=1)
    safe = np.where(length > 0.0, length, 1.0)
    flat = np.zeros((len(corners), 3, 2))
    flat[:, 1, 0] = length
    flat[:, 2, 0] = (first * second).sum(axis=1) / safe
    flat[:, 2, 1] = height / safe
    return flat


def unfold(corners: np.ndarray, slot: np.ndarray, known: np.ndarray, place: np.ndarray) -> None:
    """Lay triangles at the edges of placed ones, true to shape, until no more can be; in place.

    Parameters
    ----------
    corners : (t, 3, 3) float64 array    Triangles to be placed. [m]
    slot : (t, 3) int64 array    Place of every corner.
    known : (s,) bool array    Places that are known already.
    place : (s, 2) float64 array    [m]
    """
    left = np.arange(len(corners))
    shape = lay_out_of(corners)
    while len(left):
        has = known[slot[left]]
        ready = has.sum(axis=1) == 2
        rows = left[ready]
        if len(rows) == 0:
            return
        third = np.argmin(has[ready], axis=1)
        a, b = (third + 1) % 3, (third + 2) % 3
        line = np.arange(len(rows))
        tri, where = shape[rows], slot[rows]
        along = tri[line, b] - tri[line, a]
        away = tri[line, third] - tri[line, a]
        square = np.maximum((along**2).sum(axis=1), 1e-300)
        share = (along * away).sum(axis=1) / square
        rise = (along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0]) / square
        p, q = place[where[line, a]], place[where[line, b]]
        edge = q - p
        across = np.stack([-edge[:, 1], edge[:, 0]], axis=1)
        found = p + share[:, None] * edge + rise[:, None] * across
        # A place that several neighbours lead to lies in their middle.
        target, inverse = np.unique(where[line, third], return_inverse=True)
        inverse = inverse.reshape(-1)
        number = np.bincount(inverse, minlength=len(target))
        place[target] = sum_by(inverse, found, len(target)) / number[:, None]
        known[target] = True
        left = left[~known[slot[left]].all(axis=1)]


def narrow(units: Units, wanted: np.ndarray) -> Units:
    """Keep only the triangles and joins of wanted units; numbers stay. (u,) bool"""
    rows = wanted[units.unit]
    joins = wanted[units.joins].all(axis=1)
    return replace(
        units,
        rows=units.rows[rows],
        unit=units.unit[rows],
        joins=units.joins[joins],
        join_length=units.join_length[joins],
    )
