"""Where sensors stand: lines, rectangles, and grids over flat pieces of meshes, with the spacing of EN 12464-1.

Everything here is in the plane of the sensors: x and y in metres, (n, 2) or (t, 3, 2).
"""

import math

import numpy as np

from ..errors import SceneError

LARGEST_SPACING = 10.0
"""Of EN 12464-1. [m]"""

LONG = 2.0
"""Ratio of the sides of an area from which on the shorter one tells the spacing (EN 12464-1). [-]"""

MOST_SENSORS = 200_000
"""More are refused: a typing error of the spacing must not take hours."""

SAME = 1e-5
"""Corners that lie closer are one. [m]"""

BESIDE = 1e-4
"""How far beside an edge is looked whether the surface goes on there. [m]"""


def find_spacing(length: float) -> float:
    """Largest distance of points on an area of a relevant length: p = 0.2 * 5^log10(d), at most 10 m. [m]

    Parameters
    ----------
    length : float    See `relevant_length`. [m]

    References
    ----------
    EN 12464-1, illuminance grid.
    """
    return min(0.2 * 5.0 ** math.log10(length), LARGEST_SPACING)


def relevant_length(sides) -> float:
    """Longer side of an area, or the shorter one where it is at most half of it (EN 12464-1). [m]"""
    short, long = sorted(map(float, sides))
    return short if long >= LONG * short else long


def count_points(sides, spacing: float | None = None) -> tuple[int, int]:
    """How many points an area has along its sides.

    Parameters
    ----------
    sides : (float, float)    [m]
    spacing : float or None
        Distance wanted [m]; the counts are the nearest ones that fill the sides evenly. None: that of EN 12464-1, where the
        side that tells the spacing is filled first, and its spacing fills the other.

    Raises
    ------
    SceneError    There would be too many.
    """
    if spacing is None:
        length = relevant_length(sides)
        spacing = length / max(round(length / find_spacing(length)), 1)
    counts = tuple(max(round(side / spacing), 1) for side in sides)
    if counts[0] * counts[1] > MOST_SENSORS:
        raise SceneError(
            f"a grid of {spacing:.3g} m on {sides[0]:.4g} m by {sides[1]:.4g} m has {counts[0] * counts[1]} sensors, at "
            f"most {MOST_SENSORS} are laid; take a larger spacing"
        )
    return counts


def lay_line(length: float, spacing: float | None = None) -> np.ndarray:
    """Points in the middles of equal parts of a line along x about the origin. (n, 2) [m]"""
    count = count_points((length, length), spacing)[0]
    x = length * ((np.arange(count) + 0.5) / count - 0.5)
    return np.column_stack([x, np.zeros(count)])


def lay_rectangle(
    low, high, border: float = 0.0, spacing: float | None = None
) -> tuple[np.ndarray, tuple[int, int]]:
    """Points in the middles of equal cells of a rectangle, row by row along x.

    Parameters
    ----------
    low, high : (float, float)    Its corners. [m]
    border : float    Width of the strip along its sides that is left out. [m]
    spacing : float or None    As of `count_points`. [m]

    Returns
    -------
    points : (rows * columns, 2) array    [m]
    shape : (int, int)    Rows and columns.

    Raises
    ------
    SceneError    The border leaves nothing, or there would be too many.
    """
    low = np.asarray(low, dtype=np.float64) + border
    sides = np.asarray(high, dtype=np.float64) - border - low
    if not (sides > 0.0).all():
        raise SceneError(
            f"a border of {border:g} m leaves nothing of an area of {sides[0] + 2 * border:.4g} m by "
            f"{sides[1] + 2 * border:.4g} m"
        )
    columns, rows = count_points(sides, spacing)
    x = low[0] + sides[0] * (np.arange(columns) + 0.5) / columns
    y = low[1] + sides[1] * (np.arange(rows) + 0.5) / rows
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2), (rows, columns)


def lay_over(
    triangles: np.ndarray, border: float = 0.0, spacing: float | None = None
) -> tuple[np.ndarray, np.ndarray, tuple[int, int]]:
    """Points of a grid over the rectangle around triangles that lie on them, with a border along their outline left out.

    Parameters
    ----------
    triangles : (t, 3, 2) array    [m]
    border : float    [m]
    spacing : float or None    As of `count_points`. [m]

    Returns
    -------
    points : (n, 2) array    [m]
    cells : (n,) int array    Which cell of the rectangle each is, row by row.
    shape : (int, int)    Rows and columns of the rectangle.

    Raises
    ------
    SceneError    No point lies on them.
    """
    corners = triangles.reshape(-1, 2)
    points, shape = lay_rectangle(corners.min(axis=0), corners.max(axis=0), border, spacing)
    on = np.flatnonzero(find_within(points, triangles, border))
    if not len(on):
        raise SceneError(
            f"no sensor of the grid is {border:g} m within the surface; take a smaller spacing or border"
        )
    return points[on], on, shape


