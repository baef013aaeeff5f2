"""Which lumels triangles cover: every lumel that a triangle overlaps with positive area, and the exact size of the overlap.

Triangles are cut into rows of lumels first. What a convex figure overlaps in a row is an interval, so the work follows the
number of lumels that are covered and not the boxes around triangles, which for long oblique slivers are mostly empty.
"""

from dataclasses import dataclass

import numpy as np

SNAP = 2.0**-12
"""Corners nearer than this to a border of lumels are taken to lie on it, since charts often end there up to rounding and
would else spill into lumels where they have no area to speak of. [lumel]"""

GRAZE = 1e-9
"""Overlap in width that is rounding. [lumel]"""

CHUNK = 1 << 19
"""Rows of triangles, or pairs of triangle and lumel, that are worked on at once."""


@dataclass(frozen=True)
class Spans:
    """What triangles overlap in rows of lumels: (k,) each, columns from ``begin`` to before ``end``."""

    triangle: np.ndarray
    row: np.ndarray
    begin: np.ndarray
    end: np.ndarray


def snap(corners: np.ndarray) -> np.ndarray:
    """Put corners on borders of lumels that they nearly lie on; triangles without area become a point.

    Parameters
    ----------
    corners : (t, 3, 2) float64 array    [lumel]
    """
    nearest = np.round(corners)
    snapped = np.where(np.abs(corners - nearest) < SNAP, nearest, corners)
    is_lost = flat_areas(snapped) <= 0.0
    snapped[is_lost] = corners[is_lost]
    is_point = ~(flat_areas(snapped) > 0.0)
    snapped[is_point] = corners[is_point].mean(axis=1, keepdims=True)
    return snapped


def flat_areas(corners: np.ndarray) -> np.ndarray:
    """Areas of triangles (t, 3, 2) in the plane, (t,)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    return 0.5 * np.abs(_cross(b - a, c - a))


def find_spans(corners: np.ndarray, width: int, low: int, high: int) -> Spans:
    """Cut triangles into the rows from ``low`` to before ``high`` of a page.

    Parameters
    ----------
    corners : (t, 3, 2) float64 array    As `snap` leaves them. A triangle that is a point counts for the lumel it is in.
    width : int    Of the page. [lumel]
    """
    bottom, top = corners[..., 1].min(axis=1), corners[..., 1].max(axis=1)
    first = np.floor(bottom).astype(np.int64)
    last = np.maximum(np.ceil(top).astype(np.int64), first + 1)
    first, last = np.clip(first, low, high), np.clip(last, low, high)
    ends = np.cumsum(last - first)
    found = []
    for begin, end in chunks(ends):
        rows = last[begin:end] - first[begin:end]
        triangle = np.repeat(np.arange(begin, end), rows)
        row = np.arange(len(triangle)) - np.repeat(np.cumsum(rows) - rows - first[begin:end], rows)
        left, right = _reach(corners[triangle], row.astype(np.float64))
        start = np.floor(left + GRAZE).astype(np.int64)
        stop = np.maximum(np.ceil(right - GRAZE).astype(np.int64), start + 1)
        start, stop = np.clip(start, 0, width), np.clip(stop, 0, width)
        kept = stop > start
        found.append([part[kept].astype(np.int32) for part in (triangle, row, start, stop)])
    if not found:
        return Spans(*(np.zeros(0, dtype=np.int32) for _ in range(4)))
    return Spans(*(np.concatenate(parts) for parts in zip(*found, strict=True)))


def chunks(ends: np.ndarray):
    """Yield ranges of entries that have about `CHUNK` rows each, by the running sums of their rows."""
    begin, total = 0, int(ends[-1]) if len(ends) else 0
    done = 0
    while done < total:
        end = max(int(np.searchsorted(ends, done + CHUNK, side="right")), begin + 1)
        yield begin, end
        begin, done = end, int(ends[end - 1])


def _reach(corners: np.ndarray, row: np.ndarray):
    """Leftmost and rightmost place of triangles (k, 3, 2) within the row from ``row`` to ``row`` + 1. (k,), (k,)"""
    left, right = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for i in range(3):
        xa, ya = corners[:, i].T
        xb, yb = corners[:, (i + 1) % 3].T
        rise = yb - ya
        with np.errstate(divide="ignore", invalid="ignore"):
            s, t = (row - ya) / rise, (row + 1.0 - ya) / rise
        level = rise == 0.0
        s, t = (
            np.where(level, 0.0, np.clip(s, 0.0, 1.0)),
            np.where(level, 1.0, np.clip(t, 0.0, 1.0)),
        )
        present = (np.maximum(ya, yb) >= row) & (np.minimum(ya, yb) <= row + 1.0)
        for part in (s, t):
            # Whole corners are kept as they are, so that rounding moves none of them.
            x = np.where(part == 1.0, xb, xa + part * (xb - xa))
            left = np.minimum(left, np.where(present, x, np.inf))
            right = np.maximum(right, np.where(present, x, -np.inf))
    return left, right


def merge_spans(spans: Spans, width: int):
    """Unite spans.

    Returns
    -------
    start, length : (m,) int64 arrays    Runs of covered lumels, by flat index on the page, ascending and apart.
    """
    start = spans.row.astype(np.int64) * width + spans.begin
    end = spans.row.astype(np.int64) * width + spans.end
    order = np.argsort(start, kind="stable")
    start, end = start[order], end[order]
    if len(start) == 0:
        return start, end
    reached = np.maximum.accumulate(end)
    is_first = np.concatenate([[True], start[1:] > reached[:-1]])
    begin = start[is_first]
    is_last = np.concatenate([is_first[1:], [True]])
    return begin, reached[is_last] - begin


def overlaps(corners: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Areas that triangles share with lumels.

    For every edge the area of the lumel to its left, as far as the edge reaches; round the triangle they add up to it.

    Parameters
    ----------
    corners : (k, 3, 2) float64 array    [lumel]
    x, y : (k,) arrays    Lower left corners of the lumels. [lumel]
    """
    total = np.zeros(len(x))
    for i in range(3):
        xa, ya = corners[:, i, 0] - x, corners[:, i, 1] - y
        xb, yb = corners[:, (i + 1) % 3, 0] - x, corners[:, (i + 1) % 3, 1] - y
        low, high = np.clip(ya, 0.0, 1.0), np.clip(yb, 0.0, 1.0)
        rise = yb - ya
        slope = (xb - xa) / np.where(rise == 0.0, 1.0, rise)
        total += (high - low) * _mean_clamped(xa + (low - ya) * slope, xb + (high - yb) * slope)
    return np.abs(total)


