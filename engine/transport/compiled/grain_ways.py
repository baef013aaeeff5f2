"""What leads from a place on an object to the direction that goes round one of its axes there.

With the frame M of an object from its own coordinates to the world, the middle m and the halves s of the sides of its box,
a place has the coordinates g = (M^-1 (p - M m)) / (2 s) about the middle, and the direction round the axis k is e_k x g. It
is brought to the world as normals are, M^-T (e_k x g), which is linear in the place.
"""

import numpy as np

from ...scene.mesh import Mesh

ROUND = np.cross(np.eye(3)[:, None], np.eye(3)[None]).transpose(0, 2, 1)
"""Matrices of e_k x, by axis. (3, 3, 3)"""


def find_ways(size: int, parts, origin: np.ndarray) -> np.ndarray:
    """Return A and m of `materials.grain` by number of shape and axis. (size, 3, 4, 3)

    Parameters
    ----------
    size : int    Of the table.
    parts : list of (Body, Part)
    origin : (3,) array    Of the compiled scene's frame. [m]
    """
    ways = np.zeros((size, 3, 4, 3))
    for body, part in parts:
        ways[part.number] = _ways_of(body.item, body.geometry, origin)
    return ways


def find_coordinates(size: int, parts, origin: np.ndarray) -> np.ndarray:
    """Return what leads from places to those of their objects, in true lengths however an object is stretched.

    Parameters
    ----------
    size : int    Of the table.
    parts : list of (Body, Part)
    origin : (3,) array    Of the compiled scene's frame. [m]

    Returns
    -------
    (size, 4, 3) array    By number of shape: the rows of a turn R and the place m, of p -> R (p - m).
    """
    made = np.zeros((size, 4, 3))
    made[:, :3] = np.eye(3)
    for body, part in parts:
        if isinstance(body.item, Mesh):
            made[part.number, 3] = -origin
            continue
        frame = np.asarray(body.item.frame, np.float64)
        # The turn that is nearest to what the frame does.
        left, _, right = np.linalg.svd(frame[:3, :3])
        made[part.number, :3] = (left @ right).T
        made[part.number, 3] = frame[:3, 3] - origin
    return made


def _ways_of(item, geometry, origin) -> np.ndarray:
    if isinstance(item, Mesh):
        frame, box, vertices = np.eye(4), None, item.vertices
    else:
        frame, box, vertices = np.asarray(item.frame, np.float64), geometry.box, geometry.vertices
    if box is None:
        ends = np.stack([vertices.min(axis=0), vertices.max(axis=0)]).astype(np.float64)
        box = np.stack([0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])])
    inner = np.linalg.pinv(frame[:3, :3])
    halves = np.where(np.asarray(box[1]) != 0.0, box[1], 1.0)
    matrices = inner.T @ ROUND @ (inner / halves[:, None])
    matrices /= np.maximum(np.linalg.norm(matrices, axis=(1, 2), keepdims=True), 1e-300)
    middle = frame[:3, :3] @ box[0] + frame[:3, 3] - origin
    return np.concatenate([matrices, np.broadcast_to(middle, (3, 1, 3))], axis=1)
