"""Lumels: where on the surfaces each pixel of the pages lies, with several places in each for anti-aliasing.

Coverage is conservative: a lumel counts as soon as the surface overlaps it with some area. Its places are points of a small
low-discrepancy net that lie on the surface; where the surface is so thin that it meets none, a point of the overlap is.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..errors import Cancelled, SceneError
from ..scene.mesh import Mesh
from ..transport.lux_maps.survey import Survey, Surveyor
from ..transport.paths.illuminance import Receivers
from . import coverage
from .layout import Atlas, SurfaceLayout

MOST_PLACES, FEWEST_PLACES = 16, 4
"""Places in a lumel that is covered whole: the most, where they fit the memory, and the fewest."""

BLOCK_PLACES = 1 << 21
"""Most places of a block, but for single rows that have more."""

PLACE_BYTES = 24 + 12 + 12 + 4 + 1
"""Memory of a place: position, normals, triangle, box. [byte]"""

INSET = 1e-3
"""Samples stay so far inside their lumel: what stands on its border is beside it. [lumel]"""

SAME_STEPS = 1e-4
"""Difference of steps on the surface, relative to them, up to which two triangles are one plane with one layout. [-]"""


WHOLE = 1e-6
"""Part of a lumel that may be missing where it counts as covered whole. [-]"""


@dataclass(frozen=True)
class LumelFacts:
    """Lumels of one layout on one page, in a row, but for their places.

    Parameters
    ----------
    layout : int    Index in the atlas's layouts.
    page : int
    index : (n,) int64 array    Flat pixel index on the page, row 0 at the bottom, ascending.
    chart : (n,) int32 array
    area : (n,) array    Surface in each lumel. [m2]
    valid : (n,) bool array    False: inside a solid or covered all over, to be filled from the neighbours.
    """

    layout: int
    page: int
    index: np.ndarray
    chart: np.ndarray
    area: np.ndarray
    valid: np.ndarray


@dataclass(frozen=True)
class LumelBlock(LumelFacts):
    """Lumels with their places.

    Parameters
    ----------
    receivers : Receivers    n rows, those that are not valid too.
    triangle : (k,) int32 array    Triangle of the mesh for every place of the receivers.
    box : (k,) uint8 array
        Number, from 1, of the part of the lumel that every place stands for, where it stands for all of that: samples may
        lie anywhere in it. 0: only at the place itself. See `Boxes`.
    steps : (n, 2, 3) float32 array    Steps on the surface for one lumel to the right and one upwards. [m]
    reached : (n,) array or None    Share of each lumel's places that light can reach; None: all. [-]
    """

    receivers: Receivers
    triangle: np.ndarray
    box: np.ndarray
    steps: np.ndarray
    reached: np.ndarray | None = None

    def size(self) -> int:
        """Memory that it takes. [byte]"""
        held = self.receivers
        arrays = [self.index, self.chart, self.area, self.valid, self.triangle, held.positions]
        arrays += [self.box, self.steps]
        arrays += [held.geometric_normals, held.start, held.count]
        if held.normals is not held.geometric_normals:
            arrays.append(held.normals)
        return sum(array.nbytes for array in arrays)


class _Facts:
    """Facts about a block in little memory: lumels of one chart that follow each other are told as one."""

    def __init__(self, block: LumelBlock):
        step = np.flatnonzero((np.diff(block.index) != 1) | (np.diff(block.chart) != 0)) + 1
        first = np.concatenate([[0], step]) if len(block.index) else step
        self._lengths = np.diff(first, append=len(block.index)).astype(np.int32)
        self._start, self._chart = block.index[first], block.chart[first]
        self._area, self._valid = block.area.astype(np.float32), np.packbits(block.valid)
        self._owner = block.layout, block.page

    def unpack(self) -> LumelFacts:
        """Tell them lumel by lumel."""
        count = len(self._area)
        ends = np.cumsum(self._lengths, dtype=np.int64)
        index = np.arange(count) + np.repeat(self._start - (ends - self._lengths), self._lengths)
        chart = np.repeat(self._chart, self._lengths)
        valid = np.unpackbits(self._valid, count=count).astype(bool)
        return LumelFacts(*self._owner, index, chart, self._area, valid)


@dataclass(frozen=True)
class Correction:
    """What is changed about the places of a block, numbered as they are without it.

    Parameters
    ----------
    dropped : uint8 array or None    Packed bits of places that are of no use; None: there are none.
    moved : (m,) int32 array    Places that are moved.
    shift : (m, 3) float32 array    How far. [m]
    still : uint8 array    Packed bits of lumels whose samples lie at places only.
    """

    dropped: np.ndarray | None
    moved: np.ndarray
    shift: np.ndarray
    still: np.ndarray


@dataclass(frozen=True)
class Boxes:
    """Parts of a lumel, one around each point of the net of places, alike in size.

    Parameters
    ----------
    points : (p, 2) array    The net, 0..1. [lumel]
    corners : (p, 2) array    Lower left corners. [lumel]
    size : (2,) array    [lumel]
    ends : (float, float)    Between which samples stay along either side of the lumel. [lumel]
    """

    points: np.ndarray
    corners: np.ndarray
    size: np.ndarray
    ends: tuple[float, float] = (INSET, 1.0 - INSET)

    @classmethod
    def around(cls, points: np.ndarray) -> "Boxes":
        """Boxes around the points of `_net`, a power of two: each holds one (they are a (0, m, 2)-net in base 2)."""
        bits = len(points).bit_length() - 1
        sides = np.array([2 ** ((bits + 1) // 2), 2 ** (bits // 2)])
        return cls(points, np.floor(points * sides) / sides, 1.0 / sides)


class LumelTable:
    """All lumels of an atlas, in blocks of bounded memory; blocks are made anew when asked for and kept while they fit.

    Parameters
    ----------
    meshes : sequence of Mesh    One for each layout of the atlas.
    atlas : Atlas
    memory : int    What the kept blocks may take together. [byte]

    Raises
    ------
    SceneError    There are not as many meshes as layouts, or a layout does not fit its mesh.
    """

    def __init__(self, meshes, atlas: Atlas, memory: int = 1 << 30):
        _check(meshes, atlas)
        self._meshes, self._atlas, self._memory = tuple(meshes), atlas, memory
        self._kept: dict[int, LumelBlock] = {}
        self._held = 0
        self._corrections: dict[int, Correction] = {}
        self._facts: dict[int, _Facts] = {}
        self.survey: Survey | None = None
        """Places that stand for all, once the table has been validated."""
        sheets = [
            (number, page, *_count_rows(layout, page, atlas.sizes[page]))
            for number, layout in enumerate(atlas.layouts)
            for page in _pages(layout)
        ]
        total = sum(int(counts.sum()) for _, _, _, counts in sheets)
        self.places = _places_of(total, memory)
        """Places in a lumel that is covered whole."""
        self.boxes = Boxes.around(_net(self.places))
        self._bands: list[tuple[int, int, int, int]] = []
        counts: list[int] = []
        for number, page, first, rows in sheets:
            for low, high in _split(rows, max(BLOCK_PLACES // self.places, 1)):
                self._bands.append((number, page, first + low, first + high))
                counts.append(int(rows[low:high].sum()))
        self.counts: tuple[int, ...] = tuple(counts)

    @property
    def is_kept(self) -> bool:
        """Whether all blocks are kept, so that none is made twice."""
        return len(self._kept) == len(self._bands)

    def width(self, number: int) -> int:
        """Width of the page that a block lies on. [lumel]"""
        return int(self._atlas.sizes[self.page(number)][0])

    def page(self, number: int) -> int:
        """Page that a block lies on."""
        return self._bands[number][1]

    def layout(self, number: int) -> int:
        """Layout whose lumels a block holds."""
        return self._bands[number][0]

    def block(self, number: int) -> LumelBlock:
        """Return a block; the same whether it is made for the first time or anew."""
        if number in self._kept:
            return self._kept[number]
        return self._corrected(number, self._make(number))

    def facts(self, number: int) -> LumelFacts:
        """All about a block but for its places, which may have to be made anew."""
        if number in self._kept or number not in self._facts:
            return self.block(number)
        return self._facts[number].unpack()

    def validate(self, scene, cancelled=lambda: False, progress=None, seed: int = 0) -> None:
        """Find lumels that are inside solids or covered, and push places off the surfaces beside them.

        Parameters
        ----------
        scene : CompiledScene    With the meshes of the table in it.
        cancelled : callable    Asked before every launch.
        progress : callable or None    Told the number of each block before its turn, and how many there are.
        seed : int    Chooses the places of `survey`.

        Raises
        ------
        Cancelled    When ``cancelled`` answered true.
        """
        from .validity import Examiner

        self._corrections, self._facts = {}, {}
        self._kept, self._held = {}, 0
        surveyor = Surveyor(len(self._bands), seed)
        examiner = Examiner(scene, cancelled)
        group: list[tuple[int, LumelBlock]] = []
        last = len(self._bands) - 1
        # The next block is made while the present ones are examined.
        with ThreadPoolExecutor(1) as maker:
            coming = maker.submit(self._make, 0)
            for number in range(last + 1):
                if cancelled():
                    raise Cancelled("cancelled")
                if progress is not None:
                    progress(number, last + 1)
                group.append((number, coming.result()))
                if number < last:
                    coming = maker.submit(self._make, number + 1)
                # Small objects are examined together.
                places = sum(len(block.triangle) for _, block in group)
                if places >= BLOCK_PLACES // 2 or number == last:
                    for each, block in self._examine(examiner, group):
                        surveyor.add(block)
                        if each not in self._kept:
                            self._facts[each] = _Facts(block)
                    group = []
        self.survey = surveyor.survey()

    # ---- private ----

    def _examine(self, examiner, group: list[tuple[int, LumelBlock]]):
        """Find the corrections of some blocks; yields these corrected."""
        steps = np.concatenate([block.steps for _, block in group]).astype(np.float64)
        receivers = _join([block.receivers for _, block in group])
        # Boxes of lumels without some of their places reach farther beyond the outermost of the others.
        boxes = self.boxes
        reach = max(
            (boxes.corners + boxes.size - boxes.points).max(), (boxes.points - boxes.corners).max()
        )
        rim = np.where(receivers.count == self.places, 0.5 / self.places, reach) - INSET
        dropped, moved, shift, doubtful = examiner.examine(receivers, steps[:, 0], steps[:, 1], rim)
        first = row = 0
        for number, block in group:
            end, next_row = first + len(block.triangle), row + len(block.index)
            low, high = np.searchsorted(moved, [first, end])
            own = dropped[first:end]
            still = np.zeros(len(block.index), dtype=bool)
            still[doubtful[(doubtful >= row) & (doubtful < next_row)] - row] = True
            if still.any():
                self._corrections[number] = Correction(
                    np.packbits(own) if own.any() else None,
                    (moved[low:high] - first).astype(np.int32),
                    shift[low:high].astype(np.float32),
                    np.packbits(still),
                )
            yield number, self._corrected(number, block)
            first, row = end, next_row

    def _corrected(self, number: int, block: LumelBlock) -> LumelBlock:
        """A block that was just made, corrected and kept."""
        if number in self._corrections:
            block = _correct(block, self._corrections[number])
        # The first ones are kept for good: blocks are asked for in turns, so what came last is needed last.
        if self._held + block.size() <= self._memory:
            self._kept[number] = block
            self._held += block.size()
        return block

    def _make(self, number: int) -> LumelBlock:
        layout_number, page, low, high = self._bands[number]
        mesh, layout = self._meshes[layout_number], self._atlas.layouts[layout_number]
        width = int(self._atlas.sizes[page][0])
        used = np.flatnonzero(layout.page == page)
        v = layout.uv[used, :, 1]
        # One row more on either side, since corners may yet be put on borders.
        used = used[(v.max(axis=1) >= low - 1) & (v.min(axis=1) <= high + 1)]
        corners = coverage.snap(layout.uv[used].astype(np.float64))
        points = mesh.vertices[mesh.triangles[used]]
        facing, areas = _facings(points)
        u, v, is_usable = _lumel_axes(mesh, layout, used)
        steps = np.where(is_usable[:, None, None], np.stack([u, v], axis=1), np.nan)
        raster = _Raster(corners, areas, layout.chart[used], width, low, high, self.boxes, steps)
        triangle = used[raster.triangle]
        positions = np.einsum("kc,kcx->kx", raster.bary, points[raster.triangle])
        geometric = facing[raster.triangle]
        normals = _normals(mesh, triangle, raster.bary, geometric)
        if layout.is_back:
            is_same = normals is geometric
            geometric = -geometric
            normals = geometric if is_same else -normals
        receivers = Receivers(
            positions, normals, geometric, raster.start, raster.count, raster.area
        )
        return LumelBlock(
            layout_number,
            page,
            raster.index,
            raster.chart,
            raster.area,
            np.ones(len(raster.index), dtype=bool),
            receivers,
            triangle.astype(np.int32),
            raster.box,
            np.stack([u, v], axis=1)[raster.first].astype(np.float32),
        )


def _agree(steps: np.ndarray, triangle: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Whether pairs of triangles have the same steps (t, 2, 3) on the surface, and these are known. (k,) bool"""
    agree = np.isfinite(steps[triangle]).all(axis=(1, 2))
    pairs = np.flatnonzero(agree & (triangle != other))
    a, b = steps[triangle[pairs]], steps[other[pairs]]
    agree[pairs] = np.abs(a - b).max(axis=(1, 2)) <= SAME_STEPS * np.abs(b).max(axis=(1, 2))
    return agree


