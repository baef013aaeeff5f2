"""Triangles for glTF: vertices that corners share, the turn to Y up, and whether a surface is a closed one."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Part:
    """Triangles that are drawn together.

    Parameters
    ----------
    indices : (3 t,) int64 array    Vertex of every corner.
    positions : (n, 3) float64 array    Y up. [m]
    normals : (n, 3) float32 array or None    Y up; None: flat.
    uv : (n, 2) float32 array or None    On the texture, v downwards.
    """

    indices: np.ndarray
    positions: np.ndarray
    normals: np.ndarray | None
    uv: np.ndarray | None


def turn_upright(vectors: np.ndarray) -> np.ndarray:
    """Turn vectors (..., 3) from Z up to Y up: x, y, z become x, z, -y."""
    return np.stack([vectors[..., 0], vectors[..., 2], -vectors[..., 1]], axis=-1)


def make_part(
    vertices: np.ndarray, triangles: np.ndarray, normals: np.ndarray | None, uv: np.ndarray | None
) -> Part:
    """Give corners one vertex where position, normal and texture coordinates are the same to the last bit.

    Parameters
    ----------
    vertices : (v, 3) float64 array    Y up. [m]
    triangles : (t, 3) int array
    normals : (t, 3, 3) float32 array or None    By corner, Y up.
    uv : (t, 3, 2) float32 array or None    By corner.
    """
    columns = [triangles.reshape(-1).astype(np.int64)]
    for values in (normals, uv):
        if values is not None:
            columns += _bit_columns(values.reshape(-1, values.shape[-1]).astype(np.float32))
    first, indices = weld(columns)
    return Part(
        indices,
        vertices[columns[0][first]],
        None if normals is None else normals.reshape(-1, 3)[first],
        None if uv is None else uv.reshape(-1, 2)[first],
    )


def weld(columns: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Find equal rows of a table of whole numbers.

    Parameters
    ----------
    columns : list of (n,) int64 arrays

    Returns
    -------
    (first, number)
        Place of the first row of every kind (k,), and the kind of every row (n,). Kinds are in ascending order.
    """
    _, first, number = np.unique(columns[0], return_index=True, return_inverse=True)
    for column in columns[1:]:
        # Ranks stay below the number of rows, so that a pair of them fits into 64 bits.
        ranks, rank = np.unique(column, return_inverse=True)
        _, first, number = np.unique(
            number * len(ranks) + rank, return_index=True, return_inverse=True
        )
    return first, number


def unit_normals(normals: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Bring shading normals to unit length; where there is none the triangle's own serves.

    Parameters
    ----------
    normals : (t, 3, 3) array    By corner.
    vertices : (v, 3) float64 array
    triangles : (t, 3) int array    None without area.

    Returns
    -------
    (t, 3, 3) float32 array
    """
    normals = np.asarray(normals, dtype=np.float64)
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    usable = np.isfinite(length) & (length > 1e-6)
    flat = np.cross(
        vertices[triangles[:, 1]] - vertices[triangles[:, 0]],
        vertices[triangles[:, 2]] - vertices[triangles[:, 0]],
    )
    flat /= np.maximum(np.linalg.norm(flat, axis=-1, keepdims=True), 1e-300)
    scaled = np.divide(normals, length, out=np.zeros_like(normals), where=usable)
    return np.where(usable, scaled, flat[:, None, :]).astype(np.float32)


def is_closed(vertices: np.ndarray, triangles: np.ndarray) -> bool:
    """Tell whether every edge has a triangle on either side, corners at the same place being one."""
    _, place = weld(_bit_columns(np.asarray(vertices, dtype=np.float64)))
    corners = place[triangles]
    starts = corners.reshape(-1)
    ends = np.roll(corners, -1, axis=1).reshape(-1)
    edges = np.minimum(starts, ends) * (len(vertices) + 1) + np.maximum(starts, ends)
    _, count = np.unique(edges[starts != ends], return_counts=True)
    return bool(count.size) and bool((count > 1).all())


def _bit_columns(values: np.ndarray) -> list[np.ndarray]:
    """Columns of floats (n, c) as whole numbers that are equal when the floats are; two of float32 share one."""
    # Minus zero is zero.
    values = np.ascontiguousarray(values + values.dtype.type(0.0))
    if values.dtype == np.float64:
        return [np.ascontiguousarray(values[:, i]).view(np.int64) for i in range(values.shape[1])]
    bits = [np.ascontiguousarray(values[:, i]).view(np.uint32) for i in range(values.shape[1])]
    bits = [column.astype(np.int64) for column in bits]
    pairs = [(bits[i] << 32) | bits[i + 1] for i in range(0, len(bits) - 1, 2)]
    return pairs + bits[2 * len(pairs) :]
