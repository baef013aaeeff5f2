"""The live view of a room: paths at first, and kinds of samples apart with cells as soon as their light is known.

The first images come by paths, as in every `LiveView`. Once the view has been left alone for a moment, the cells' light is
found slice by slice beside them. From then on pixels are sampled as those of a picture. What the paths have found stays:
both means are joined by their variances, which are known of the whole image and of no single pixel, so no pixel decides by
its own noise how much it counts.
"""

import time
from types import SimpleNamespace

import numpy as np

from ...accuracy.estimate import relative_error
from ...accuracy.stopping import StopRule
from ..lux_maps.levels import Units
from ..paths.film import GROUPS, learn_lights, look
from ..paths.live_view import CALM, PILOT_LANES, LiveView
from .allocation import Allocation
from .kept_cells import KeptCells
from .picture import EVEN, GROWTH, LEAST, LEAST_MEAN, SHARED, SWEEP_SHARE, choose_method
from .pixel_light import COSTS, FLOORS, STEERING, PixelLight
from .sharing import finding_sharing

PIXELS_SHARE = 0.25
"""Pixels by which cells are counted, relative to those of the view: fewer cells than in a picture are ready sooner. [-]"""

SHORT_LAUNCH, LONG_LAUNCH = 1 << 14, 1 << 15
"""Least samples of a slice, at first and from `REST` on. With cells it is many kernels, and putting them together takes a
tenth of a second, however few samples they get."""

REST = 5.0
"""Time after which the next edit is hardly to come at once. [s]"""

FINDING_SHARE = 0.85
"""Share of the time that finding the light of the cells takes, beside paths. [-]"""

SOON = 20.0
"""Time within which all samples are taken by paths, where cells are not worth finding their light. [s]"""

LOOKING_LANES = 1 << 18
"""Rays of a step that tells what pixels show."""

WORDS = "by cells, their bias not measured"
"""What a frame says whose light beyond the first bounce was read from cells."""

DONE = object()
"""Stands for the end of steps."""

CELL_SEEDS = 7_919
"""Distance of the seed of samples with cells from that of the paths, whose points they must not share."""


