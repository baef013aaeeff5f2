"""Outlines of charts: their border edges, whether they overlap themselves, their smallest rectangle.

A connected chart in which every triangle lies the right way round and no corner is gone round twice covers every place once
if, and only if, its border never crosses itself. So the borders decide, which are few beside the triangles.
"""

from dataclasses import dataclass

import numpy as np

from .topology import largest_by, sum_by

TOLERANCE = 1e-5
"""Overlaps narrower than this share of the chart's size do not count."""

TURN = 0.61
"""By which charts are turned for the search, so that no straight side lies along a column. [rad]"""

PLACES = (0.06, 0.5, 0.94)
"""Where along a border edge the sheets over a place just inside are counted."""

RAGGED = 256
"""Pairs of edges per border edge beyond which a border counts as too ragged to be tested, and so as overlapping."""

CHUNK = 1 << 22
"""Pairs looked at in one go."""

LONGEST_EDGES = 8
"""How many of a chart's border edges are tried as a side of its rectangle."""

ANGLES = 15
"""How many other directions are tried, evenly over a quarter turn."""


@dataclass(frozen=True)
class Border:
    """Border edges of charts, sorted by chart, with the inside on their left.

    Parameters
    ----------
    chart : (b,) int64 array
    start, end : (b, 2) float64 array    [m]
    """

    chart: np.ndarray
    start: np.ndarray
    end: np.ndarray


def find_borders(uv: np.ndarray, vertex: np.ndarray, chart: np.ndarray):
    """Find the border edges of charts.

    Parameters
    ----------
    uv : (t, 3, 2) float64 array
    vertex : (t, 3) int64 array    Places on the surface; equal ones of one chart must have equal ``uv``.
    chart : (t,) int64 array    None negative.

    Returns
    -------
    Border, node (t, 3) int64 array numbering the places of every chart, and charts (k,) of directed edges that two triangles
    share, which therefore lie upon each other
    """
    span = int(vertex.max(initial=0)) + 1
    _, node = np.unique((chart[:, None] * span + vertex).ravel(), return_inverse=True)
    node = node.reshape(-1, 3)
    start, end = node.ravel(), np.roll(node, -1, axis=1).ravel()
    owner = np.repeat(chart, 3)
    rows = np.flatnonzero(start != end)
    count = int(node.max(initial=0)) + 1
    key = start[rows] * count + end[rows]
    order = np.argsort(key, kind="stable")
    key, rows = key[order], rows[order]
    doubled = owner[rows[1:][key[1:] == key[:-1]]]
    reverse = end[rows] * count + start[rows]
    found = np.searchsorted(key, reverse)
    is_border = key[np.minimum(found, len(key) - 1)] != reverse if len(key) else np.zeros(0, bool)
    rows = rows[is_border]
    rows = rows[np.argsort(owner[rows], kind="stable")]
    flat = uv.reshape(-1, 2)
    following = np.roll(uv, -1, axis=1).reshape(-1, 2)
    return Border(owner[rows], flat[rows], following[rows]), node, doubled


def find_overlapping(
    uv: np.ndarray, vertex: np.ndarray, chart: np.ndarray, count: int
) -> np.ndarray:
    """Tell which charts have triangles that lie the wrong way round or upon each other.

    Parameters
    ----------
    uv, vertex, chart    As in `find_borders`; charts must be connected over edges.
    count : int    Charts.

    Returns
    -------
    (count,) bool array
    """
    faulty = np.zeros(count, dtype=bool)
    if len(uv) == 0:
        return faulty
    size = _sizes(uv, chart, count)
    edges = np.roll(uv, -1, axis=1) - uv
    double = _cross(edges[:, 0], edges[:, 1])
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    least = TOLERANCE * size[chart] * longest
    faulty[chart[double < -least]] = True

    border, node, doubled = find_borders(uv, vertex, chart)
    faulty[doubled] = True

    wide = double > least
    before = np.roll(edges[wide], 1, axis=1)
    angle = np.arctan2(_cross(before, edges[wide]), (before * edges[wide]).sum(axis=2))
    around = np.bincount(node[wide].ravel(), (np.pi - angle).ravel())
    over = around[node[wide]].max(axis=1, initial=0.0) > 2.0 * np.pi + 0.01
    faulty[chart[wide][over]] = True

    single = np.bincount(chart, minlength=count) <= 1
    wanted = ~(faulty | single)[border.chart]
    border = Border(border.chart[wanted], border.start[wanted], border.end[wanted])
    return faulty | _find_crossed(border, size, count)