def _mean_clamped(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Mean of clip(x, 0, 1) for x between a and b."""
    low, high = np.minimum(a, b), np.maximum(a, b)
    length = np.maximum(high - low, 1e-200)
    beyond = np.clip((high - 1.0) / length, 0.0, 1.0)
    before = np.clip(-low / length, 0.0, 1.0)
    between = np.maximum(1.0 - beyond - before, 0.0)
    return beyond + between * 0.5 * (np.clip(low, 0.0, 1.0) + np.clip(high, 0.0, 1.0))


def holds(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether triangles hold points, up to rounding: (k, 3, 2) and (k, n, 2) give (k, n)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    turn = np.sign(_cross(b - a, c - a))[:, None]
    inside = np.ones(points.shape[:2], dtype=bool)
    for p, q in ((a, b), (b, c), (c, a)):
        edge = q - p
        height = edge[:, None, 0] * (points[..., 1] - p[:, None, 1])
        height -= edge[:, None, 1] * (points[..., 0] - p[:, None, 0])
        slack = 1e-9 * (np.abs(edge).sum(axis=1) + 1e-9)
        inside &= height * turn >= -slack[:, None]
    return inside


def inner_points(corners: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A point inside what triangles share with lumels: the mean of the corners of the shared figure.

    Parameters
    ----------
    corners : (k, 3, 2) float64 array    [lumel]
    x, y : (k,) arrays    Lower left corners of lumels that the triangles overlap. [lumel]
    """
    cell = np.stack([x, y], axis=1).astype(np.float64)
    local = corners - cell[:, None]
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    square = np.broadcast_to(square, (len(x), 4, 2))
    points, known = [local, square], [_in_square(local), holds(local, square)]
    for i in range(3):
        a, b = local[:, i], local[:, (i + 1) % 3]
        for axis in (0, 1):
            for side in (0.0, 1.0):
                length = b[:, axis] - a[:, axis]
                with np.errstate(divide="ignore", invalid="ignore"):
                    t = (side - a[:, axis]) / length
                crosses = (t >= 0.0) & (t <= 1.0)
                met = a + np.where(crosses, t, 0.0)[:, None] * (b - a)
                met[:, axis] = np.where(crosses, side, met[:, axis])
                points.append(met[:, None])
                known.append((crosses & _in_square(met))[:, None])
    points, known = np.concatenate(points, axis=1), np.concatenate(known, axis=1)
    count = known.sum(axis=1)
    mean = (points * known[..., None]).sum(axis=1) / np.maximum(count, 1)[:, None]
    # Rounding may deny all corners of a figure as thin as rounding; the triangle's own point nearest to the lumel's.
    lost = np.clip(local.mean(axis=1), 0.0, 1.0)
    return np.where(count[:, None] > 0, mean, lost) + cell


def _in_square(points: np.ndarray) -> np.ndarray:
    return ((points >= -1e-9) & (points <= 1.0 + 1e-9)).all(axis=-1)


def barycentric(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Coordinates of points (k, 2) in triangles (k, 3, 2), none below 0, their sum 1. (k, 3)"""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    whole = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        v = _cross(points - a, c - a) / whole
        w = _cross(b - a, points - a) / whole
    made = np.stack([1.0 - v - w, v, w], axis=1)
    made = np.clip(np.where(np.isfinite(made), made, 1.0 / 3.0), 0.0, 1.0)
    return made / made.sum(axis=1, keepdims=True)


def _cross(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