def _join(parts: list[Receivers]) -> Receivers:
    """Receivers of several blocks in a row."""
    if len(parts) == 1:
        return parts[0]
    ends = np.cumsum([0, *(len(part.positions) for part in parts)])
    return Receivers(
        *(
            np.concatenate([getattr(part, name) for part in parts])
            for name in ("positions", "normals", "geometric_normals")
        ),
        np.concatenate([part.start + end for part, end in zip(parts, ends, strict=False)]),
        np.concatenate([part.count for part in parts]),
        np.concatenate([part.weights for part in parts]),
    )


def _check(meshes, atlas: Atlas) -> None:
    if len(meshes) != len(atlas.layouts):
        raise SceneError(
            f"{len(meshes)} meshes have {len(atlas.layouts)} layouts, expected one each"
        )
    for mesh, layout in zip(meshes, atlas.layouts, strict=True):
        if len(layout.uv) != len(mesh.triangles):
            raise SceneError(
                f"object '{mesh.name}' has {len(mesh.triangles)} triangles, its layout has {len(layout.uv)}"
            )
        if not np.isfinite(layout.uv[layout.page >= 0]).all():
            raise SceneError(f"object '{mesh.name}' has a layout that is not finite")


def _pages(layout: SurfaceLayout) -> list[int]:
    return [int(page) for page in np.unique(layout.page) if page >= 0]


