"""Charts' rectangles onto the pages of an atlas."""

import heapq
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError

ONE_BY_ONE = 4096
"""Charts that are given to pages one by one, the largest; the small rest fills what is left in order of size."""

ROWS_FROM = 2048
"""Charts of a page that are placed one by one, the tallest; the others, alike in height, go in rows."""

STEPS = 40
"""Halvings of an interval of area limits."""

FINENESS = 0.004
"""To which the factor by which charts shrink is found."""

FULLEST = 0.985
"""Share of a page that can be filled at best, where the search for the factor starts."""

MOST_LEFT = 0.02
"""Share of the charts' area that may have to look for another page; beyond, they count as not fitting."""

MOST_PAGES = 1024
"""More pages are refused: it would be the work of a wrong density."""

MULTIPLE = 4
"""Of this are the sides of a page that is smaller than the largest. [lumel]"""

WIDTHS = (0.72, 0.84, 0.92, 1.0, 1.06, 1.14, 1.28, 1.44)
"""Widths that are tried for a page by itself, as shares of the side of a square with the charts' area."""


@dataclass(frozen=True)
class Packing:
    """Where charts lie.

    Parameters
    ----------
    page : (c,) int64 array
    place : (c, 2) int64 array    Lower left corner of the chart without its margin. [lumel]
    lumels : (c, 2) int64 array    Width and height of the chart in whole lumels.
    sizes : (p, 2) int64 array    Width and height of the pages. [lumel]
    shrink : float    Factor on all densities. [-]
    cut_down : (c,) bool array    Charts that are larger than a page at the density that was asked for.
    """

    page: np.ndarray
    place: np.ndarray
    lumels: np.ndarray
    sizes: np.ndarray
    shrink: float
    cut_down: np.ndarray


def pack(
    size: np.ndarray,
    density: np.ndarray,
    *,
    largest: int,
    pages: int,
    margin: int,
    owner: np.ndarray | None = None,
) -> Packing:
    """Place charts on pages.

    Charts are sorted by area and given to pages first-fit decreasing up to an area limit, the least with which the pages
    suffice. When they do not fit, all shrink by one factor, the largest that fits up to 0.4 %.

    Parameters
    ----------
    size : (c, 2) float64 array    Width and height. [m]
    density : (c,) float64 array    Lumels per metre.
    largest : int    Side of a page. [lumel]
    pages : int    Most pages; 0: as many as it takes.
    margin : int    Free rim of every chart. [lumel]
    owner : (c,) int64 array or None    Mesh of every chart: those of one mesh share a page where that costs nothing.

    Raises
    ------
    SceneError    The charts do not fit, however small they get, or need too many pages.
    """
    inner = largest - 2 * margin
    if inner < 1:
        raise SceneError(
            f"pages of {largest} lumels have no room within a margin of {margin}; raise the size or lower the margin"
        )
    if len(size) == 0:
        none = np.zeros((0, 2), dtype=np.int64)
        return Packing(none[:, 0], none, none, none, 1.0, np.zeros(0, dtype=bool))
    wanted = np.asarray(size, dtype=np.float64) * np.asarray(density, dtype=np.float64)[:, None]
    job = _Job(wanted, largest, pages, margin)
    shrink, made = _find_shrink(job)
    if owner is not None and len(made.sizes) > 1:
        made = job.try_pages(shrink, len(made.sizes), owner) or made
    return Packing(
        made.page,
        made.corner + margin,
        job.count_lumels(shrink),
        made.sizes,
        shrink,
        wanted.max(axis=1) > inner + 0.5,
    )


@dataclass(frozen=True)
class _Placed:
    page: np.ndarray
    corner: np.ndarray
    sizes: np.ndarray