def _sizes(uv, chart, count) -> np.ndarray:
    """Diagonals of the charts' bounds. (count,)"""
    extents = []
    for axis in range(2):
        high = largest_by(chart, uv[:, :, axis].max(axis=1), count, -np.inf)
        low = -largest_by(chart, -uv[:, :, axis].min(axis=1), count, -np.inf)
        extents.append(np.where(np.isfinite(high), high - low, 0.0))
    return np.hypot(*extents)


def _cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


class _Columns:
    """Border edges listed by the columns that they pass; every chart has as many columns as border edges.

    ``ragged`` tells the charts in which too many edges share columns; they are left out of all pairs.
    """

    def __init__(self, border: Border, count: int):
        turn = np.array([[np.cos(TURN), np.sin(TURN)], [-np.sin(TURN), np.cos(TURN)]])
        self.chart = border.chart
        self.start, self.end = border.start @ turn, border.end @ turn
        left = np.minimum(self.start[:, 0], self.end[:, 0])
        right = np.maximum(self.start[:, 0], self.end[:, 0])
        self._begin = -largest_by(self.chart, -left, count, -np.inf)
        width = largest_by(self.chart, right, count, -np.inf) - self._begin
        self._edges = np.bincount(self.chart, minlength=count)
        self._offset = np.cumsum(self._edges) - self._edges
        self._scale = np.where(width > 0.0, self._edges / np.where(width > 0.0, width, 1.0), 0.0)

        first, last = self.column_of(left, self.chart), self.column_of(right, self.chart)
        entry, step = _expand(last - first + 1)
        column = first[entry] + step
        order = np.argsort(column, kind="stable")
        self.entry, self.column = entry[order], column[order]
        self._held = np.bincount(column, minlength=len(self.chart))
        self._head = np.cumsum(self._held) - self._held
        self.rank = np.arange(len(entry)) - self._head[self.column]
        work = np.bincount(self.chart[self.entry], self._held[self.column], minlength=count)
        self.ragged = work > RAGGED * np.maximum(self._edges, 64)

    def column_of(self, x: np.ndarray, chart: np.ndarray) -> np.ndarray:
        """Number of the column of places in charts."""
        inside = np.clip((x - self._begin[chart]) * self._scale[chart], 0, self._edges[chart] - 1)
        return self._offset[chart] + inside.astype(np.int64)

    def pairs(self, chart: np.ndarray, column: np.ndarray, skip: np.ndarray):
        """Pair things in columns with the columns' edges from the ``skip``-th on; yields (thing, edge) some at a time."""
        counts = np.where(self.ragged[chart], 0, self._held[column] - skip)
        ends = np.cumsum(counts)
        position = 0
        while position < len(counts):
            done = ends[position - 1] if position else 0
            stop = max(int(np.searchsorted(ends, done + CHUNK)), position + 1)
            part = np.arange(position, stop)
            local, step = _expand(counts[part])
            which = part[local]
            yield which, self.entry[self._head[column[which]] + skip[which] + step]
            position = stop


def _find_crossed(border: Border, size: np.ndarray, count: int) -> np.ndarray:
    """Charts whose border crosses itself, or has places just inside over which two sheets lie."""
    if len(border.chart) == 0:
        return np.zeros(count, dtype=bool)
    columns = _Columns(border, count)
    crossed = columns.ragged.copy()
    chart, start, end = columns.chart, columns.start, columns.end
    tolerance = TOLERANCE * size[chart]
    owner = chart[columns.entry]
    for which, other in columns.pairs(owner, columns.column, columns.rank + 1):
        one = columns.entry[which]
        meet = _pass(start[one], end[one], start[other], end[other], tolerance[one])
        meet &= _pass(start[other], end[other], start[one], end[one], tolerance[one])
        crossed[chart[one[meet]]] = True

    along = end - start
    length = np.hypot(along[:, 0], along[:, 1])
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(length, 1e-300)[:, None]
    for place in PLACES:
        point = start + place * along + 2.0 * tolerance[:, None] * inward
        sheets = np.zeros(len(point))
        column = columns.column_of(point[:, 0], chart)
        for which, other in columns.pairs(chart, column, np.zeros(len(point), dtype=np.int64)):
            above = _above(point[which], start[other], end[other])
            sheets += np.bincount(which, above, minlength=len(point))
        # Beside shorter edges the place would lie beyond their own triangle.
        crossed[chart[(sheets > 1.5) & (length > 8.0 * tolerance)]] = True
    return crossed


