"""Charts by normals alone: connected triangles that face one way, projected along their mean direction.

It takes a time in proportion to the mesh, whatever its shape, and serves where no library has to or may be asked: what is
flat or nearly so, what is too large or too rough for the library, and what the library failed at.
"""

from dataclasses import dataclass

import numpy as np

from .outline import find_overlapping
from .patches import (
    Units,
    angle_between,
    find_axes,
    lay_out_of,
    measure_bend,
    narrow,
    project,
    split_apart,
    to_unit,
    unfold,
)
from .topology import largest_by, sum_by

BOX = np.array(
    [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], dtype=np.float64
)
"""Directions of a box; every direction is within 54.7 degrees of one of them."""

VOTES = 3
"""Rounds in which units may join the direction of their neighbours, so that rough surfaces do not fall to crumbs."""

SMALL = 2.0
"""Side below which a chart joins a neighbour, if the cone allows. [lumel]"""


@dataclass(frozen=True)
class Patches:
    """Charts of some of a mesh's triangles.

    Parameters
    ----------
    chart : (r,) int64 array    By row of `Units`; -1 for triangles that were not asked for.
    uv : (r, 3, 2) float64 array    [m]
    count : int
    """

    chart: np.ndarray
    uv: np.ndarray
    count: int


def group_by_normals(
    units: Units, wanted: np.ndarray, cone: float, density: float
) -> tuple[np.ndarray, int]:
    """Group connected units whose triangles turn away from the group's direction by the cone at most.

    Parts that fit in a cone as they are stay whole; others are cut by the directions of a box, and what is still too bent
    is halved where its normals spread most. A single unit is never cut.

    Parameters
    ----------
    units : Units
    wanted : (u,) bool array
    cone : float    [rad]
    density : float    Lumels per metre, by which small groups are judged.

    Returns
    -------
    (u,) int64 array with -1 for units that are not wanted, and the number of groups
    """
    units = narrow(units, wanted)
    label, count = split_apart(units, np.where(wanted, 0, -1))
    too_bent = measure_bend(units, label, count).deviation > cone
    if too_bent.any():
        bent = np.where(label >= 0, too_bent[label], False)
        box = np.where(bent, _find_box_sides(units, bent, cone) + 1, 0)
        label, count = split_apart(units, np.where(label >= 0, box, -1))
        label, count = _merge_small(units, label, count, cone, (SMALL / density) ** 2)
    return split_cones(units, label, count, cone)


def _find_box_sides(units: Units, wanted: np.ndarray, cone: float) -> np.ndarray:
    """Side of a box that every unit faces, or that most of its border has beside it, if the cone allows. (u,)"""
    normal = to_unit(units.normal)
    facing = normal @ BOX.T
    side = np.argmax(facing, axis=1)
    allowed = facing >= np.cos(cone)
    used = wanted[units.joins].all(axis=1)
    a, b = np.concatenate([units.joins[used], units.joins[used][:, ::-1]]).T
    weight = np.tile(units.join_length[used], 2)
    line = np.arange(units.count)
    for _ in range(VOTES):
        votes = np.bincount(a * 6 + side[b], weight, minlength=6 * units.count).reshape(-1, 6)
        votes = np.where(allowed, votes, -1.0)
        best = np.argmax(votes, axis=1)
        wins = votes[line, best] > np.maximum(votes[line, side], 0.0) * (1.0 + 1e-9)
        if not wins.any():
            break
        side = np.where(wins, best, side)
    return side