@dataclass(frozen=True)
class _Job:
    """Charts with the lumels that they want, and the pages that they may have."""

    wanted: np.ndarray
    largest: int
    pages: int
    margin: int

    def count_lumels(self, shrink: float) -> np.ndarray:
        """Whole lumels of the charts, never none. (c, 2)"""
        inner = self.largest - 2 * self.margin
        longest = np.maximum(self.wanted.max(axis=1), 1e-300)
        factor = np.minimum(inner / longest, shrink)
        lumels = np.floor(self.wanted * factor[:, None] + 0.5)
        return np.clip(lumels, 1, inner).astype(np.int64)

    def area(self, shrink: float) -> float:
        """Area of the charts with their margins. [lumel]"""
        return float((self.count_lumels(shrink) + 2 * self.margin).prod(axis=1).sum())

    def try_pages(self, shrink: float, pages: int, owner=None) -> _Placed | None:
        """Place the charts on so many pages; None if they do not fit."""
        boxes = self.count_lumels(shrink) + 2 * self.margin
        area = boxes.prod(axis=1).astype(np.float64)
        if area.sum() > pages * float(self.largest) ** 2:
            return None
        if pages == 1:
            return self._place_alone(boxes)
        page = _group(area, pages, float(self.largest) ** 2, owner)
        made = None if page is None else self._place_groups(boxes, area, page, pages)
        if made is None and owner is None:
            # First-fit decreasing puts all the large charts together, where there is nothing small to fill the gaps.
            made = self._place_groups(boxes, area, _deal(area, pages), pages)
        return made

    def _place_groups(self, boxes, area, page, pages: int) -> _Placed | None:
        """Place groups on their pages; what does not fit goes to any other page. None if something is left."""
        page = page.copy()
        skylines = [_Skyline(self.largest, self.largest) for _ in range(pages)]
        corner = np.full((len(boxes), 2), -1, dtype=np.int64)
        order = np.argsort(page, kind="stable")
        ends = np.searchsorted(page[order], np.arange(pages + 1))
        most = MOST_LEFT * area.sum()
        for number, skyline in enumerate(skylines):
            members = order[ends[number] : ends[number + 1]]
            corner[members] = skyline.fill(boxes[members])
            most -= area[members[corner[members, 0] < 0]].sum()
            if most < 0.0:
                return None
        left = np.flatnonzero(corner[:, 0] < 0)
        for chart in left[np.argsort(-area[left], kind="stable")]:
            for number, skyline in enumerate(skylines):
                found = skyline.add(*boxes[chart])
                if found is not None:
                    page[chart], corner[chart] = number, found
                    break
            else:
                return None
        sizes = np.full((pages, 2), self.largest, dtype=np.int64)
        return _Placed(page, corner, sizes)

    def _place_alone(self, boxes: np.ndarray) -> _Placed | None:
        """Place all charts on one page that is as small as can be; None if they do not fit the largest."""
        least = np.maximum(boxes.max(axis=0), np.sqrt(boxes.prod(axis=1).sum()) * 0.5)
        side = np.sqrt(boxes.prod(axis=1).sum())
        best = None
        widths = {_round_up(max(side * share, boxes[:, 0].max()), self.largest) for share in WIDTHS}
        for width in sorted(widths | {self.largest}):
            if best is not None and width * least[1] >= best[0]:
                continue
            skyline = _Skyline(width, self.largest)
            corner = skyline.fill(boxes)
            if (corner < 0).any():
                continue
            used = (corner + boxes).max(axis=0)
            sides = [_round_up(side, self.largest) for side in used]
            if best is None or sides[0] * sides[1] < best[0]:
                best = (sides[0] * sides[1], sides, corner)
        if best is None:
            return None
        page = np.zeros(len(boxes), dtype=np.int64)
        return _Placed(page, best[2], np.array([best[1]], dtype=np.int64))


def _round_up(side: float, largest: int) -> int:
    return min(int(np.ceil(side / MULTIPLE)) * MULTIPLE, largest)


def _find_shrink(job: _Job) -> tuple[float, _Placed]:
    """Find the largest factor with which the charts fit, and place them."""
    page = float(job.largest) ** 2
    made = _find_pages(job, page)
    if made is not None:
        return 1.0, made
    if job.pages == 0:
        raise SceneError(
            f"the charts need more than {MOST_PAGES} pages of {job.largest} x {job.largest}; lower the lumels per metre, or "
            "say how many pages there may be"
        )
    room = job.pages * page
    if job.area(0.0) > room:
        raise SceneError(
            f"{len(job.wanted)} charts with a margin of {job.margin} lumels do not fit {job.pages} pages of {job.largest} x "
            f"{job.largest} at any density; raise the number or size of the pages or lower the margin"
        )
    low, high = 0.0, 1.0
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if job.area(middle) <= FULLEST * room else (low, middle)
    high = max(low, 1e-9)
    # Area alone says what cannot be; from there down in growing steps to what can, then between the two.
    step, low, made = 0.02, high, None
    while made is None:
        high, low = low, low * (1.0 - step)
        made = job.try_pages(low, job.pages)
        if made is None and step == 1.0:
            raise SceneError(
                f"{len(job.wanted)} charts do not fit {job.pages} pages of {job.largest} x {job.largest}; raise the number "
                "or size of the pages"
            )
        step = min(2.0 * step, 1.0)
    while high - low > FINENESS * high:
        middle = 0.5 * (low + high)
        better = job.try_pages(middle, job.pages)
        if better is None:
            high = middle
        else:
            low, made = middle, better
    return low, made


