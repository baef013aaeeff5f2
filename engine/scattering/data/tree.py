"""Tensor trees of scattering: evaluation, integrals and checks, in double precision.

References
----------
P. Shirley, K. Chiu: A Low Distortion Map Between Disk and Square, Journal of Graphics Tools 2(3), 1997.
G. Ward, M. Kurt, N. Bonneel: Reducing Anisotropic BSDF Measurement to Common Practice, Material Appearance Modeling 2014.
"""

from dataclasses import replace

import numpy as np

from ...errors import SceneError
from ...scene.scattering import TensorTree

MOST_LEVELS = 16
"""Halvings of every coordinate that a tree may have."""

FINEST_TRANSPOSE = 6
"""Halvings to which an isotropic tree is transposed."""

BELOW_HALF = 0.5 - 2.0**-24
"""Largest incident coordinate of an isotropic tree, of the normal; it belongs to the lower half."""

BELOW_ONE = 1.0 - 2.0**-24
"""Largest coordinate in the unit square."""


# ---- the disk and the square ----


def disk_of(u, v) -> tuple[np.ndarray, np.ndarray]:
    """Point of the unit disk for a point of the unit square; a square of the area a becomes a piece of the area pi a."""
    a, b = 2.0 * np.asarray(u, dtype=np.float64) - 1.0, 2.0 * np.asarray(v, dtype=np.float64) - 1.0
    wide = np.abs(a) > np.abs(b)
    radius = np.where(wide, a, b)
    ratio = np.where(wide, b, a) / np.where(radius == 0.0, 1.0, radius)
    near, far = radius * np.cos(0.25 * np.pi * ratio), radius * np.sin(0.25 * np.pi * ratio)
    return np.where(wide, near, far), np.where(wide, far, near)


def square_of(x, y) -> tuple[np.ndarray, np.ndarray]:
    """Point of the unit square, within [0, 1), for a point of the unit disk."""
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    wide = np.abs(x) > np.abs(y)
    radius = np.copysign(np.hypot(x, y), np.where(wide, x, y))
    main, other = np.where(wide, x, y), np.where(wide, y, x)
    side = radius * (4.0 / np.pi) * np.arctan(other / np.where(main == 0.0, 1.0, main))
    a, b = np.where(wide, radius, side), np.where(wide, side, radius)
    return tuple(np.clip(0.5 * (c + 1.0), 0.0, BELOW_ONE) for c in (a, b))


def _incident(rank: int, wi: np.ndarray) -> np.ndarray:
    """Incident coordinates. (n, rank - 2)"""
    if rank == 4:
        return np.stack(square_of(wi[:, 0], wi[:, 1]), axis=1)
    sine = np.hypot(wi[:, 0], wi[:, 1])
    return np.clip(0.5 - 0.5 * sine, 0.0, BELOW_HALF)[:, None]


