"""Closed opaque solids without light inside: what is in them is dark for certain.

A solid is a connected group of an object's triangles whose edges all match (each is passed as often one way as the other),
that looks outwards, lets no light through anywhere and holds no light. Rooms that are modelled as boxes are none, whichever
way they look: they hold lights, or look inwards. Sheets, and bodies with gaps, are none either.
"""

from dataclasses import dataclass

import numpy as np

WELD = 2.0**-20
"""Corners nearer than about this are one, relative to the size of their object. [-]"""

FLATTEST = 1e-6
"""Smallest volume of a solid, relative to its area to the power 3/2: less is a folded sheet. [-]"""

NEARNESS = 0.01
"""Lights count as inside when they are this near, relative to the size of the solid: lamps often end flush with ceilings."""

MOST_ANGLES = 1 << 26
"""Solid angles that are worked out for one solid at most. Larger ones with more lights are taken to hold one."""


@dataclass(frozen=True)
class Soup:
    """Triangles of many objects.

    Parameters
    ----------
    corners : (t, 3, 3) float32 array    [m]
    owner : (t,) int array    Number of the object, ascending.
    opaque : (t,) bool array    Whether no light passes.
    lamps : (k, 3) array    Centres of the lights. [m]
    radii : (k,) array    Of spheres around them. [m]
    glowing : (t,) int8 array    Sides of the triangle that shine: 0, 1 (the front) or 2.
    """

    corners: np.ndarray
    owner: np.ndarray
    opaque: np.ndarray
    lamps: np.ndarray
    radii: np.ndarray
    glowing: np.ndarray


def find_solids(soup: Soup) -> np.ndarray:
    """Tell which triangles belong to solids. (t,) bool"""
    if len(soup.corners) == 0:
        return np.zeros(0, dtype=bool)
    vertices = _weld(soup)
    group, balance = _connect(vertices)
    count = int(group.max()) + 1
    centre = _means(group, soup.corners.mean(axis=1), count)
    local = soup.corners.astype(np.float64) - centre[group][:, None]
    volume = np.einsum("tx,tx->t", local[:, 0], np.cross(local[:, 1], local[:, 2])) / 6.0
    cross = np.cross(local[:, 1] - local[:, 0], local[:, 2] - local[:, 0])
    area = np.bincount(group, 0.5 * np.linalg.norm(cross, axis=1), count)
    is_solid = np.bincount(group, volume, count) > FLATTEST * area**1.5
    is_solid &= (np.bincount(group, balance, count) == 0) & (area > 0.0)
    is_solid &= np.bincount(group, ~soup.opaque, count) == 0
    points, reach = _lights(soup, group)
    if is_solid.any() and len(points):
        _leave_out_lit(is_solid, group, soup.corners, points, reach)
    return is_solid[group]


def _weld(soup: Soup) -> np.ndarray:
    """Numbers of the corners, alike for those of one object at one place. (t, 3)"""
    starts = np.flatnonzero(np.concatenate([[True], soup.owner[1:] != soup.owner[:-1]]))
    ordinal = np.cumsum(np.concatenate([[0], soup.owner[1:] != soup.owner[:-1]]))
    low = np.minimum.reduceat(soup.corners.min(axis=1), starts)
    high = np.maximum.reduceat(soup.corners.max(axis=1), starts)
    step = np.maximum((high - low).max(axis=1).astype(np.float64) * WELD, 1e-30)
    place = soup.corners.astype(np.float64) - low[ordinal][:, None]
    grid = np.round(place / step[ordinal][:, None, None]).astype(np.int64).reshape(-1, 3)
    packed = (grid[:, 0] << 42) | (grid[:, 1] << 21) | grid[:, 2]
    owner = np.repeat(ordinal, 3)
    order = np.lexsort((packed, owner))
    packed, owner = packed[order], owner[order]
    is_new = (packed[1:] != packed[:-1]) | (owner[1:] != owner[:-1])
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.concatenate([[0], np.cumsum(is_new)])
    return number.reshape(-1, 3)