def _expand(counts: np.ndarray):
    """Number and running count of things that are repeated so many times."""
    which = np.repeat(np.arange(len(counts)), counts)
    return which, np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)


def _pass(start, end, one, other, limit) -> np.ndarray:
    """Whether edges have places on both sides of them, each farther from their lines than a limit."""
    along = end - start
    length = np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-300)
    a = _cross(along, one - start) / length
    b = _cross(along, other - start) / length
    return (a * b < 0.0) & (np.minimum(np.abs(a), np.abs(b)) > limit)


def _above(point, start, end) -> np.ndarray:
    """1 for edges that pass above points leftwards, -1 rightwards, 0 for others; their sum counts the sheets."""
    x = point[:, 0]
    leftwards = (end[:, 0] <= x) & (x < start[:, 0])
    rightwards = (start[:, 0] <= x) & (x < end[:, 0])
    run = end[:, 0] - start[:, 0]
    share = (x - start[:, 0]) / np.where(run == 0.0, 1.0, run)
    height = start[:, 1] + share * (end[:, 1] - start[:, 1])
    return np.where(height > point[:, 1], leftwards.astype(float) - rightwards, 0.0)


def find_rectangles(border: Border, count: int) -> np.ndarray:
    """Angles of the sides of (nearly) the smallest rectangles round charts.

    The smallest has a side along the border's hull; the longest border edges and some even angles are tried.

    Returns
    -------
    (count,) float64 array    Direction of the long side. [rad]
    """
    best = np.zeros(count)
    smallest = np.full(count, np.inf)
    wide = np.ones(count, dtype=bool)
    if len(border.chart) == 0:
        return best
    along = border.end - border.start
    direction = np.arctan2(along[:, 1], along[:, 0])
    length = np.round(np.hypot(along[:, 0], along[:, 1]), 9)
    order = np.lexsort((-length, border.chart))
    owners, head, held = np.unique(border.chart, return_index=True, return_counts=True)
    points = border.start
    for number in range(LONGEST_EDGES + ANGLES):
        if number < LONGEST_EDGES:
            angle = direction[order[head + np.minimum(number, held - 1)]]
            gain = 1.0 - 1e-9
        else:
            angle = np.full(len(owners), (number - LONGEST_EDGES + 0.5) * 0.5 * np.pi / ANGLES)
            gain = 0.98
        turned = np.repeat(angle, held)
        cos, sin = np.cos(turned), np.sin(turned)
        x = points[:, 0] * cos + points[:, 1] * sin
        y = points[:, 1] * cos - points[:, 0] * sin
        run = np.maximum.reduceat(x, head) - np.minimum.reduceat(x, head)
        rise = np.maximum.reduceat(y, head) - np.minimum.reduceat(y, head)
        better = run * rise < gain * smallest[owners]
        chosen = owners[better]
        best[chosen] = angle[better]
        smallest[chosen] = (run * rise)[better]
        # Equal sides must not leave it to rounding which of them lies flat.
        wide[chosen] = (run >= rise * (1.0 - 1e-9))[better]
    return np.where(wide, best, best + 0.5 * np.pi)


def mean_stretch(shape: np.ndarray, uv: np.ndarray, weight, chart, count: int) -> np.ndarray:
    """Mean over charts of J J^T, J from the surface to the chart: 1 where a chart is true to scale. (count, 2, 2)

    Parameters
    ----------
    shape : (t, 3, 2) float64 array    Triangles laid flat each by itself, their first edges along x.
    uv : (t, 3, 2) float64 array
    weight : (t,) float64 array    0 leaves a triangle out.
    """
    rows = np.flatnonzero(weight > 0.0)
    run, (shift, rise) = shape[rows, 1, 0], shape[rows, 2].T
    along = (uv[rows, 1] - uv[rows, 0]) / run[:, None]
    away = (uv[rows, 2] - uv[rows, 0] - along * shift[:, None]) / rise[:, None]
    xx, xy, yy = (
        along[:, i] * along[:, j] + away[:, i] * away[:, j] for i, j in ((0, 0), (0, 1), (1, 1))
    )
    product = np.stack([xx, xy, xy, yy], axis=1)
    total = sum_by(chart[rows], weight[rows], count)
    mean = sum_by(chart[rows], product * weight[rows, None], count)
    mean = mean / np.where(total > 0.0, total, 1.0)[:, None]
    mean[total <= 0.0] = (1.0, 0.0, 0.0, 1.0)
    return mean.reshape(-1, 2, 2)
