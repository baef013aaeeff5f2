"""Seams: edges of smooth surfaces where two charts meet, and lumels moved within their noise until both sides agree there.

What is seen on either side of a seam is interpolated from lumels that were computed apart, so it differs by their noise, and
by what interpolation makes of it where the rim of a chart had to be filled. Both are mended by least squares: the
interpolated values are made to agree along the edge, and lumels move as little as possible for it, measured in their own
standard errors. Filled pixels move freely, computed ones by no more than a few standard errors, so that a step that the
surface really has stays.

References
----------
M. Iwanicki: Lighting technology of The Last of Us, SIGGRAPH (2013), seams of light maps as a least-squares problem.
"""

from dataclasses import dataclass

import numpy as np

from ..scene.mesh import Mesh
from .layout import SurfaceLayout

ANGLE = np.radians(5.0)
"""Largest angle between normals on both sides of an edge of a smooth surface. [rad]"""

WELD = 2.0**-20
"""Corners nearer than about this are one, relative to the size of the mesh. [-]"""

FIRMNESS = 0.1
"""Steps that are left, in standard errors of the step: what agreement is weighed by against moving lumels. [-]"""

FREEDOM = 10.0
"""Standard errors of filled pixels are taken to be so many times those that they were filled with, at least. [-]"""

LIMIT = 2.0
"""How far computed lumels may move, in their standard errors."""

GUESS = 4.0
"""How far filled pixels may move, in what their error is taken to be."""

ROUNDS = 4
"""How often lumels that would move too far are held at their limit and the rest solved anew."""

STEPS, TOLERANCE = 400, 1e-6
"""Of the conjugate gradients: most steps, and residual relative to the first."""


@dataclass(frozen=True)
class SeamPairs:
    """Places on seams, with what they are interpolated from on both sides.

    Parameters
    ----------
    page : (m, 2) int32 array
    chart : (m, 2) int32 array
    index : (m, 2, 4) int64 array    Flat pixel indices on the page.
    weight : (m, 2, 4) float64 array    Sum 1 on each side. [-]
    """

    page: np.ndarray
    chart: np.ndarray
    index: np.ndarray
    weight: np.ndarray

    def __len__(self) -> int:
        """How many places."""
        return len(self.page)

    def choose(self, rows) -> "SeamPairs":
        """Some of them."""
        return SeamPairs(self.page[rows], self.chart[rows], self.index[rows], self.weight[rows])


@dataclass(frozen=True)
class SeamSteps:
    """How well charts meet.

    Parameters
    ----------
    pairs : int    Places that were compared.
    before, after : float    Root mean square of the steps, before and after they were matched. [lx]
    noise : float    Root mean square of the steps' standard errors. [lx]
    """

    pairs: int
    before: float
    after: float
    noise: float


def join_pairs(parts) -> SeamPairs:
    """Put the seams of several meshes into one list."""
    parts = [part for part in parts if len(part)]
    if not parts:
        return _no_pairs()
    return SeamPairs(
        *(np.concatenate([getattr(p, n) for p in parts]) for n in SeamPairs.__annotations__)
    )