def _places_of(total: int, memory: int) -> int:
    """Places by lumel, a power of two: as many as fit the memory."""
    places = MOST_PLACES
    while places > FEWEST_PLACES and total * places * PLACE_BYTES > memory:
        places //= 2
    return places


def _net(count: int) -> np.ndarray:
    """Points of which every row and every column of ``count`` parts has one: Hammersley's, centred. (count, 2)"""
    number = np.arange(count)
    mirrored = np.zeros(count, dtype=np.int64)
    for bit in range(count.bit_length() - 1):
        mirrored = 2 * mirrored + (number >> bit & 1)
    return (np.stack([number, mirrored], axis=1) + 0.5) / count


def _split(rows: np.ndarray, most: int):
    """Yield ranges of rows that hold about ``most`` lumels each, none of them empty."""
    ends = np.cumsum(rows)
    begin, done = 0, 0
    while done < ends[-1]:
        end = max(int(np.searchsorted(ends, done + most, side="right")), begin + 1)
        if ends[end - 1] > done:
            yield begin, end
        begin, done = end, int(ends[end - 1])


def _count_rows(layout: SurfaceLayout, page: int, size) -> tuple[int, np.ndarray]:
    """First row and lumels of every row from there on."""
    width, height = (int(side) for side in size)
    corners = coverage.snap(layout.uv[layout.page == page].astype(np.float64))
    spans = coverage.find_spans(corners, width, 0, height)
    start, length = coverage.merge_spans(spans, width)
    if len(start) == 0:
        return 0, np.zeros(1, dtype=np.int64)
    # Covered lumels before the beginning of every row; runs may go on from one row to the next.
    first, last = int(start[0] // width), int((start[-1] + length[-1] - 1) // width)
    edges = np.arange(first, last + 2) * width
    before = np.concatenate([[0], np.cumsum(length)])
    run = np.searchsorted(start, edges, side="right") - 1
    inside = np.where(run >= 0, np.minimum(edges - start[run], length[run]), 0)
    return first, np.diff(np.where(run >= 0, before[run] + inside, 0))


def _facings(points: np.ndarray):
    """Unit normals of triangles (t, 3, 3) in single precision, and their areas. (t, 3), (t,)"""
    normal = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    length = np.linalg.norm(normal, axis=1)
    return (normal / np.maximum(length, 1e-300)[:, None]).astype(np.float32), 0.5 * length


class _Raster:
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


def _normals(mesh: Mesh, triangle, bary, geometric) -> np.ndarray:
    """Shading normals of places; the true ones themselves where the mesh is flat. (k, 3) float32"""
    if mesh.corner_normals is None:
        return geometric
    corners = mesh.corner_normals[triangle].astype(np.float32, copy=False)
    normals = np.einsum("kc,kcx->kx", bary.astype(np.float32), corners)
    length = np.sqrt(np.einsum("kx,kx->k", normals, normals))
    # Normals that look into the surface would receive nothing.
    usable = (length > 1e-6) & (np.einsum("kx,kx->k", normals, geometric) > 0.0)
    normals /= np.maximum(length, np.float32(1e-6))[:, None]
    return np.where(usable[:, None], normals, geometric)


def _lumel_axes(mesh: Mesh, layout: SurfaceLayout, triangle: np.ndarray):
    """Steps on the surface for one lumel to the right and one upwards, by the triangles there.

    Returns
    -------
    (n, 3), (n, 3), (n,) bool    Both [m], and whether they are the layout's: of slivers they are made up.
    """
    points = mesh.vertices[mesh.triangles[triangle]]
    corners = layout.uv[triangle].astype(np.float64)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    whole = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    along, across = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    side = 1.0 / layout.density
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        u = (along * second[:, 1:] - across * first[:, 1:]) / whole[:, None]
        v = (across * first[:, :1] - along * second[:, :1]) / whole[:, None]
        lengths = np.stack([np.linalg.norm(u, axis=1), np.linalg.norm(v, axis=1)])
        usable = ((lengths > 0.25 * side) & (lengths < 4.0 * side)).all(axis=0)
    # Slivers do not tell their own slope; any frame in their plane will do.
    normal = np.cross(along, across)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.where(length > 0.0, normal / np.maximum(length, 1e-300), [0.0, 0.0, 1.0])
    helper = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    other = np.cross(helper, normal)
    other *= side / np.linalg.norm(other, axis=1, keepdims=True)
    u = np.where(usable[:, None], u, other)
    v = np.where(usable[:, None], v, np.cross(normal, other))
    return u, v, usable


def _correct(block: LumelBlock, correction: Correction) -> LumelBlock:
    """Apply what was found out about a block's places."""
    held = block.receivers
    positions = held.positions.copy()
    positions[correction.moved] += correction.shift
    still = np.unpackbits(correction.still, count=len(block.index)).astype(bool)
    box = np.where(np.repeat(still, held.count), np.uint8(0), block.box)
    kept, count, valid = np.ones(len(positions), dtype=bool), held.count, block.valid
    reached = None
    if correction.dropped is not None:
        kept = np.unpackbits(correction.dropped, count=len(positions)) == 0
        count = np.add.reduceat(kept, held.start, dtype=np.int64)
        valid, reached = count > 0, count / held.count
        # Lumels without any use keep their places, so that every row has some.
        kept |= np.repeat(~valid, held.count)
        count = np.where(valid, count, held.count)
    normals = held.normals[kept]
    is_flat = held.normals is held.geometric_normals
    receivers = Receivers(
        positions[kept],
        normals,
        normals if is_flat else held.geometric_normals[kept],
        np.cumsum(count) - count,
        count,
        held.weights,
    )
    return LumelBlock(
        block.layout,
        block.page,
        block.index,
        block.chart,
        block.area,
        valid,
        receivers,
        block.triangle[kept],
        box[kept],
        block.steps,
        reached,
    )
