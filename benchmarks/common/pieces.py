"""Meshes put together of plain pieces: quads, boxes, grids, polygons."""

import numpy as np

from ...engine.scene.mesh import Mesh

_BOX_CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)

_BOX_FACES = np.array(
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
)
"""Corners of the faces, anticlockwise from outside: bottom, top, -y, +y, -x, +x."""

SIDES = ("bottom", "top", "-y", "+y", "-x", "+x")

Piece = tuple[np.ndarray, np.ndarray]
"""Vertices (v, 3) [m] and triangles (t, 3)."""


def quad(corner, u, v) -> Piece:
    """Parallelogram whose front is where u x v points."""
    corner, u, v = (np.asarray(each, dtype=np.float64) for each in (corner, u, v))
    return np.stack([corner, corner + u, corner + u + v, corner + v]), _fan(4)


def grid(corner, u, v, columns: int, rows: int, without=()) -> Piece:
    """Parallelogram of so many quadrilaterals, some left out by (column, row), with common vertices."""
    corner, u, v = (np.asarray(each, dtype=np.float64) for each in (corner, u, v))
    s, t = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    vertices = corner + s.reshape(-1, 1) * u + t.reshape(-1, 1) * v
    row, column = np.divmod(np.arange(columns * rows), columns)
    kept = np.ones(columns * rows, dtype=bool)
    for left_out in without:
        kept[left_out[1] * columns + left_out[0]] = False
    first = (row * (columns + 1) + column)[kept]
    above = first + columns + 1
    halves = ([first, first + 1, above + 1], [first, above + 1, above])
    return vertices, np.concatenate([np.stack(half, axis=1) for half in halves])


def box(low, high, inwards: bool = False) -> Piece:
    """Box with its faces outwards, or inwards as a room's."""
    low, high = (np.asarray(each, dtype=np.float64) for each in (low, high))
    return _box(low, high, range(6), inwards)


def side_of_box(low, high, side: str, inwards: bool = True) -> Piece:
    """One face of a box; ``side`` is one of `SIDES`."""
    low, high = (np.asarray(each, dtype=np.float64) for each in (low, high))
    return _box(low, high, [SIDES.index(side)], inwards)


def _box(low, high, faces, inwards: bool) -> Piece:
    corners = low + _BOX_CORNERS * (high - low)
    rows = _BOX_FACES[list(faces)]
    if inwards:
        rows = rows[:, ::-1]
    vertices = corners[rows].reshape(-1, 3)
    triangles = (4 * np.arange(len(rows))[:, None, None] + _fan(4)).reshape(-1, 3)
    return vertices, triangles


def polygon(corners) -> Piece:
    """Flat convex polygon (n, 3), anticlockwise from its front."""
    corners = np.asarray(corners, dtype=np.float64)
    return corners, _fan(len(corners))


def _fan(count: int) -> np.ndarray:
    last = np.arange(2, count)
    return np.stack([np.zeros_like(last), last - 1, last], axis=1)


def make_mesh(key: str, pieces: list[Piece], material: str, corner_normals=None) -> Mesh:
    """Put pieces together as one object of one material; its id is its name."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in pieces)])
    triangles = np.concatenate(
        [triangles + start for (_, triangles), start in zip(pieces, starts, strict=False)]
    ).astype(np.int32)
    return Mesh(
        id=key,
        name=key,
        vertices=np.concatenate([vertices for vertices, _ in pieces]),
        triangles=triangles,
        materials=(material,),
        material_index=np.zeros(len(triangles), dtype=np.int32),
        corner_normals=corner_normals,
    )


def rigid_frame(place, towards) -> np.ndarray:
    """Frame (4, 4) at a place whose -z points somewhere and whose x lies along that of the world as far as it can."""
    z = -np.asarray(towards, dtype=np.float64)
    z /= np.linalg.norm(z)
    x = np.array([1.0, 0.0, 0.0]) - z * z[0]
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    frame[:3, 3] = place
    return frame