def find_seams(
    mesh: Mesh, layout: SurfaceLayout, sizes: np.ndarray, angle: float = ANGLE
) -> SeamPairs:
    """Find places along the edges that two charts of a smooth surface share, about one for each lumel.

    Edges with more than two triangles are left out: which two of them go on smoothly is not known.

    Parameters
    ----------
    mesh : Mesh
    layout : SurfaceLayout
    sizes : (p, 2) int array    Width and height of the pages. [lumel]
    angle : float    Largest angle between the shading normals on both sides, at both ends. [rad]
    """
    used = np.flatnonzero((layout.page >= 0) & (layout.chart >= 0))
    if len(used) == 0:
        return _no_pairs()
    first, second = _shared_edges(_weld(mesh)[used])
    # An edge is a triangle and the corner it starts at; ``used`` counts triangles anew.
    sides = [(used[edge // 3], edge % 3) for edge in (first, second)]
    apart = layout.chart[sides[0][0]] != layout.chart[sides[1][0]]
    sides = [(triangle[apart], corner[apart]) for triangle, corner in sides]
    normals = [_end_normals(mesh, *side) for side in sides]
    # The second triangle passes the edge the other way.
    cosines = np.einsum("kex,kex->ke", normals[0], normals[1][:, ::-1])
    smooth = (cosines >= np.cos(angle)).all(axis=1)
    sides = [(triangle[smooth], corner[smooth]) for triangle, corner in sides]
    ends = [
        np.stack([layout.uv[t, c], layout.uv[t, (c + 1) % 3]], axis=1).astype(np.float64)
        for t, c in sides
    ]
    ends[1] = ends[1][:, ::-1]
    lengths = np.max([np.linalg.norm(e[:, 1] - e[:, 0], axis=1) for e in ends], axis=0)
    count = np.maximum(np.ceil(lengths - 1e-6), 1).astype(np.int64)
    edge = np.repeat(np.arange(len(count)), count)
    number = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    share = ((number + 0.5) / count[edge])[:, None]
    page, chart, index, weight = [], [], [], []
    for (triangle, _), end in zip(sides, ends, strict=True):
        here = triangle[edge]
        page.append(layout.page[here])
        chart.append(layout.chart[here])
        places = end[edge, 0] * (1.0 - share) + end[edge, 1] * share
        made = _footprints(places, np.asarray(sizes)[layout.page[here]])
        index.append(made[0])
        weight.append(made[1])
    return SeamPairs(
        np.stack(page, axis=1).astype(np.int32),
        np.stack(chart, axis=1).astype(np.int32),
        np.stack(index, axis=1),
        np.stack(weight, axis=1),
    )


def usable_pairs(pairs: SeamPairs, owners) -> SeamPairs:
    """Keep the places whose pixels all have values of the right chart. ``owners``: (h, w) charts by page, see `gutters`."""
    kept = np.zeros(len(pairs), dtype=bool)
    found = _read(pairs, owners)
    kept[:] = ((found == pairs.chart[..., None]) | (pairs.weight == 0.0)).all(axis=(1, 2))
    return pairs.choose(kept)


def measure_steps(pairs: SeamPairs, values, errors):
    """Differences across seams.

    Parameters
    ----------
    pairs : SeamPairs
    values, errors : sequences of (h, w) arrays    By page, filled. [lx]

    Returns
    -------
    steps, errors : (m,) float64 arrays    Differences, and their standard errors. [lx]
    """
    value = (_read(pairs, values) * pairs.weight).sum(axis=2)
    variance = ((_read(pairs, errors) * pairs.weight) ** 2).sum(axis=(1, 2))
    return value[:, 0] - value[:, 1], np.sqrt(variance)


def match_seams(values, errors, computed, pairs: SeamPairs):
    """Make charts agree where they meet.

    Parameters
    ----------
    values, errors : sequences of (h, w) arrays    Filled values and standard errors, by page. [lx]
    computed : sequence of (h, w) bool arrays    Lumels that were computed, by page; all others were filled.
    pairs : SeamPairs    As `usable_pairs` leaves them.

    Returns
    -------
    changes : list of (index, change)    By page: flat pixel indices (k,) and what is to be added (k,). [lx]
    steps : SeamSteps
    """
    changes = [(np.zeros(0, dtype=np.int64), np.zeros(0)) for _ in values]
    if len(pairs) == 0:
        return changes, SeamSteps(0, 0.0, 0.0, 0.0)
    system = _System(values, errors, computed, pairs)
    change = system.solve()
    after = system.steps + system.apply(change)
    for page in np.unique(system.page):
        mine = (system.page == page) & (change != 0.0)
        changes[page] = (system.pixel[mine], change[mine])
    noise = _root_mean_square(system.step_errors)
    steps = SeamSteps(len(pairs), _root_mean_square(system.steps), _root_mean_square(after), noise)
    return changes, steps


class _System:
    """Least squares over the pixels that seams are interpolated from.

    The sum of ((step after) / (FIRMNESS * error of the step))^2 and ((change) / (error of the pixel))^2 is made smallest.
    """

    def __init__(self, values, errors, computed, pairs: SeamPairs):
        key = (pairs.page[..., None].astype(np.int64) << 40) | pairs.index
        unique, number = np.unique(key, return_inverse=True)
        self.page, self.pixel = (unique >> 40).astype(np.int64), unique & ((1 << 40) - 1)
        self._column = number.reshape(len(pairs), 8)
        self._weight = (pairs.weight * np.array([1.0, -1.0])[:, None]).reshape(len(pairs), 8)
        self.steps, self.step_errors = measure_steps(pairs, values, errors)
        error, value = np.zeros(len(unique)), np.zeros(len(unique))
        held = np.zeros(len(unique), dtype=bool)
        for page in np.unique(self.page):
            mine = self.page == page
            error[mine] = errors[page].reshape(-1)[self.pixel[mine]]
            value[mine] = values[page].reshape(-1)[self.pixel[mine]]
            held[mine] = computed[page].reshape(-1)[self.pixel[mine]]
        # What was filled is a guess, and as uncertain as the steps are large even where there is no noise.
        size = max(_root_mean_square(self.steps), 1e-30)
        guess = np.maximum(FREEDOM * error, size)
        self._limit = np.where(held, LIMIT * error, GUESS * guess)
        self._lowest = -np.maximum(value, 0.0)
        self._inertia = 1.0 / np.maximum(np.where(held, error, guess), 1e-6 * size) ** 2
        self._firm = 1.0 / np.maximum(FIRMNESS * self.step_errors, 1e-2 * size) ** 2

    def apply(self, change: np.ndarray) -> np.ndarray:
        """What changes of the pixels add to the steps."""
        return (change[self._column] * self._weight).sum(axis=1)

    def _transpose(self, steps: np.ndarray) -> np.ndarray:
        spread = (steps[:, None] * self._weight).reshape(-1)
        return np.bincount(self._column.reshape(-1), spread, len(self.pixel))

    def solve(self) -> np.ndarray:
        """Changes of the pixels; those at their limit are held there while the others go on."""
        change = np.zeros(len(self.pixel))
        fixed = self._limit == 0.0
        for _ in range(ROUNDS):
            change = self._minimise(change, ~fixed)
            beyond = ~fixed & ((np.abs(change) > self._limit) | (change < self._lowest))
            # No light is less than none.
            change = np.maximum(np.clip(change, -self._limit, self._limit), self._lowest)
            if not beyond.any():
                break
            fixed |= beyond
        return change

    def _minimise(self, change: np.ndarray, free: np.ndarray) -> np.ndarray:
        """Best changes of the free pixels, by conjugate gradients with the diagonal as preconditioner."""
        diagonal = self._inertia + np.bincount(
            self._column.reshape(-1),
            (self._weight**2 * self._firm[:, None]).reshape(-1),
            len(self.pixel),
        )
        residual = -self._transpose(self._firm * (self.steps + self.apply(change)))
        residual = np.where(free, residual - self._inertia * change, 0.0)
        scaled = residual / diagonal
        direction, size = scaled.copy(), float(residual @ scaled)
        goal = size * TOLERANCE**2
        change = change.copy()
        for _ in range(STEPS):
            if size <= goal or size == 0.0:
                break
            image = self._transpose(self._firm * self.apply(direction))
            image = np.where(free, image + self._inertia * direction, 0.0)
            length = size / float(direction @ image)
            change += length * direction
            residual -= length * image
            scaled = residual / diagonal
            size, last = float(residual @ scaled), size
            direction = scaled + size / last * direction
        return change


def _root_mean_square(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def _no_pairs() -> SeamPairs:
    return SeamPairs(
        np.zeros((0, 2), dtype=np.int32),
        np.zeros((0, 2), dtype=np.int32),
        np.zeros((0, 2, 4), dtype=np.int64),
        np.zeros((0, 2, 4)),
    )


def _read(pairs: SeamPairs, pages) -> np.ndarray:
    """Pixels that places are interpolated from. (m, 2, 4)"""
    made = np.zeros(pairs.index.shape, dtype=np.float64)
    for page in np.unique(pairs.page):
        mine = pairs.page == page
        made[mine] = np.asarray(pages[page]).reshape(-1)[pairs.index[mine]]
    return made


def _weld(mesh: Mesh) -> np.ndarray:
    """Numbers of the corners, alike at one place. (t, 3)"""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    step = max(float((high - low).max()) * WELD, 1e-30)
    grid = np.round((mesh.vertices - low) / step).astype(np.int64)
    packed = (grid[:, 0] << 42) | (grid[:, 1] << 21) | grid[:, 2]
    _, number = np.unique(packed, return_inverse=True)
    return number.reshape(-1)[mesh.triangles]


def _shared_edges(vertices: np.ndarray):
    """Edges that exactly two triangles pass, in opposite ways: positions in the flat list of corners, (k,), (k,)."""
    start = vertices.reshape(-1)
    end = np.roll(vertices, -1, axis=1).reshape(-1)
    real = np.flatnonzero(start != end)
    low, high = np.minimum(start, end)[real], np.maximum(start, end)[real]
    key = low.astype(np.int64) * (int(vertices.max()) + 1) + high
    order = np.argsort(key, kind="stable")
    key, edge = key[order], real[order]
    is_new = np.concatenate([[True], key[1:] != key[:-1]])
    begin = np.flatnonzero(is_new)
    count = np.diff(np.append(begin, len(key)))
    pairs = begin[count == 2]
    first, second = edge[pairs], edge[pairs + 1]
    opposite = start[first] == end[second]
    return first[opposite], second[opposite]


def _end_normals(mesh: Mesh, triangle, corner) -> np.ndarray:
    """Shading normals at both ends of edges. (k, 2, 3)"""
    if mesh.corner_normals is not None:
        ends = np.stack([corner, (corner + 1) % 3], axis=1)
        made = mesh.corner_normals[triangle[:, None], ends].astype(np.float64)
    else:
        points = mesh.vertices[mesh.triangles[triangle]]
        flat = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
        made = np.repeat(flat[:, None], 2, axis=1)
    return made / np.maximum(np.linalg.norm(made, axis=2, keepdims=True), 1e-300)


def _footprints(places: np.ndarray, sizes: np.ndarray):
    """Pixels and weights that bilinear interpolation takes at places (k, 2) [lumel]. (k, 4), (k, 4)"""
    lowest = np.floor(places - 0.5)
    part = places - 0.5 - lowest
    index, weight = [], []
    for dy in (0, 1):
        for dx in (0, 1):
            x = np.clip(lowest[:, 0] + dx, 0, sizes[:, 0] - 1).astype(np.int64)
            y = np.clip(lowest[:, 1] + dy, 0, sizes[:, 1] - 1).astype(np.int64)
            index.append(y * sizes[:, 0].astype(np.int64) + x)
            weight.append(np.abs(1 - dx - part[:, 0]) * np.abs(1 - dy - part[:, 1]))
    return np.stack(index, axis=1), np.stack(weight, axis=1)
