"""Cells of what a camera sees, with light that is found twice, for the even and for the odd half of a picture.

The halves share where cells lie and the light of late reflections, but no samples of the sweeps after that. So the noise of
the cells, which many pixels have in common, shows in the difference of the halves like all other noise.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ..lux_maps.cell_guide import Guide
from ..lux_maps.cell_iterations import Sweeper
from ..lux_maps.cell_reader import NEAR
from ..lux_maps.cells import CellSet
from ..paths.film import GROUPS
from ..paths.visible_surfaces import Sight

CELLS_PER_PIXEL = 1.0 / 64.0
FEWEST_CELLS, MOST_CELLS = 3_000, 60_000
"""How many cells there are: as many as serve the pixels, within bounds."""

NEAR_SHARE, MOST_FINER = 0.1, 2.0
"""Share of rays that may land too near for cells to be read before there are more of them, and how many times more."""

LOOKS, FEWEST_LOOKS = 4, 1 << 15
"""Rays for every cell that find which surfaces matter, and the fewest of all."""

SWEPT, MOST_SWEPT = 1 << 17, 64
"""Paths of the sweep of a half, about, and most samples of a cell and turn in it."""

APART = 2
"""Sweeps of a half before one counts: what the halves have in common loses with each what surfaces absorb."""

CAREFUL = 1 << 19
"""Paths of the sweep that finds out which cells are uneven. Pictures are ready when lux maps have just begun."""

FIRST_SWEEP = 1 << 20
"""Number before that of the first sweep of a half; no two have the same."""


class ViewCells:
    """Cells for a picture.

    Parameters
    ----------
    scene : CompiledScene    With its lights over bends, if there are any.
    places, normals : (n, 3) array    What the camera sees, in the scene's frame. [m]
    pixels : int
    seed : int
    cancelled : callable    Asked before every launch.

    Attributes
    ----------
    cells : CellSet
    guide : Guide or None    Points on bright cells beside rays.
    sweeps : int    How often the light of each half was found.
    counts : (2,) array    Samples of the sweeps that were no numbers, and all.
    """

    def __init__(self, scene, places, normals, pixels: int, seed: int, cancelled):
        self.scene = scene
        wanted = int(np.clip(pixels * CELLS_PER_PIXEL, FEWEST_CELLS, MOST_CELLS))
        rays = max(LOOKS * wanted, FEWEST_LOOKS)
        rows = np.random.default_rng([seed & 0xFFFFFFFF, 6]).integers(0, len(places), rays)
        sight = Sight(scene, places[rows], normals[rows], seed)

        def refine(sizes: np.ndarray) -> float:
            finer = (sight.near_share(NEAR * sizes) / NEAR_SHARE) ** 2
            return float(np.clip(finer, 1.0, MOST_FINER))

        self.cells = CellSet(scene, wanted, sight.shares, refine)
        self.guide, self.sweeps = None, 0
        self.counts = np.zeros(2, dtype=np.int64)
        self._made, self._samples = 0, 1
        self._tables: list[np.ndarray] = []
        self._sweeper = None
        if not self.cells:
            return
        sides, looks = sight.sides(self.cells)
        left_out = None if scene.bent is None else scene.bent.left_out
        self._sweeper = Sweeper(scene, self.cells, sides, seed, cancelled, left_out, looks)
        self._sides = sides

    def __bool__(self) -> bool:
        """Whether there is anything to read."""
        return bool(self.cells)

    @property
    def work(self) -> int:
        """Paths of the sweeps of both halves."""
        return GROUPS * self._samples * self._sweeper.lanes_per_sample

    @property
    def lost_share(self) -> float:
        """Share of the samples that were no numbers. [-]"""
        return float(self.counts[0] / max(self.counts[1], 1))

    def prepare(self, samples: float | None) -> None:
        """Find the light of all cells. ``samples``: of the picture, where their number is known."""
        self._sweeper.find(samples, CAREFUL)
        guide = Guide(self.cells, None, self._sides)
        self.guide = self._sweeper.guide = guide if guide.is_useful else None
        wanted = np.log2(SWEPT / max(self._sweeper.lanes_per_sample, 1))
        self._samples = 1 << int(np.clip(round(wanted), 0, np.log2(MOST_SWEPT)))
        self._tables = [np.array(self.cells.values) for _ in range(GROUPS)]
        for _ in range(APART):
            self.sweeps = 0
            self.refresh()

    def refresh(self) -> None:
        """Sweep once more for each half; what is read is the mean over all sweeps of it."""
        self.sweeps += 1
        for half in range(GROUPS):
            self.use(half)
            self._made += 1
            self._sweeper.refresh(FIRST_SWEEP + self._made, self._samples)
            self.counts = self.counts + self._sweeper.counts
            made = np.array(self.cells.values)
            self._tables[half] += (made - self._tables[half]) / self.sweeps

    def use(self, half: int) -> None:
        """Have the light of a half read."""
        self.cells.values = upload(mi.Float, self._tables[half])
        dr.eval(self.cells.values)