def _merge_small(units: Units, label, count: int, cone: float, least: float):
    """Let groups below an area join the neighbour with the longest common border, if the cone allows. [m2]"""
    for _ in range(2):
        wanted = label >= 0
        small = sum_by(label[wanted], units.area[wanted], count) < least
        ends = np.concatenate([label[units.joins], label[units.joins][:, ::-1]])
        leads = (ends[:, 0] != ends[:, 1]) & small[ends[:, 0]] & ~small[ends[:, 1]]
        if not leads.any():
            break
        key, inverse = np.unique(ends[leads, 0] * count + ends[leads, 1], return_inverse=True)
        border = np.bincount(inverse.reshape(-1), np.tile(units.join_length, 2)[leads])
        order = np.argsort(border, kind="stable")
        target = np.arange(count)
        # Of several writes to one place the last counts: the longest border.
        target[key[order] // count] = key[order] % count
        owner = label[units.unit]
        direction = measure_bend(units, label, count).direction[target]
        normal = units.topology.normal[units.rows]
        turned = largest_by(owner, angle_between(direction[owner], normal), count, 0.0)
        target = np.where(turned <= cone, target, np.arange(count))
        label, count = split_apart(units, np.where(wanted, target[label], -1))
    return label, count


def split_cones(units: Units, label: np.ndarray, count: int, cone: float):
    """Halve groups of several units until all fit in the cone. Returns labels and their number."""
    while True:
        wanted = label >= 0
        several = np.bincount(label[wanted], minlength=count) > 1
        over = (measure_bend(units, label, count).deviation > cone) & several
        if not over.any():
            return label, count
        members = np.flatnonzero(wanted)[over[label[wanted]]]
        label = halve(label, members, _spread_of_normals(units, label[members], members, count))
        label, count = split_apart(units, label)


def _spread_of_normals(units: Units, owner, members, count: int) -> np.ndarray:
    """Place of units' normals along the axis on which those of their group spread most. (m,)"""
    normal, weight = to_unit(units.normal[members]), units.area[members]
    total = sum_by(owner, weight, count)
    total = np.where(total > 0.0, total, 1.0)
    away = normal - (sum_by(owner, normal * weight[:, None], count) / total[:, None])[owner]
    products = (away[:, :, None] * away[:, None, :]).reshape(-1, 9) * weight[:, None]
    spread = sum_by(owner, products, count).reshape(-1, 3, 3) / total[:, None, None]
    axis = np.linalg.eigh(spread)[1][:, :, 2]
    return (away * axis[owner]).sum(axis=1)


def halve(label: np.ndarray, members: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Cut groups in the middle of their members' range; by number where the range is nothing. Labels need not be dense."""
    owner = label[members]
    count = int(owner.max()) + 1
    high = largest_by(owner, along, count, -np.inf)
    low = -largest_by(owner, -along, count, -np.inf)
    with np.errstate(invalid="ignore"):
        middle, is_flat = 0.5 * (high + low), high - low < 1e-6
    upper = along > middle[owner]
    order = np.argsort(owner, kind="stable")
    held = np.bincount(owner, minlength=count)
    rank = np.empty(len(owner), dtype=np.int64)
    rank[order] = np.arange(len(owner)) - np.repeat(np.cumsum(held) - held, held)
    upper = np.where(is_flat[owner], 2 * rank >= held[owner], upper)
    made = label * 2
    made[members] += upper
    return np.where(label >= 0, made, -1)


def project_groups(units: Units, label: np.ndarray, count: int, cone: float) -> Patches:
    """Project groups, cut those that overlap themselves in projection until none does.

    Parameters
    ----------
    units : Units
    label : (u,) int64 array    Groups, connected; -1: none.
    count : int
    cone : float    Polygons that are bent more are not projected but unfolded. [rad]
    """
    topology = units.topology
    chart = np.full(len(units.rows), -1, dtype=np.int64)
    uv = np.zeros((len(units.rows), 3, 2))
    made, turn = 0, 0
    over = measure_bend(narrow(units, label >= 0), label, count).deviation > cone
    stubborn = (label >= 0) & over[label] if count else label >= 0
    label, count = split_apart(units, np.where(stubborn, -1, label))
    while count:
        here = np.flatnonzero(label[units.unit] >= 0)
        part = narrow(units, label >= 0)
        owner = label[part.unit]
        bend = measure_bend(part, label, count)
        flat = project(part, label, bend)
        faulty = find_overlapping(flat, topology.vertex[part.rows], owner, count)
        good = ~faulty[owner]
        chart[here[good]] = made + owner[good]
        uv[here[good]] = flat[good]
        made += count
        label = np.where(label >= 0, np.where(faulty[label], label, -1), -1)
        held = np.bincount(label[label >= 0], minlength=count)
        single = (label >= 0) & (held[label] == 1)
        stubborn |= single
        label[single] = -1
        members = np.flatnonzero(label >= 0)
        if len(members) == 0:
            break
        along = _places_along(units, label[members], members, bend.direction, turn)
        label, count = split_apart(part, halve(label, members, along))
        # A part has a direction of its own, from which more may turn away.
        label, count = split_cones(narrow(units, label >= 0), label, count, cone)
        turn += 1
    unfolded = _unfold_units(units, stubborn)
    here = unfolded.chart >= 0
    chart[here] = made + unfolded.chart[here]
    uv[here] = unfolded.uv[here]
    return Patches(chart, uv, made + unfolded.count)


def _places_along(units: Units, owner, members, direction, turn: int) -> np.ndarray:
    """Place of units along their group's direction or, every other time, along the longer side across it. (m,)"""
    axes = find_axes(direction)[owner]
    place = np.einsum("ux,uax->ua", units.centre[members], axes)
    if turn % 2 == 0:
        return place[:, 2]
    spans = []
    for axis in range(2):
        high = largest_by(owner, place[:, axis], len(direction), -np.inf)
        low = -largest_by(owner, -place[:, axis], len(direction), -np.inf)
        spans.append((high - low)[owner])
    return np.where(spans[0] >= spans[1], place[:, 0], place[:, 1])


def _unfold_units(units: Units, wanted: np.ndarray) -> Patches:
    """Lay polygons flat triangle by triangle; those that overlap even so give each triangle a chart of its own."""
    chart = np.full(len(units.rows), -1, dtype=np.int64)
    uv = np.zeros((len(units.rows), 3, 2))
    here = np.flatnonzero(wanted[units.unit])
    if len(here) == 0:
        return Patches(chart, uv, 0)
    topology = units.topology
    rows = units.rows[here]
    owner = np.unique(units.unit[here], return_inverse=True)[1].reshape(-1)
    count = int(owner.max()) + 1
    vertex, corners = topology.vertex[rows], topology.corners[rows]
    span = int(vertex.max()) + 1
    keys, slot = np.unique((owner[:, None] * span + vertex).ravel(), return_inverse=True)
    slot = slot.reshape(-1, 3)
    known, place = np.zeros(len(keys), dtype=bool), np.zeros((len(keys), 2))
    shape = lay_out_of(corners)
    order = np.lexsort((-topology.area[rows], owner))
    largest = order[np.searchsorted(owner[order], np.arange(count))]
    place[slot[largest]] = shape[largest]
    known[slot[largest]] = True
    unfold(corners, slot, known, place)
    flat = place[slot]
    broken = find_overlapping(flat, vertex, owner, count)
    broken[owner[~known[slot].all(axis=1)]] = True
    apart = broken[owner]
    flat[apart] = shape[apart]
    number = np.where(apart, count + np.arange(len(rows)), owner)
    chart[here] = np.unique(number, return_inverse=True)[1].reshape(-1)
    uv[here] = flat
    return Patches(chart, uv, int(chart.max()) + 1)
