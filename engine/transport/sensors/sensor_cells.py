"""Cells of what sensors look at, with light that is found apart for every group of samples.

The groups share where cells lie and the light of late reflections, but no samples of the sweeps after that. So the noise of
the cells, which all samples of a group have in common, shows in how the groups differ like all other noise.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ..lux_maps.cell_guide import Guide
from ..lux_maps.cell_iterations import Sweeper
from ..lux_maps.cell_reader import NEAR
from ..lux_maps.cells import CellSet
from ..paths.visible_surfaces import Sight

CELLS = 12_000
"""How many cells there are, about, whatever the number of sensors: each of them looks at all of a room."""

NEAR_SHARE, MOST_FINER = 0.1, 2.0
"""Share of rays that may land too near for cells to be read before there are more of them, and how many times more."""

LOOKS = 1 << 16
"""Rays that find which surfaces matter."""

SWEPT, MOST_SWEPT = 1 << 18, 64
"""Paths of a sweep for all groups together, about, and most samples of a cell and turn in it."""

APART = 2
"""Sweeps of a group before one counts: what the groups have in common loses with each what surfaces absorb."""

CAREFUL = 1 << 19
"""Paths of the sweep that finds out which cells are uneven."""

FIRST_SWEEP = 1 << 20
"""Number before that of the first sweep of a group; no two have the same."""


class SensorCells:
    """Cells for sensors.

    Parameters
    ----------
    scene : CompiledScene    With its lights over bends, if there are any.
    places, normals : (n, 3) array    Where sensors look from, in the scene's frame [m], and whereto.
    groups : int    Independent groups of samples.
    seed : int
    cancelled : callable    Asked before every launch.

    Attributes
    ----------
    cells : CellSet
    guide : Guide or None    Points on bright cells beside rays.
    sweeps : int    How often the light of each group was found.
    counts : (2,) array    Samples of the sweeps that were no numbers, and all.
    """

    def __init__(self, scene, places, normals, groups: int, seed: int, cancelled):
        rows = np.random.default_rng([seed & 0xFFFFFFFF, 6]).integers(0, len(places), LOOKS)
        sight = Sight(scene, places[rows], normals[rows], seed)

        def refine(sizes: np.ndarray) -> float:
            finer = (sight.near_share(NEAR * sizes) / NEAR_SHARE) ** 2
            return float(np.clip(finer, 1.0, MOST_FINER))

        self.cells = CellSet(scene, CELLS, sight.shares, refine)
        self.guide, self.sweeps = None, 0
        self.counts = np.zeros(2, dtype=np.int64)
        self._groups, self._made, self._samples = groups, 0, 1
        self._tables: list[np.ndarray] = []
        self._sweeper = None
        if not self.cells:
            return
        self._sides, looks = sight.sides(self.cells)
        left_out = None if scene.bent is None else scene.bent.left_out
        self._sweeper = Sweeper(scene, self.cells, self._sides, seed, cancelled, left_out, looks)

    def __bool__(self) -> bool:
        """Whether there is anything to read."""
        return bool(self.cells)

    @property
    def work(self) -> int:
        """Paths of a sweep of all groups."""
        return self._groups * self._samples * self._sweeper.lanes_per_sample

    @property
    def lost_share(self) -> float:
        """Share of the samples that were no numbers. [-]"""
        return float(self.counts[0] / max(self.counts[1], 1))

    def prepare(self, samples: float | None) -> None:
        """Find the light of all cells. ``samples``: of the job, where their number is known."""
        self._sweeper.find(samples, CAREFUL)
        guide = Guide(self.cells, None, self._sides)
        self.guide = self._sweeper.guide = guide if guide.is_useful else None
        lanes = self._groups * max(self._sweeper.lanes_per_sample, 1)
        self._samples = 1 << int(np.clip(round(np.log2(SWEPT / lanes)), 0, np.log2(MOST_SWEPT)))
        self._tables = [np.array(self.cells.values) for _ in range(self._groups)]
        for _ in range(APART):
            self.sweeps = 0
            self.refresh()

    def refresh(self) -> None:
        """Sweep once more for each group; what is read is the mean over all sweeps of it."""
        self.sweeps += 1
        for group in range(self._groups):
            self.use(group)
            self._made += 1
            self._sweeper.refresh(FIRST_SWEEP + self._made, self._samples)
            self.counts = self.counts + self._sweeper.counts
            made = np.array(self.cells.values)
            self._tables[group] += (made - self._tables[group]) / self.sweeps

    def use(self, group: int) -> None:
        """Have the light of a group read."""
        self.cells.values = upload(mi.Float, self._tables[group])
        dr.eval(self.cells.values)
