"""Texels of a picture that lies on charts: to which place of which triangle each belongs."""

from dataclasses import dataclass, field

import numpy as np

from . import coverage

NEIGHBOURS = tuple((x, y) for y in (-1, 0, 1) for x in (-1, 0, 1) if x or y)
"""Steps from a texel to those around it."""


@dataclass(frozen=True, eq=False)
class Texels:
    """Texels that a look-up on the charts may read, and where their middles lie on the surface.

    Parameters
    ----------
    width, height : int    Of the picture.
    index : (n,) int64 array    Ascending, by rows from the bottom.
    triangle : (n,) int32 array
    weights : (n, 3) float32 array    Of the triangle's corners; of a middle beside its triangle those of the nearest point.
    """

    width: int
    height: int
    index: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray
    _kept: dict = field(default_factory=dict)

    def __len__(self) -> int:
        """Number of texels."""
        return len(self.index)

    def interpolate(self, corners: np.ndarray) -> np.ndarray:
        """Return at every texel what the corners of triangles have, (t, 3, c) to (n, c) float32."""
        made = np.zeros((len(self), corners.shape[2]), np.float32)
        for corner in range(3):
            made += corners[self.triangle, corner] * self.weights[:, corner, None]
        return made

    def keep(self, name, make) -> np.ndarray:
        """Return ``make()``, made once under its name, as an array that cannot be written to."""
        if name not in self._kept:
            made = make()
            made.flags.writeable = False
            self._kept[name] = made
        return self._kept[name]

    def lay(self, values: np.ndarray) -> np.ndarray:
        """Return the picture with values (n, c), and with their mean where no look-up reads. (height, width, c) float32"""
        mean = values.mean(axis=0, dtype=np.float64).astype(np.float32)
        picture = np.empty((self.height * self.width, values.shape[1]), np.float32)
        picture[:] = mean
        picture[self.index] = values
        return picture.reshape(self.height, self.width, -1)

    def neighbours(self) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of texels beside and above each other, as places in the list. (k,), (k,)"""
        first, second = [], []
        column = self.index % self.width
        for step, has_next in ((1, column < self.width - 1), (self.width, True)):
            place = np.searchsorted(self.index, self.index + step)
            place = np.minimum(place, len(self) - 1)
            found = np.flatnonzero((self.index[place] == self.index + step) & has_next)
            first.append(found)
            second.append(place[found])
        return np.concatenate(first), np.concatenate(second)


def find_texels(uv: np.ndarray, width: int, height: int) -> Texels:
    """Find the texels of charts.

    A look-up mixes the four texels around a place: the one that holds it, which the surface covers, and three of those
    around that. So these are all covered texels and a rim of one about them.

    Parameters
    ----------
    uv : (t, 3, 2) float64 array    Corners of the triangles on the picture, v upwards; charts lie two texels apart. [texel]
    width, height : int    Of the picture.
    """
    spans = coverage.find_spans(coverage.snap(uv), width, 0, height)
    lengths = (spans.end - spans.begin).astype(np.int64)
    triangle = np.repeat(spans.triangle, lengths)
    start = spans.row.astype(np.int64) * width + spans.begin
    before = np.cumsum(lengths) - lengths
    index = np.arange(lengths.sum()) - np.repeat(before - start, lengths)
    index, triangle = _nearest(uv, width, index, triangle)
    index, triangle = _with_rim(uv, width, height, index, triangle)
    weights = _places(uv[triangle], _middles(index, width))[0]
    return Texels(width, height, index, triangle, weights.astype(np.float32))


def _middles(index: np.ndarray, width: int) -> np.ndarray:
    return np.stack([index % width, index // width], axis=1) + 0.5


def _nearest(uv, width: int, index, triangle):
    """Keep of all pairs the nearest triangle of every texel; the first of those that are as near."""
    distance = _places(uv[triangle], _middles(index, width))[1]
    order = np.lexsort((triangle, distance, index))
    index, triangle = index[order], triangle[order]
    is_first = np.concatenate([[True], index[1:] != index[:-1]]) if len(index) else slice(0)
    return index[is_first], triangle[is_first]


def _with_rim(uv, width: int, height: int, index, triangle):
    """Add the texels around, each with the triangle of a texel beside it."""
    owner = np.full(width * height, -1, np.int32)
    owner[index] = triangle
    column, row = index % width, index // width
    more, theirs = [], []
    for x, y in NEIGHBOURS:
        inside = (column + x >= 0) & (column + x < width) & (row + y >= 0) & (row + y < height)
        places = index[inside] + y * width + x
        free = owner[places] < 0
        more.append(places[free])
        theirs.append(triangle[inside][free])
    more, theirs = _nearest(uv, width, np.concatenate(more), np.concatenate(theirs))
    index, triangle = np.concatenate([index, more]), np.concatenate([triangle, theirs])
    order = np.argsort(index)
    return index[order], triangle[order]


def _places(corners: np.ndarray, points: np.ndarray):
    """Weights of corners (k, 3, 2) at the places of their triangles nearest to points (k, 2), and how far those are."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    whole = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        second = _cross(points - a, c - a) / whole
        third = _cross(b - a, points - a) / whole
    weights = np.stack([1.0 - second - third, second, third], axis=1)
    distance = np.zeros(len(points))
    outside = np.flatnonzero(~((weights >= 0.0).all(axis=1) & np.isfinite(weights).all(axis=1)))
    if len(outside) == 0:
        return weights, distance
    own, at = corners[outside], points[outside]
    best = np.full(len(outside), np.inf)
    made = np.zeros((len(outside), 3))
    for first in range(3):
        last = (first + 1) % 3
        start, along = own[:, first], own[:, last] - own[:, first]
        length = np.maximum((along**2).sum(axis=1), 1e-300)
        share = np.clip(((at - start) * along).sum(axis=1) / length, 0.0, 1.0)
        far = ((start + share[:, None] * along - at) ** 2).sum(axis=1)
        nearer = far < best
        best[nearer] = far[nearer]
        made[nearer] = 0.0
        made[nearer, first], made[nearer, last] = 1.0 - share[nearer], share[nearer]
    weights[outside], distance[outside] = made, best
    return weights, distance


def _cross(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