class CellView(LiveView):
    """Progressive picture of a camera, used like a `LiveView`.

    Parameters
    ----------
    scene : CompiledScene
    camera : Camera    Of the whole view.
    settings : LiveSettings
    kept : KeptCells    Cells that pictures and views of the session share.

    Raises
    ------
    SceneError    The size cannot be shown, or the method is none of the three.
    """

    def __init__(self, scene, camera, settings, kept: KeptCells):
        super().__init__(scene, camera, settings)
        wanted = SimpleNamespace(
            method=settings.method,
            rule=StopRule(samples=settings.samples),
            seed=settings.seed,
            unbiased=False,
        )
        self._reads_cells, _ = choose_method(scene, camera, wanted)
        self._reads_cells &= scene.catchers is None
        self._kept = kept
        self._cells = self._steps = self._passes_by_kind = None
        self._lanes = SHORT_LAUNCH
        self._finding = self._following = 0.0
        self._traced = 0

    @property
    def samples(self) -> int:
        """Samples of every pixel, both kinds of them; one of each kind of light counts as one. 0 while it is coarse."""
        joined = self._passes_by_kind
        more = 0.0 if joined is None or joined.means is None else joined.allocation.samples
        return super().samples + round(GROUPS * more)

    @property
    def words(self) -> str:
        """As of `LiveView`: measuring what cells change takes kernels of its own, whose making would hold up edits."""
        joined = self._passes_by_kind
        return "" if joined is None or joined.means is None else WORDS

    def refine(self) -> bool:
        """Do one slice of work; true when a pass over the image was finished."""
        if self._passes_by_kind is not None:
            return self._sample_kinds()
        if not self._is_time_for_cells():
            start = time.perf_counter()
            self._traced += GROUPS * min(self._slice // GROUPS, self._pixels - self._cursor)
            made = super().refine()
            self._following += time.perf_counter() - start
            return made
        start = time.perf_counter()
        self._find_cells()
        self._finding += time.perf_counter() - start
        return False

    def luminance_error(self) -> np.ndarray:
        """Standard error of the luminance at the end of a pass over the finest image. (h, w) float32 [cd/m2]"""
        joined = self._passes_by_kind
        if joined is None or joined.means is None:
            return super().luminance_error()
        halves = self._joined()[..., 1]
        smoothed = (1.0 - self._weight) ** 2 * joined.smoothed
        error = np.sqrt(0.25 * (halves[0] - halves[1]) ** 2 + smoothed)
        return error.reshape(self._camera.height, self._camera.width).astype(np.float32)

    # ---- private ----

    def _is_time_for_cells(self) -> bool:
        """Whether the next slice goes into finding the light of the cells."""
        if not self._reads_cells or self.is_complete or time.perf_counter() - self._begun < CALM:
            return False
        if self.settings.method == "auto" and self._cells is None and self._is_soon_done():
            return False
        spent = self._finding + self._following
        return self._finding <= FINDING_SHARE * spent

    def _is_soon_done(self) -> bool:
        """Whether paths take the samples that are left sooner than cells would be worth their time."""
        left = (self.settings.samples - super().samples) * self.camera.width * self.camera.height
        return left * self._following <= SOON * self._traced

    def _find_cells(self) -> None:
        """Take one step towards the light of the cells."""
        if not self._has_learned:
            learn_lights(self.scene, self._film, PILOT_LANES)
            self._has_learned = True
            return
        if self._cells is None or not self._cells.is_current:
            self._open_cells()
            return
        self._cells.cut(self._lanes)
        if self._step() is DONE:
            self._begin_kinds()

    def _open_cells(self) -> None:
        """Divide the surfaces, or take what is there."""
        places, normals = look(self.scene, self._film)
        cells = None
        if len(places):
            pixels = int(PIXELS_SHARE * self.camera.width * self.camera.height)
            cells = self._kept.open(self.scene, places, normals, pixels, self.settings.seed)
        if not cells:
            self._reads_cells = False
            return
        self._cells, self._steps = cells, cells.preparing()

    def _begin_kinds(self) -> None:
        """Leave the paths for samples with cells."""
        while self.factor > 1:
            self._refine_level()
        # Pixels beyond the cursor have a sample less.
        count = self._passes + (np.arange(self._pixels) < self._cursor)
        self._by_paths = self._sums / np.maximum(count, 1)[:, None] if self._passes else None
        self._weight = 0.0
        wanted = SimpleNamespace(
            seed=(self.settings.seed + CELL_SEEDS) % 2**31,
            illuminance=self.settings.illuminance,
            bands=0,
            transparent=False,
            unbiased=False,
        )
        light = PixelLight(self.scene, self._film, wanted, self._cells)
        self._passes_by_kind = _KindPasses(light, self._camera, lambda: self._lanes)
        self._steps = None

    def _sample_kinds(self) -> bool:
        """Take one slice of samples with cells."""
        joined = self._passes_by_kind
        if not self._cells.is_current:
            # Somebody has used the cells in between: what is known by paths stays, and they are asked for anew.
            self._cells = self._steps = self._passes_by_kind = None
            return False
        if self._steps is None:
            left = (self.settings.samples - super().samples) / GROUPS - joined.allocation.samples
            self._steps = joined.make(left)
        made = self._step()
        if made is DONE:
            self._steps = None
            self._join()
            return True
        if made is not None and self._by_paths is None:
            # There was but a coarse image here.
            self._image[made] = joined.mean_of(made)
            self.changes += 1
        return False

    def _step(self):
        """Take the next step of what goes on; returns what it gives, `DONE` at the end."""
        start = time.perf_counter()
        made = next(self._steps, DONE)
        seconds = time.perf_counter() - start
        has_rested = time.perf_counter() - self._begun > REST
        least = LONG_LAUNCH if has_rested else SHORT_LAUNCH
        self._lanes = self._adapted(self._lanes, self._lanes, seconds, least)
        return made

    def _joined(self) -> np.ndarray:
        """Means of both halves by all samples. (2, n, channels)"""
        means = self._passes_by_kind.means
        return means if self._by_paths is None else means + self._weight * (self._by_paths - means)

    def _join(self) -> None:
        """Join paths and samples with cells, by how far the halves of each are apart in the whole image."""
        halves = self._passes_by_kind.means[..., 1]
        mean = halves.mean(axis=0)
        if self._by_paths is not None:
            own, other = (
                relative_error(mean, np.sqrt(0.25 * (each[0] - each[1]) ** 2 + smoothed)) ** 2
                for each, smoothed in (
                    (halves, self._passes_by_kind.smoothed),
                    (self._by_paths[..., 1], 0.0),
                )
            )
            self._weight = own / (own + other) if own + other > 0.0 else 0.5
        joined = self._joined()
        self._image[:] = joined.mean(axis=0)
        self.changes += 1
        self.error = relative_error(joined[..., 1].mean(axis=0), self.luminance_error().ravel())


class _KindPasses:
    """Passes over all pixels by kinds of samples, as those of a picture, in slices.

    Parameters
    ----------
    light : PixelLight
    camera : Camera
    lanes : callable    How many samples the next slice may have.

    Attributes
    ----------
    means : (2, n, channels) array or None    After the last pass that was finished, as pixels share what is even.
    smoothed : (n,) array or float    Square of the error of the luminance that sharing makes.
    """

    def __init__(self, light: PixelLight, camera, lanes):
        self.light, self._lanes = light, lanes
        self._pixels = camera.width * camera.height
        costs = {kind: COSTS[kind] for kind in light.kinds}
        self.allocation = Allocation(camera.width, camera.height, costs, FLOORS)
        shape = (GROUPS, self._pixels, light.channels.count)
        self._sums = {kind: np.zeros(shape, dtype=np.float32) for kind in light.kinds}
        squares = (len(STEERING), GROUPS, self._pixels)
        self._squares = {kind: np.zeros(squares, dtype=np.float32) for kind in light.kinds}
        self.means: np.ndarray | None = None
        self.smoothed: np.ndarray | float = 0.0
        self._sharing = self._shared = None

    def make(self, left: float):
        """Make one pass; a generator that pauses after every slice and gives the pixels that have got all kinds, or None.

        ``left``: samples of a pixel in a half that are wanted yet, on the mean.
        """
        cells, allocation = self.light.cells, self.allocation
        spent = GROUPS * allocation.samples * len(self._sums) * self._pixels
        if (cells.sweeps + 1) * cells.work <= SWEEP_SHARE * spent:
            for _ in cells.refreshing():
                yield None
                cells.cut(self._lanes())
        added = self._choose(left)
        if allocation.samples:
            for kind, more in added.items():
                units = allocation.units(kind, more)
                for part in () if units is None else self._cut(units):
                    yield from self._take(kind, part)
                    yield None
        else:
            # All kinds of some pixels together, so that they can be shown.
            first = 0
            while first < self._pixels:
                rows = np.arange(first, min(first + self._lanes(), self._pixels))
                part = Units(rows, np.zeros(len(rows), dtype=np.int64), 1, np.zeros(0))
                for kind in added:
                    yield from self._take(kind, part)
                    yield None
                yield rows
                first = int(rows[-1]) + 1
        allocation.extend(added)
        yield from self._share()

    def mean_of(self, rows: np.ndarray) -> np.ndarray:
        """Sum over all kinds at some pixels in the first pass, mean of both halves. (k, channels)"""
        return sum(each[:, rows].mean(axis=0) for each in self._sums.values())

    # ---- private ----

    def _share(self):
        """Find the means of all light, and share between pixels what is even; a generator that pauses after every step."""
        means = {kind: self._mean(kind) for kind in self._sums}
        whole = sum(means.values())
        if self.allocation.samples >= SHARED:
            light = self.light
            if self._sharing is None:
                steps = finding_sharing(
                    light.scene, light.film, light.channels, True, LOOKING_LANES
                )
                for self._sharing in steps:
                    yield None
            # What is shared now goes by how samples scatter without.
            self._shared = None
            variances = {kind: self._variances(kind, 0) * GROUPS for kind in self._sums}
            steps = self._sharing.sharing(means, variances)
            for self._shared in steps:
                yield None
            whole = whole + self._shared.change
            mean = whole[..., 1].mean(axis=0)
            scale = np.maximum(mean, max(float(mean.mean()), 1e-30))
            luminance = self._shared.change[..., 1:2]
            self.smoothed = self._sharing.smoothed_away(luminance, scale)[:, 0]
        self.means = whole.astype(np.float64)

    def _choose(self, left: float) -> dict[int, np.ndarray]:
        """Samples of the next pass by kind and tile."""
        allocation = self.allocation
        done = allocation.samples
        if not done:
            return allocation.begin()
        if done < EVEN <= left:
            return allocation.double()
        budget = max(GROWTH * done, LEAST_MEAN)
        if left - budget < LEAST * done:
            budget = left
        luminance = self.means[..., 1].mean(axis=0)
        scale = np.maximum(luminance, max(float(luminance.mean()), 1e-30)) ** 2
        squares = {kind: self._scatter(kind, 0) / scale for kind in self._sums}
        return allocation.choose(squares, budget, left)

    def _mean(self, kind: int) -> np.ndarray:
        count = np.maximum(self.allocation.of_pixels(kind), 1)
        return self._sums[kind] / count[:, None]

    def _scatter(self, kind: int, number: int) -> np.ndarray:
        """Variance of the mean of a kind's samples, as single samples scatter and once it is shared. (n,)"""
        scatter = self._variances(kind, number).mean(axis=0)
        return scatter if self._shared is None else scatter * self._shared.left[kind]

    def _variances(self, kind: int, number: int) -> np.ndarray:
        """Variance of the mean of a kind's samples, as those of each half scatter. (2, n)"""
        count = self.allocation.of_pixels(kind)
        mean = self._mean(kind)[..., STEERING[number]]
        around = np.maximum(self._squares[kind][number] / count - mean**2, 0.0)
        return around / (GROUPS * np.maximum(count - 1, 1))

    def _cut(self, units: Units):
        """Yield parts of units that fit a slice."""
        first = 0
        while first < len(units.lumel):
            part = slice(first, first + max(self._lanes() // units.samples, 1))
            first = part.stop
            yield Units(units.lumel[part], units.first[part], units.samples, units.levels)

    def _take(self, kind: int, part: Units):
        """Take the samples of a part for both halves."""
        begins = np.flatnonzero(np.diff(part.lumel, prepend=-1))
        rows = part.lumel[begins]
        for half in range(GROUPS):
            if half:
                yield None
            self.light.cells.use(half)
            sums = np.add.reduceat(self.light.sum(kind, part, half), begins, axis=0)
            values, squares = np.split(sums, [-len(STEERING)], axis=1)
            self._sums[kind][half][rows] += values
            self._squares[kind][:, half, rows] += squares.T
