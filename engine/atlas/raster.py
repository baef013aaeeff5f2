"""Lumels and places of triangles between two rows of a page.

Coverage is conservative: a lumel counts as soon as the surface overlaps it with some area. Its places are points of a small
low-discrepancy net that lie on the surface; where the surface is so thin that it meets none, a point of the overlap is.
"""

import numpy as np

from . import coverage

SAME_STEPS = 1e-4
"""Difference of steps on the surface, relative to them, up to which two triangles are one plane with one layout. [-]"""

WHOLE = 1e-6
"""Part of a lumel that may be missing where it counts as covered whole. [-]"""


def _agree(steps: np.ndarray, triangle: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Whether pairs of triangles have the same steps (t, 2, 3) on the surface, and these are known. (k,) bool"""
    agree = np.isfinite(steps[triangle]).all(axis=(1, 2))
    pairs = np.flatnonzero(agree & (triangle != other))
    a, b = steps[triangle[pairs]], steps[other[pairs]]
    agree[pairs] = np.abs(a - b).max(axis=(1, 2)) <= SAME_STEPS * np.abs(b).max(axis=(1, 2))
    return agree


class Raster:
    """Lumels and places of triangles between two rows of a page.

    Parameters
    ----------
    corners : (t, 3, 2) float64 array    As `coverage.snap` leaves them. [lumel]
    areas : (t,) array    On the surface. [m2]
    charts : (t,) array
    width : int    Of the page.
    low, high : int    Rows from ``low`` to before ``high``.
    boxes : Boxes    Around the points where places are looked for in a lumel.
    steps : (t, 2, 3) array    On the surface for one lumel to the right and one upwards, NaN where they are not known. [m]
    """

    def __init__(self, corners, areas, charts, width, low, high, boxes, steps):
        self._corners, self._width, self._steps = corners, width, steps
        self._boxes, self._pattern = boxes, boxes.points
        spans = coverage.find_spans(corners, width, low, high)
        runs, lengths = coverage.merge_spans(spans, width)
        self._runs, self._before = runs, np.cumsum(lengths) - lengths
        self.index = np.repeat(runs - self._before, lengths) + np.arange(lengths.sum())
        flat = coverage.flat_areas(corners)
        self._scale = areas / np.where(flat > 0.0, flat, 1.0)
        self._is_point = flat <= 0.0
        self.area = np.zeros(len(self.index))
        self.chart = np.full(len(self.index), -1, dtype=np.int32)
        parts = list(self._pairs(spans))
        self._choose_charts(charts, parts)
        owner = np.full(len(self.index) * len(self._pattern), -1, dtype=np.int32)
        is_box = np.zeros(len(owner), dtype=bool)
        own = [
            tuple(column[charts[part[0]] == self.chart[part[1]]] for column in part)
            for part in parts
        ]
        for part in own:
            self._place(owner, is_box, *part)
        self._join_planes(owner, is_box, own)
        self._finish(owner, is_box, charts, parts)

    def _pairs(self, spans):
        """Yield triangles, lumels and shared areas on the page, in pieces; adds up the areas on the surface."""
        counts = (spans.end - spans.begin).astype(np.int64)
        ends = np.cumsum(counts)
        for begin, end in coverage.chunks(ends):
            many = counts[begin:end]
            span = np.repeat(np.arange(begin, end), many)
            column = np.arange(len(span)) - np.repeat(np.cumsum(many) - many, many)
            column += spans.begin[span]
            triangle = spans.triangle[span]
            flat = spans.row[span].astype(np.int64) * self._width + column
            run = np.searchsorted(self._runs, flat, side="right") - 1
            lumel = (self._before[run] + flat - self._runs[run]).astype(np.int32)
            share = coverage.overlaps(self._corners[triangle], *self._cells(lumel))
            share[self._is_point[triangle]] = 1.0
            self.area += np.bincount(
                lumel, weights=share * self._scale[triangle], minlength=len(self.index)
            )
            yield triangle, lumel, share

    def _cells(self, lumel):
        """Column and row of lumels."""
        row, column = np.divmod(self.index[lumel], self._width)
        return column, row

    def _choose_charts(self, charts, parts) -> None:
        """Give every lumel to the chart with the largest part of it; charts that are kept apart never share one."""
        for triangle, lumel, _ in parts:
            self.chart[lumel] = charts[triangle]
        shared = np.zeros(len(self.index), dtype=bool)
        for triangle, lumel, _ in parts:
            shared[lumel[self.chart[lumel] != charts[triangle]]] = True
        if not shared.any():
            return
        rows = [
            (lumel[mine], charts[triangle[mine]], (share * self._scale[triangle])[mine])
            for triangle, lumel, share in parts
            for mine in (shared[lumel],)
        ]
        lumel, chart, area = (np.concatenate(column) for column in zip(*rows, strict=True))
        order = np.lexsort((chart, lumel))
        lumel, chart, area = lumel[order], chart[order], area[order]
        start = np.flatnonzero(
            np.concatenate([[True], (lumel[1:] != lumel[:-1]) | (chart[1:] != chart[:-1])])
        )
        lumel, chart, area = lumel[start], chart[start], np.add.reduceat(area, start)
        order = np.lexsort((-chart, area, lumel))
        # The last of a lumel's entries stays: the largest area, and of equal ones the lowest number.
        self.chart[lumel[order]] = chart[order]

    def _place(self, owner, is_box, triangle, lumel, share) -> None:
        """Note which triangle holds which points of the pattern, and whether it holds all of the boxes around them."""
        count = len(self._pattern)
        points = np.arange(count)
        whole = share >= 1.0 - 1e-12
        whole &= ~self._is_point[triangle]
        owner.reshape(-1, count)[lumel[whole]] = triangle[whole, None]
        is_box.reshape(-1, count)[lumel[whole]] = True
        ends = self._boxes.corners[:, None] + self._boxes.size * np.array(
            [[0, 0], [1, 0], [0, 1], [1, 1]]
        )
        ends = np.clip(ends, *self._boxes.ends)
        rest = np.flatnonzero(~whole & ~self._is_point[triangle])
        for begin in range(0, len(rest), coverage.CHUNK // count):
            part = rest[begin : begin + coverage.CHUNK // count]
            cells = np.stack(self._cells(lumel[part]), axis=1)
            local = self._corners[triangle[part]] - cells[:, None]
            sought = np.broadcast_to(self._pattern, (len(part), count, 2))
            row, point = np.nonzero(coverage.holds(local, sought))
            place = lumel[part][row].astype(np.int64) * count + points[point]
            owner[place] = triangle[part][row]
            is_box[place] = coverage.holds(local[row], ends[point]).all(axis=1)

    def _join_planes(self, owner, is_box, own) -> None:
        """Note whose boxes are whole because all of the lumel is one plane, however it is divided."""
        # The triangle of the first place, by which the lumel is looked at.
        table = owner.reshape(len(self.index), -1)
        at = (table >= 0).argmax(axis=1)
        self.first = np.maximum(table[np.arange(len(table)), at], 0)
        covered = np.zeros(len(self.index))
        for triangle, lumel, share in own:
            agree = _agree(self._steps, triangle, self.first[lumel])
            covered += np.bincount(lumel[agree], share[agree], len(covered))
        is_box.reshape(len(covered), -1)[covered >= 1.0 - WHOLE] = True

    def _finish(self, owner, is_box, charts, parts) -> None:
        """Lay the places out lumel by lumel."""
        count = len(self._pattern)
        found = np.flatnonzero(owner >= 0)
        lumel, triangle = found // count, owner[found]
        points = np.stack(self._cells(lumel), axis=1) + self._pattern[found % count]
        is_box = is_box[found] & _agree(self._steps, triangle, self.first[lumel])
        box = np.where(is_box, found % count + 1, 0).astype(np.uint8)
        empty = np.ones(len(self.index), dtype=bool)
        empty[lumel] = False
        if empty.any():
            more = self._thin(empty, charts, parts)
            lumel, triangle = np.concatenate([lumel, more[0]]), np.concatenate([triangle, more[1]])
            points = np.concatenate([points, more[2]])
            box = np.concatenate([box, np.zeros(len(more[0]), dtype=np.uint8)])
            order = np.argsort(lumel, kind="stable")
            lumel, triangle, points, box = (e[order] for e in (lumel, triangle, points, box))
        self.triangle, self.box = triangle, box
        self.bary = coverage.barycentric(self._corners[triangle], points)
        self.count = np.bincount(lumel, minlength=len(self.index))
        self.start = np.cumsum(self.count) - self.count
        self.first = self.triangle[self.start]

    def _thin(self, empty, charts, parts):
        """One place for each lumel that meets no point of the pattern: inside its largest overlap."""
        rows = [
            (lumel[mine], triangle[mine], (share * self._scale[triangle])[mine])
            for triangle, lumel, share in parts
            for mine in (empty[lumel] & (charts[triangle] == self.chart[lumel]),)
        ]
        lumel, triangle, area = (np.concatenate(column) for column in zip(*rows, strict=True))
        order = np.lexsort((triangle, -area, lumel))
        lumel, triangle = lumel[order], triangle[order]
        first = np.concatenate([[True], lumel[1:] != lumel[:-1]])
        lumel, triangle = lumel[first], triangle[first]
        return lumel, triangle, coverage.inner_points(self._corners[triangle], *self._cells(lumel))