def find_within(points: np.ndarray, triangles: np.ndarray, border: float = 0.0) -> np.ndarray:
    """Whether points lie on any triangle, and a border away from where the surface ends [m]. (n,) bool"""
    inside = find_inside(points, triangles)
    if border > 0.0 and inside.any():
        away = _distance(points[inside], find_outline(triangles))
        inside[inside] = away >= border * (1.0 - 1e-6)
    return inside


def find_inside(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Whether points lie on any triangle, edges included. (n,) bool"""
    inside = np.zeros(len(points), dtype=bool)
    for a, b, c in triangles:
        u, v, away = b - a, c - a, points - a
        area = u[0] * v[1] - u[1] * v[0]
        if abs(area) < 1e-12:
            continue
        s = (away[:, 0] * v[1] - away[:, 1] * v[0]) / area
        t = (u[0] * away[:, 1] - u[1] * away[:, 0]) / area
        inside |= (s >= -1e-9) & (t >= -1e-9) & (s + t <= 1.0 + 1e-9)
    return inside


def find_outline(triangles: np.ndarray) -> np.ndarray:
    """Edges beside which the surface ends, on either side. (t, 3, 2) -> (e, 2, 2) [m]

    Faces that meet without sharing corners have edges on both, which are none of the outline.
    """
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    keys = np.round(edges / SAME).astype(np.int64)
    order = np.lexsort((keys[:, :, 1], keys[:, :, 0]), axis=1)
    keys = np.take_along_axis(keys, order[..., None], axis=1).reshape(-1, 4)
    # Upper and lower sides of a solid have the same outline.
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    side = np.sign(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).astype(np.int64)
    keys = np.column_stack([keys, np.tile(side, 3)])
    _, first, count = np.unique(keys, axis=0, return_index=True, return_counts=True)
    edges = _split(edges[first[count == 1]], np.unique(triangles.reshape(-1, 2), axis=0))
    along = edges[:, 1] - edges[:, 0]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    aside = BESIDE * np.column_stack([-along[:, 1], along[:, 0]]) / length
    middles = edges.mean(axis=1)
    ends = [~find_inside(middles + sign * aside, triangles) for sign in (1.0, -1.0)]
    return edges[ends[0] | ends[1]]


def _split(edges: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Edges split where other corners lie on them, those without a length left out. (e, 2, 2), (c, 2) -> (k, 2, 2)"""
    pieces = [np.zeros((0, 2, 2))]
    for a, b in edges:
        along = b - a
        length = np.hypot(*along)
        if length <= SAME:
            continue
        away = corners - a
        part = away @ along / length
        beside = np.abs(away[:, 0] * along[1] - away[:, 1] * along[0]) / length
        inner = part[(beside < SAME) & (part > SAME) & (part < length - SAME)]
        inner = SAME * np.unique(np.round(inner / SAME))
        places = a + np.concatenate([[0.0], inner, [length]])[:, None] * along / length
        pieces.append(np.stack([places[:-1], places[1:]], axis=1))
    return np.concatenate(pieces)


def _distance(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Distance of points from the nearest edge. (n, 2), (e, 2, 2) -> (n,) [m]"""
    nearest = np.full(len(points), np.inf)
    for a, b in edges:
        along = b - a
        part = np.clip((points - a) @ along / (along @ along), 0.0, 1.0)
        away = points - a - part[:, None] * along
        nearest = np.minimum(nearest, np.hypot(away[:, 0], away[:, 1]))
    return nearest


def find_heights(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Height of the uppermost triangle at points that lie on one. (n, 2), (t, 3, 3) -> (n,) [m]"""
    made = np.full(len(points), -np.inf)
    for triangle in corners:
        a, b, c = triangle
        u, v = b[:2] - a[:2], c[:2] - a[:2]
        area = u[0] * v[1] - u[1] * v[0]
        if abs(area) < 1e-12:
            continue
        away = points - a[:2]
        s = (away[:, 0] * v[1] - away[:, 1] * v[0]) / area
        t = (u[0] * away[:, 1] - u[1] * away[:, 0]) / area
        inside = (s >= -1e-9) & (t >= -1e-9) & (s + t <= 1.0 + 1e-9)
        height = a[2] + s * (b[2] - a[2]) + t * (c[2] - a[2])
        made = np.where(inside, np.maximum(made, height), made)
    return made