def _coordinates(rank: int, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """All coordinates. (n, rank)"""
    x, y = wo[:, 0], wo[:, 1]
    if rank == 3:
        sine = np.hypot(wi[:, 0], wi[:, 1])
        safe = np.where(sine > 0.0, sine, 1.0)
        # Of light along the normal the azimuth is that of incidence in the xz-plane.
        c, s = np.where(sine > 0.0, -wi[:, 0] / safe, -1.0), -wi[:, 1] / safe
        x, y = c * x + s * y, c * y - s * x
    return np.concatenate([_incident(rank, wi), np.stack(square_of(x, y), axis=1)], axis=1)


# ---- values and integrals ----


def evaluate_tree(tree: TensorTree, wi, wo) -> np.ndarray:
    """Values for pairs of directions at the tree's wavelengths. (n, 3), (n, 3) -> (n, w) float64 [1/sr]"""
    wi, wo = np.asarray(wi, dtype=np.float64), np.asarray(wo, dtype=np.float64)
    place = _coordinates(tree.rank, wi, wo)
    bits = 1 << np.arange(tree.rank)
    found = np.zeros(len(wi), dtype=np.int64)
    while (inner := found >= 0).any():
        place *= 2.0
        upper = place >= 1.0
        place -= upper
        found = np.where(inner, tree.children[np.maximum(found, 0), upper @ bits], found)
    above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
    return np.where(above[:, None], tree.values[-1 - found].astype(np.float64), 0.0)


def albedos_of_tree(tree: TensorTree, wi) -> np.ndarray:
    """Share of light from directions that is scattered: integral of f cos, exactly. (n, 3) -> (n, w) float64 [-]"""
    place = _incident(tree.rank, np.asarray(wi, dtype=np.float64))
    known = tree.rank - 2
    bits, quarters = 1 << np.arange(known), np.arange(4) << known
    total = np.zeros((len(place), len(tree.wavelengths)))
    node, lane = np.zeros(len(place), dtype=np.int64), np.arange(len(place))
    area = np.pi
    while len(node):
        place = 2.0 * place
        upper = place >= 1.0
        place -= upper
        area *= 0.25
        child = tree.children[node[:, None], (upper @ bits)[:, None] + quarters].ravel()
        lane, place = np.repeat(lane, 4), np.repeat(place, 4, axis=0)
        leaf = child < 0
        np.add.at(total, lane[leaf], area * tree.values[-1 - child[leaf]].astype(np.float64))
        node, lane, place = child[~leaf], lane[~leaf], place[~leaf]
    return total


def albedo_of_tree(tree: TensorTree, incidence: float, rotation: float = 0.0) -> np.ndarray:
    """Share of light from one direction that is scattered: integral of f cos, exactly. (w,) float64 [-]"""
    sine = np.sin(incidence)
    wi = [[sine * np.cos(rotation), sine * np.sin(rotation), np.cos(incidence)]]
    return albedos_of_tree(tree, wi)[0]


# ---- shape ----


def levels_of(tree: TensorTree) -> list[np.ndarray]:
    """Numbers of the nodes of each level, the root's first: as many as the finest leaf halves a coordinate.

    Raises
    ------
    SceneError    There are more than `MOST_LEVELS`.
    """
    found = [np.zeros(1, dtype=np.int64)]
    while True:
        child = tree.children[found[-1]].ravel()
        inner = child[child >= 0]
        if not inner.size:
            return found
        if len(found) == MOST_LEVELS:
            raise SceneError(f"a scattering tree is deeper than {MOST_LEVELS} levels")
        found.append(inner.astype(np.int64))


def raster_of(tree: TensorTree, levels: int) -> np.ndarray:
    """Means of the values on a grid with ``2 ** levels`` cells along each coordinate. (cells,) * rank + (w,) float64"""
    cells = np.zeros((1,) * tree.rank, dtype=np.int64)
    for _ in range(levels):
        finer = np.empty([2 * n for n in cells.shape], dtype=np.int64)
        for child in range(1 << tree.rank):
            part = tuple(slice(child >> i & 1, None, 2) for i in range(tree.rank))
            finer[part] = np.where(cells >= 0, tree.children[np.maximum(cells, 0), child], cells)
        cells = finer
    return means_of(tree)[cells]


def means_of(tree: TensorTree) -> np.ndarray:
    """Mean values of nodes, and from the end those of leaves: indexed by what `TensorTree.children` holds. (m, w) float64"""
    values = np.concatenate(
        [np.zeros((len(tree.children), tree.values.shape[1])), tree.values[::-1]]
    )
    for nodes in reversed(levels_of(tree)):
        values[nodes] = values[tree.children[nodes]].mean(axis=1)
    return values


def grow_children(rank: int, levels: int) -> np.ndarray:
    """Children of a full tree, whose values are numbered as a grid's, the last coordinate fastest. (n, 2 ** rank) int32"""
    starts = np.cumsum([0, *((1 << rank * level) for level in range(levels))])
    rows = []
    for level in range(levels):
        place = np.indices((1 << level,) * rank).reshape(rank, 1, -1)
        bits = (np.arange(1 << rank) >> np.arange(rank)[:, None] & 1)[:, :, None]
        below = np.ravel_multi_index(tuple(2 * place + bits), (2 << level,) * rank).T
        rows.append(below + starts[level + 1] if level + 1 < levels else -1 - below)
    return np.concatenate(rows).astype(np.int32)


def mirrored_tree(tree: TensorTree, coordinates: int) -> TensorTree:
    """A tree with some coordinates turned round, c to 1 - c; ``coordinates`` has their bits set."""
    return replace(tree, children=tree.children[:, np.arange(1 << tree.rank) ^ coordinates])


def transposed_tree(tree: TensorTree) -> TensorTree:
    """What the tree tells of light on the way back: by reciprocity, transmission of the other side.

    Of rank 4 exactly. The leaves of an isotropic tree are none of another isotropic tree on the way back, so its values
    are means of 8 points in each cell of a grid, as fine as the tree and of `FINEST_TRANSPOSE` levels at most.
    """
    if tree.rank == 4:
        order = np.arange(16)
        return replace(tree, children=tree.children[:, order >> 2 | (order & 3) << 2])
    levels = min(len(levels_of(tree)), FINEST_TRANSPOSE)
    size = 1 << levels
    points = (np.arange(2 * size) + 0.5) / (2 * size)
    found = np.zeros((size, size, size, len(tree.wavelengths)))
    for cell in range(size // 2):
        into, u, v = (
            m.ravel()
            for m in np.meshgrid(points[2 * cell : 2 * cell + 2], points, points, indexing="ij")
        )
        x, y = disk_of(u, v)
        sine = 1.0 - 2.0 * into
        wi = np.stack([-sine, np.zeros_like(sine), np.sqrt(1.0 - sine**2)], axis=1)
        wo = np.stack([x, y, np.sqrt(np.maximum(1.0 - x * x - y * y, 1e-12))], axis=1)
        values = evaluate_tree(tree, wo, wi).reshape(2, size, 2, size, 2, -1)
        found[cell] = values.mean(axis=(0, 2, 4))
    values = found.reshape(-1, found.shape[-1]).astype(np.float32)
    return TensorTree(3, grow_children(3, levels), tree.wavelengths, values)


def check_tree(tree: TensorTree) -> None:
    """Refuse a tree that breaks its own rules.

    Raises
    ------
    SceneError    Says what is wrong with it.
    """
    if tree.rank not in {3, 4}:
        raise SceneError(f"a scattering tree has the rank {tree.rank}, expected 3 or 4")
    children, values, wavelengths = tree.children, tree.values, tree.wavelengths
    if children.ndim != 2 or not len(children) or children.shape[1] != 1 << tree.rank:
        raise SceneError(f"a scattering tree's nodes must have {1 << tree.rank} children each")
    if wavelengths.ndim != 1 or not wavelengths.size or not np.isfinite(wavelengths).all():
        raise SceneError("a scattering tree has no wavelength, or one that is no number")
    if np.any(np.diff(wavelengths) <= 0.0):
        raise SceneError("a scattering tree's wavelengths must ascend strictly")
    if values.ndim != 2 or values.shape[1] != len(wavelengths) or not len(values):
        raise SceneError("a scattering tree needs one value of every leaf at every wavelength")
    if not np.isfinite(values).all() or values.min() < 0.0:
        raise SceneError("a scattering tree has a value that is negative or no finite number")
    if children.max() >= len(children) or children.min() < -len(values):
        raise SceneError("a scattering tree names a node or a value that it does not have")
    parent = np.repeat(np.arange(len(children)), children.shape[1])
    inner = children.ravel() >= 0
    child = children.ravel()[inner]
    # Each node but the root hangs on one that comes before it, so there is no way round in circles.
    if np.any(child <= parent[inner]) or len(np.unique(child)) != len(child):
        raise SceneError("a scattering tree has a node that hangs on two others, or on a later one")
    levels_of(tree)