def _connect(vertices: np.ndarray):
    """Groups of triangles (t, 3) that hang together by edges, and how many edges of each triangle are not matched."""
    start = vertices.reshape(-1)
    end = np.roll(vertices, -1, axis=1).reshape(-1)
    low, high = np.minimum(start, end), np.maximum(start, end)
    key = low * (int(vertices.max()) + 1) + high
    _, edge = np.unique(key, return_inverse=True)
    edge = edge.reshape(-1)
    # Edges of collapsed triangles go there and back, or nowhere.
    turns = np.bincount(edge, np.sign(end - start))
    open_edges = (turns[edge] != 0).reshape(-1, 3).sum(axis=1)
    label = np.arange(int(vertices.max()) + 1)
    while True:
        # Every vertex takes the least number that an edge leads to, and then that one's own, until none is left.
        least = np.minimum(label[low], label[high])
        if (label[low] == least).all() and (label[high] == least).all():
            break
        np.minimum.at(label, label[low], least)
        np.minimum.at(label, label[high], least)
        while True:
            shorter = label[label]
            if np.array_equal(shorter, label):
                break
            label = shorter
    _, group = np.unique(label[vertices[:, 0]], return_inverse=True)
    return group.reshape(-1), open_edges


def _means(group, values, count) -> np.ndarray:
    many = np.maximum(np.bincount(group, minlength=count), 1)
    return np.stack([np.bincount(group, column, count) / many for column in values.T], axis=1)


def _lights(soup: Soup, group: np.ndarray):
    """Points that light comes from, and how far around them it may. (k, 3), (k,) [m]"""
    points, reach = [soup.lamps.reshape(-1, 3)], [soup.radii]
    shining = np.flatnonzero(soup.glowing > 0)
    if len(shining):
        # One of every group tells where the group is.
        _, first = np.unique(group[shining], return_index=True)
        chosen = shining[first]
        corners = soup.corners[chosen].astype(np.float64)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        lift = normal / np.sqrt(length) * 1e-3
        centre = corners.mean(axis=1)
        both = soup.glowing[chosen] > 1
        points += [centre + lift, (centre - lift)[both]]
        reach.append(np.zeros(len(chosen) + int(both.sum())))
    return np.concatenate(points), np.concatenate(reach)


def _leave_out_lit(is_solid, group, corners, points, reach) -> None:
    """Take back that groups are solids which hold lights."""
    order = np.argsort(group, kind="stable")
    starts = np.searchsorted(group[order], np.arange(len(is_solid)))
    ends = np.append(starts[1:], len(order))
    low = np.minimum.reduceat(corners.min(axis=1)[order], starts)
    high = np.maximum.reduceat(corners.max(axis=1)[order], starts)
    for number in np.flatnonzero(is_solid):
        near = reach + NEARNESS * float((high[number] - low[number]).max())
        # A light whose sphere does not touch the solid's box is outside.
        gap = np.maximum(np.maximum(low[number] - points, points - high[number]), 0.0)
        inside = np.flatnonzero(np.einsum("kx,kx->k", gap, gap) <= near**2)
        if len(inside) == 0:
            continue
        own = corners[order[starts[number] : ends[number]]].astype(np.float64)
        is_solid[number] = not _holds_any(own, points[inside], near[inside])


def _holds_any(corners, points, near) -> bool:
    """Whether a closed surface holds one of some points, or one at a distance from them along the axes."""
    steps = np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])
    sought = (points[:, None] + near[:, None, None] * steps).reshape(-1, 3)
    if len(sought) * len(corners) > MOST_ANGLES:
        return True
    many = max((1 << 20) // len(corners), 1)
    return any(
        (_winding(corners, sought[begin : begin + many]) > 0.5).any()
        for begin in range(0, len(sought), many)
    )


def _winding(corners, points) -> np.ndarray:
    """How often a closed surface goes round points, from the solid angles of its triangles.

    References
    ----------
    A. van Oosterom, J. Strackee: The solid angle of a plane triangle, IEEE Trans. Biomed. Eng. 30 (1983).
    """
    a, b, c = (corners[None, :, i] - points[:, None] for i in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=-1) for side in (a, b, c))
    volume = np.einsum("ptx,ptx->pt", a, np.cross(b, c))
    beside = la * lb * lc
    for p, q, other in ((a, b, lc), (b, c, la), (c, a, lb)):
        beside += np.einsum("ptx,ptx->pt", p, q) * other
    return np.arctan2(volume, beside).sum(axis=1) / (2.0 * np.pi)
