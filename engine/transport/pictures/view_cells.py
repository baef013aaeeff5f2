"""Cells of what a camera or sensors see, with light that is found apart for every group of samples.

A picture has two groups, its halves. They share where cells lie and the light of late reflections, but no samples of the
sweeps after that. So the noise of the cells, which many pixels have in common, shows in how the groups differ like all
other noise.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...photometry.units import MINIMUM_WAVELENGTH
from ..compiled.changes import Stamps
from ..compiled.diffuse import DiffuseTable
from ..lux_maps.bands import Bands
from ..lux_maps.cell_guide import Guide
from ..lux_maps.cell_iterations import QUARTERS, Sweeper, finish
from ..lux_maps.cell_reader import NEAR
from ..lux_maps.cells import CellSet
from ..paths.film import GROUPS
from ..paths.visible_surfaces import Sight

NEAR_SHARE, MOST_FINER = 0.1, 2.0
"""Share of rays that may land too near for cells to be read before there are more of them, and how many times more."""

SWEPT, MOST_SWEPT = 1 << 18, 64
"""Paths of a sweep for all groups together, about, and most samples of a cell and turn in it."""

APART = 2
"""Sweeps of a group before one counts: what the groups have in common loses with each what surfaces absorb."""

CAREFUL = 1 << 18
"""Paths of the sweep that finds out which cells are uneven. Pictures are ready when lux maps have just begun."""

FIRST_SWEEP = 1 << 20
"""Number before that of the first sweep of a group; no two have the same."""

SLACK = 1.5
"""How many times more cells a view may want, and how much larger a share of its rays may land too near, before surfaces are
divided anew. [-]"""


class Division:
    """How surfaces are divided into cells, and which of these may be seen.

    Parameters
    ----------
    scene : CompiledScene
    sight : Sight
    wanted : int    About how many cells.
    reads_all : bool    Whether sides that no look has met are read too, as long jobs read even those often.

    Attributes
    ----------
    cells : CellSet
    sides : (n,) uint32 array    Sides of cells that may be seen.
    looks : (2 c,) array    How often every side is looked at.
    read : (m,) uint32 array
        Sides that are read. Light of those that no look has met would be read too seldom to be worth its sweeps: paths go on
        there.
    turn : int    How many have used the cells. They hold what the last one of these has put into them.
    """

    def __init__(self, scene, sight: Sight, wanted: int, reads_all: bool = False):
        def refine(sizes: np.ndarray) -> float:
            finer = (sight.near_share(NEAR * sizes) / NEAR_SHARE) ** 2
            return float(np.clip(finer, 1.0, MOST_FINER))

        self._scene, self._wanted, self._stamps = scene, wanted, scene.stamps
        self.turn, self._reads_all = 0, reads_all
        self.cells = CellSet(scene, wanted, sight.shares, refine)
        self._near_share = sight.near_share(NEAR * self.cells.sizes)
        self.sides = np.zeros(0, dtype=np.uint32)
        self.looks = np.zeros(0)
        if self.cells:
            self.sides, self.looks = sight.sides(self.cells)
        self.read = self._choose_read()

    def serves(self, scene, sight: Sight, wanted: int) -> bool:
        """Whether another view, or another state of the scene, may have the same cells."""
        if scene is not self._scene or scene.stamps.objects != self._stamps.objects:
            return False
        if scene.shape_count != len(self.cells.sizes) or wanted > SLACK * self._wanted:
            return False
        if scene.stamps.surfaces != self._stamps.surfaces:
            matt = DiffuseTable(scene)
            if matt.shapes != self.cells.matt.shapes:
                return False
            self.cells.matt, self._stamps = matt, scene.stamps
        near = sight.near_share(NEAR * self.cells.sizes)
        return near <= SLACK * max(self._near_share, NEAR_SHARE)

    def look(self, sight: Sight, unknown: float) -> bool:
        """Turn to another view; tell whether more than a share of its looks are at sides that were not known. [-]"""
        if not self.cells:
            return False
        sides, looks = sight.sides(self.cells)
        is_known = np.zeros(len(looks), dtype=bool)
        is_known[self.read] = True
        self.looks = looks
        if looks[~is_known].sum() <= unknown * looks.sum():
            return False
        self.sides = np.union1d(self.sides, sides).astype(np.uint32)
        self.read = np.union1d(self.read, self._choose_read()).astype(np.uint32)
        return True

    def margin(self) -> np.ndarray:
        """Neighbours of sides that are read, which are not read themselves. (k,) uint32"""
        count = 2 * self.cells.count
        is_read, beside = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
        is_read[self.read] = True
        for face in (0, 1):
            a, b = (2 * each + face for each in self.cells.neighbours)
            beside[a[is_read[b]]] = True
            beside[b[is_read[a]]] = True
        return self.sides[(beside & ~is_read)[self.sides]]

    def _choose_read(self) -> np.ndarray:
        return self.sides if self._reads_all else self.sides[self.looks[self.sides] > 0.0]


@dataclass(frozen=True, eq=False)
class CellLight:
    """Light of the cells of a division, as it is before a picture begins.

    Parameters
    ----------
    stamps : Stamps    State of the scene.
    seed : int
    sides : (n,) uint32 array    Sides with light; all others are not read.
    uneven : (2 c,) bool array
    common : (n, nodes) float32 array    What all groups set out from, as a ratio to the mean light.
    groups : (g, n, nodes) float32 array
    counts : (2,) array    Samples of sweeps that were no numbers, and all.
    bands : Bands
    """

    stamps: Stamps
    seed: int
    sides: np.ndarray
    uneven: np.ndarray
    common: np.ndarray
    groups: np.ndarray
    counts: np.ndarray
    bands: Bands

    @property
    def bytes(self) -> int:
        """Memory that it takes."""
        return self.uneven.nbytes + self.common.nbytes + self.groups.nbytes + self.sides.nbytes

    def in_bands(self, bands: Bands) -> np.ndarray:
        """Return what the groups have in common as ratios to another mean light."""
        if bands.count == 1 or np.array_equal(bands.light, self.bands.light):
            return self.common
        old, new = (
            (each.light / each.light.max())[each.nodes - int(MINIMUM_WAVELENGTH)]
            for each in (self.bands, bands)
        )
        return self.common * np.divide(old, new, out=np.zeros(len(new)), where=new > 0.0)


class ViewCells:
    """Cells for a picture or for sensors.

    Parameters
    ----------
    scene : CompiledScene    With its lights over bends, if there are any.
    division : Division
    seed : int
    cancelled : callable    Asked before every launch.
    light : CellLight or None    To begin with; None: it is found from nothing.
    is_stale : bool    Whether ``light`` is that of another state of the scene, from which to set out.
    keep : callable or None    Gets the `CellLight` when it is there.
    samples : float or None    Of the job, where their number is known.
    groups : int    Independent groups of samples.

    Attributes
    ----------
    cells : CellSet
    guide : Guide or None    Points on bright cells beside rays.
    sweeps : int    How often the light of each group was found.
    counts : (2,) array    Samples of the sweeps that were no numbers, and all.
    notes : tuple of str    For people.
    """

    def __init__(
        self,
        scene,
        division: Division,
        seed: int,
        cancelled=lambda: False,
        light: CellLight | None = None,
        is_stale: bool = False,
        keep=None,
        samples: float | None = None,
        groups: int = GROUPS,
    ):
        self._groups = groups
        self.scene, self.cells, self.seed = scene, division.cells, seed
        self.guide, self.sweeps, self.notes = None, 0, ()
        division.turn += 1
        self._division, self._turn = division, division.turn
        self.counts = np.zeros(2, dtype=np.int64)
        self._made, self._samples = 0, 1
        self._tables: list[np.ndarray] = []
        self._on_device: list = [None] * self._groups
        self._light, self._is_stale, self._keep = light, is_stale, keep
        self._planned = samples
        self._sweeper = None
        if not self.cells:
            return
        self._sides = division.read
        if not np.array_equal(self.cells.bands.light, scene.mean_light):
            self.cells.bands = Bands(scene.mean_light)
        left_out = None if scene.bent is None else scene.bent.left_out
        self._sweeper = Sweeper(
            scene,
            self.cells,
            self._sides,
            seed,
            cancelled,
            left_out,
            division.looks,
            division.margin(),
        )

    def __bool__(self) -> bool:
        """Whether there is anything to read."""
        return bool(self.cells)

    @property
    def is_current(self) -> bool:
        """Whether nobody else has used the cells since."""
        return self._division.turn == self._turn

    @property
    def work(self) -> int:
        """Paths of a sweep of all groups."""
        return self._groups * self._samples * self._sweeper.lanes_per_sample

    @property
    def lost_share(self) -> float:
        """Share of the samples that were no numbers. [-]"""
        return float(self.counts[0] / max(self.counts[1], 1))

    def cut(self, lanes: int) -> None:
        """Have no more samples in a launch."""
        self._sweeper.lanes = lanes

    def prepare(self) -> None:
        """Find the light of all cells."""
        finish(self.preparing())

    def preparing(self):
        """As `prepare`, but a generator that pauses after every launch."""
        light, sweeper = self._light, self._sweeper
        self._restore(light)
        if light is None or self._is_stale:
            yield from sweeper.finding(self._planned, CAREFUL, light is not None, QUARTERS)
        guide = Guide(self.cells, None, self._sides)
        self.guide = sweeper.guide = guide if guide.is_useful else None
        wanted = np.log2(SWEPT / (self._groups * max(sweeper.lanes_per_sample, 1)))
        self._samples = 1 << int(np.clip(round(wanted), 0, np.log2(MOST_SWEPT)))
        common = np.array(self.cells.values)
        if light is not None and not self._is_stale and light.seed == self.seed:
            self._tables = [self._spread(light.sides, each) for each in light.groups]
            self.counts, self.sweeps, self._made = light.counts, 1, APART * self._groups
        else:
            self._tables = [np.array(common) for _ in range(self._groups)]
            for _ in range(APART):
                self.sweeps = 0
                yield from self.refreshing()
        self._on_device = [None] * self._groups
        if self._keep is not None:
            self._keep(self._describe(common))

    def refresh(self) -> None:
        """Sweep once more for each group; what is read is the mean over all sweeps of it."""
        finish(self.refreshing())

    def refreshing(self):
        """As `refresh`, but a generator that pauses after every launch."""
        self.sweeps += 1
        for group in range(self._groups):
            self._made += 1
            self._on_device[group] = None
            self.use(group)
            yield from self._sweeper.refreshing(FIRST_SWEEP + self._made, self._samples)
            self.counts = self.counts + self._sweeper.counts
            made = np.array(self.cells.values)
            self._tables[group] += (made - self._tables[group]) / self.sweeps
            self._on_device[group] = None

    def use(self, group: int) -> None:
        """Have the light of a group read."""
        if self._on_device[group] is None:
            self._on_device[group] = upload(mi.Float, self._tables[group])
            dr.eval(self._on_device[group])
        self.cells.values = self._on_device[group]

    def use_mean(self) -> None:
        """Have the mean light of all groups read, which is what their pictures have together."""
        self.cells.values = upload(mi.Float, np.mean(self._tables, axis=0))
        dr.eval(self.cells.values)

    # ---- private ----

    def _restore(self, light: CellLight | None) -> None:
        """Have the cells hold what they begin with."""
        cells = self.cells
        if light is None:
            cells.values = dr.zeros(mi.Float, max(2 * cells.count * cells.bands.count, 1))
            uneven = np.ones(max(2 * cells.count, 1), dtype=bool)
            uneven[self._sides] = False
            cells.uneven = upload(mi.Bool, uneven)
            dr.eval(cells.values, cells.uneven)
            return
        values = self._spread(light.sides, light.in_bands(cells.bands))
        sides = self._sides if self._is_stale else light.sides
        self._sweeper.restore({"values": values, "uneven": light.uneven, "sides": sides})

    def _spread(self, sides: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Values of all sides, flat, from those of some."""
        table = np.zeros((2 * self.cells.count, self.cells.bands.count), dtype=np.float32)
        table[sides] = rows
        return table.ravel()

    def _describe(self, common: np.ndarray) -> CellLight:
        nodes, sides = self.cells.bands.count, self._sweeper.state()["sides"]
        return CellLight(
            self.scene.stamps,
            self.seed,
            sides,
            np.array(self.cells.uneven),
            common.reshape(-1, nodes)[sides],
            np.stack([table.reshape(-1, nodes)[sides] for table in self._tables]),
            self.counts,
            self.cells.bands,
        )