def _find_pages(job: _Job, page: float) -> _Placed | None:
    """Place the charts unshrunk, on as few pages as are found to suffice; None if these are too many."""
    pages = max(int(np.ceil(job.area(1.0) / page)), 1)
    while pages <= (job.pages or MOST_PAGES):
        made = job.try_pages(1.0, pages)
        if made is not None:
            return made
        pages += max(pages // 50, 1)
    return None


def _group(area: np.ndarray, pages: int, page: float, owner: np.ndarray | None):
    """Give charts to pages by their areas: first-fit decreasing, up to the least limit with which the pages suffice.

    Parameters
    ----------
    area : (c,) float64 array    [lumel]
    pages : int
    page : float    Area of a page. [lumel]
    owner : (c,) int64 array or None    Charts of one owner go as one, unless they are more than the limit.

    Returns
    -------
    (c,) int64 array, or None where there is no such limit up to a page's area
    """
    low, high = max(float(area.sum()) / pages, float(area.max())), page
    if count_groups(area, high, owner) > pages:
        return None
    for _ in range(STEPS):
        if high - low < 1e-3 * high:
            break
        middle = 0.5 * (low + high)
        if count_groups(area, middle, owner) <= pages:
            high = middle
        else:
            low = middle
    return _first_fit(area, high, owner)


def count_groups(area: np.ndarray, limit: float, owner: np.ndarray | None = None) -> int:
    """Count the groups that first-fit decreasing makes of areas up to a limit on their sum."""
    return int(_first_fit(area, limit, owner).max()) + 1


def _first_fit(area: np.ndarray, limit: float, owner: np.ndarray | None) -> np.ndarray:
    """Group areas: the largest one by one where they fit first, then the small rest in what is left. (c,)"""
    if owner is not None:
        whole = np.bincount(owner, area)
        fits = whole[owner] <= limit
        item = np.where(fits, owner, len(whole) + np.arange(len(area)))
        _, item = np.unique(item, return_inverse=True)
        item = item.reshape(-1)
        return _first_fit(np.bincount(item, area), limit, None)[item]
    order = np.argsort(-area, kind="stable")
    group = np.zeros(len(area), dtype=np.int64)
    room = np.full(64, limit)
    used = 0
    for number in order[:ONE_BY_ONE]:
        if used == len(room):
            room = np.concatenate([room, np.full(len(room), limit)])
        first = int(np.argmax(room[: used + 1] >= area[number]))
        if first == 0 and room[0] < area[number]:
            first = used
        room[first] -= area[number]
        used = max(used, first + 1)
        group[number] = first
    rest = order[ONE_BY_ONE:]
    if len(rest):
        # Each is small beside a page, so filling up one page after another loses next to nothing.
        need = area[rest[0]]
        open_room = np.maximum(room[:used] - need, 0.0)
        total = np.cumsum(area[rest])
        missing = total[-1] - open_room.sum()
        more = max(int(np.ceil(missing / max(limit - need, need))), 0)
        bounds = np.cumsum(np.concatenate([open_room, np.full(more, max(limit - need, need))]))
        group[rest] = np.minimum(np.searchsorted(bounds, total), used + more - 1)
    return group


def _deal(area: np.ndarray, pages: int) -> np.ndarray:
    """Give every chart, the largest first, to the page that is the emptiest then: large and small ones on each. (c,)"""
    page = np.zeros(len(area), dtype=np.int64)
    filled = [(0.0, number) for number in range(pages)]
    for chart in np.argsort(-area, kind="stable"):
        share, number = filled[0]
        heapq.heapreplace(filled, (share + float(area[chart]), number))
        page[chart] = number
    return page


class _Skyline:
    """A page filled from below: how high it is filled at every column."""

    def __init__(self, width: int, height: int):
        self._top = np.zeros(width, dtype=np.int32)
        self._height = height

    def add(self, width: int, height: int) -> tuple[int, int] | None:
        """Place a rectangle where it reaches least high, as far left as that goes."""
        if width > len(self._top):
            return None
        reach = self._top
        span = 1
        while 2 * span <= width:
            reach = np.maximum(reach[:-span], reach[span:])
            span *= 2
        places = len(self._top) - width + 1
        reach = np.maximum(reach[:places], reach[width - span : width - span + places])
        x = int(np.argmin(reach))
        y = int(reach[x])
        if y + height > self._height:
            return None
        self._top[x : x + width] = y + height
        return x, y

    def fill(self, boxes: np.ndarray) -> np.ndarray:
        """Place rectangles, the tallest first. (n, 2) -> lower left corners (n, 2), -1 where there is no room"""
        corner = np.full((len(boxes), 2), -1, dtype=np.int64)
        order = np.lexsort((-boxes[:, 0], -boxes[:, 1]))
        for number in order[:ROWS_FROM]:
            found = self.add(int(boxes[number, 0]), int(boxes[number, 1]))
            if found is not None:
                corner[number] = found
        rest = order[ROWS_FROM:]
        ends = np.cumsum(boxes[rest, 0])
        start = 0
        while start < len(rest):
            done = int(ends[start - 1]) if start else 0
            stop = int(np.searchsorted(ends, done + len(self._top), side="right"))
            if stop == start:
                # Wider than the page.
                start += 1
                continue
            row = rest[start:stop]
            found = self.add(int(ends[stop - 1]) - done, int(boxes[row[0], 1]))
            if found is not None:
                corner[row, 0] = found[0] + ends[start:stop] - boxes[row, 0] - done
                corner[row, 1] = found[1]
            start = stop
        return corner
