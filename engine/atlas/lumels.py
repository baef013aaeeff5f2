"""Lumels: where on the surfaces each pixel of the pages lies, with several places in each for anti-aliasing."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..errors import Cancelled, SceneError
from ..transport.lux_maps.survey import Survey, Surveyor
from ..transport.paths.illuminance import Receivers
from . import coverage
from .boxes import INSET, Boxes, net
from .frames import find_facings, find_lumel_axes, find_normals
from .layout import Atlas, SurfaceLayout
from .lumel_blocks import Correction, LumelBlock, LumelFacts, PackedFacts, correct, join_receivers
from .raster import Raster

MOST_PLACES, FEWEST_PLACES = 16, 4
"""Places in a lumel that is covered whole: the most, where they fit the memory, and the fewest."""

BLOCK_PLACES = 1 << 21
"""Most places of a block, but for single rows that have more."""

PLACE_BYTES = 24 + 12 + 12 + 4 + 1
"""Memory of a place: position, normals, triangle, box. [byte]"""


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
        self._facts: dict[int, PackedFacts] = {}
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
        self.boxes = Boxes.around(net(self.places))
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
                            self._facts[each] = PackedFacts(block)
                    group = []
        self.survey = surveyor.survey()

    # ---- private ----

    def _examine(self, examiner, group: list[tuple[int, LumelBlock]]):
        """Find the corrections of some blocks; yields these corrected."""
        steps = np.concatenate([block.steps for _, block in group]).astype(np.float64)
        receivers = join_receivers([block.receivers for _, block in group])
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
            block = correct(block, self._corrections[number])
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
        facing, areas = find_facings(points)
        u, v, is_usable = find_lumel_axes(mesh, layout, used)
        steps = np.where(is_usable[:, None, None], np.stack([u, v], axis=1), np.nan)
        raster = Raster(corners, areas, layout.chart[used], width, low, high, self.boxes, steps)
        triangle = used[raster.triangle]
        positions = np.einsum("kc,kcx->kx", raster.bary, points[raster.triangle])
        geometric = facing[raster.triangle]
        normals = find_normals(mesh, triangle, raster.bary, geometric)
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
