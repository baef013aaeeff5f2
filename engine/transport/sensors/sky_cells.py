"""What the sides of cells have of the sky and of suns, as sensors do: so sensors need not look farther than to them.

Cells are traced like sensors, by paths from points all over them, and every group has its own. What a cell has is the same
for all that look at it, so what scatters behind it is found once, for any number of sensors.
"""

import time
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...accuracy.estimate import Estimate
from ...accuracy.stopping import StopRule
from ...arrays import upload
from ...errors import Cancelled
from ..lux_maps.cell_division import PLACES
from ..lux_maps.cell_iterations import SIGNIFICANT, UNEVEN
from ..paths import gather
from ..paths.sampler import hash_words, random_stream, sobol_pair
from .sky_paths import QUARTERS, SkyTable, read_sums, trace_sensors

SALT = 0x5C311
"""Sets the paths of cells apart from those of sensors."""

LANES = 1 << 20
"""Paths of a launch."""

TABLE_BYTES = 300 << 20
"""Memory for the sums of a block of cells."""

FEWEST, MOST = 16, 1 << 12
"""Paths of a cell in a group: in the first pass, and of one pass."""

SENSORS = 64
"""As many paths as so many sensors have, all cells together, where there are as many sensors."""

WIDER = 4.0
"""What a cell's error may be of that which sensors are allowed: they look at many cells. [-]"""

SHARE_OF_TIME = 0.3
"""Of a job that ends by the clock."""


@dataclass(frozen=True, eq=False)
class CellSky:
    """What sides of cells have, of what passes their coats.

    Parameters
    ----------
    light : (g, s b, nodes + 1 + m) float32 array    Of every node of the sky, of what is below the horizon, and of every
        sun, by group; the bands of a side lie side by side, each over its share of the light. [lx m2/cd], [-]
    shares : (b,) array    Of the bands. [-]
    doubts : (2, s, m) float32 array    Of the suns, as of `DaylightCoefficients`. [-]
    quarters : (s, 4) float32 array    Light of an even world of 1 cd/m2, by quarters. [lx]
    uneven : (s,) bool array    Sides with parts that have much more light than others, so that their mean is not read.
    lost : int    Paths that ended with no number.
    """

    light: np.ndarray
    shares: np.ndarray
    doubts: np.ndarray
    quarters: np.ndarray
    uneven: np.ndarray
    lost: int

    @property
    def even(self) -> np.ndarray:
        """Light of an even world of 1 cd/m2, by group and band. (g, s, b) [lx]"""
        many = self.doubts.shape[2]
        made = self.light[..., : self.light.shape[2] - many].sum(axis=2, dtype=np.float64)
        return made.reshape(len(made), -1, len(self.shares))

    @property
    def beyond(self) -> np.ndarray:
        """What quarters have more of it than all of the side. (s, 4) [lx]"""
        return self.quarters - self.quarters.mean(axis=1, keepdims=True)


@dataclass(frozen=True, eq=False)
class SunOnCells:
    """What of the suns passes the coats of sides of cells, for 1 lx on a plane that faces them.

    Parameters
    ----------
    mean : (s, m) float32 array    Where paths meet them. [-]
    half : (s, m) float32 array    Half of the difference between where paths of some sensors meet them and where those of
        the others do. [-]
    """

    mean: np.ndarray
    half: np.ndarray


class CellTracer:
    """Finds a `CellSky`.

    Parameters
    ----------
    scene, cells : CompiledScene, CellSet
    sides : (s,) uint32 array
    nodes : SkyNodes
    sun : SunOnCells
    sampler : WavelengthSampler or None
    bands : SkyBands
    turn : ((nodes, m) array, (nodes, m) array)    From sums by node to suns, and the same by nodes twice as far apart.
    seed, groups : int
    cancelled : callable    Asked before every launch.
    """

    def __init__(
        self,
        scene,
        cells,
        sides,
        nodes,
        sun,
        sampler,
        bands,
        turn,
        seed: int,
        groups: int,
        cancelled,
    ):
        self._scene, self._cells, self._sides, self._nodes = scene, cells, sides, nodes
        self._sun, self._turn, self._seed, self._groups = sun, turn, seed, groups
        self._cancelled, self._sampler = cancelled, sampler
        self._bands, self._device_bands = bands, bands.on_device()
        self._on_device = upload(mi.UInt32, sides)
        self._width = nodes.count + 1
        many = sun.mean.shape[1]
        rows = len(sides) * bands.count
        self._light = np.zeros((groups, rows, self._width + many), dtype=np.float32)
        self._over = np.zeros((len(sides), len(sides)), dtype=np.float32)
        self._rest = np.zeros((len(sides), nodes.count), dtype=np.float32)
        self._quarters = np.zeros((groups, len(sides), QUARTERS), dtype=np.float32)
        self._lost = 0

    def find(self, rule: StopRule, sensors: int, tell=lambda share: None) -> CellSky:
        """Trace until it is enough for sensors that stop by a rule.

        Parameters
        ----------
        rule : StopRule    Of the sensors.
        sensors : int    How many there are.
        tell : callable    Gets how much is done. [-]

        Raises
        ------
        Cancelled
        """
        begun, done, batch = time.perf_counter(), 0, self._first(rule, sensors)
        while True:
            for group in range(self._groups):
                self._trace(group, batch, done)
                tell((group + 1) / self._groups)
            done += batch
            if done >= self._needed(rule, done, time.perf_counter() - begun):
                break
            batch = min(done, MOST)
        light = self._light
        light /= np.float32(done)
        by_band = light.reshape(self._groups, len(self._sides), self._bands.count, -1)
        shares = self._bands.shares.astype(np.float32)[:, None]
        by_band /= np.maximum(shares, np.float32(1e-20))
        by_band[..., self._width :] += self._sun.mean[:, None]
        quarters = self._quarters * np.float32(QUARTERS / done)
        uneven = _find_uneven(quarters)
        each = np.float32(1.0 / (done * self._groups))
        by_nodes = (each * self._rest) @ (self._turn[0] - self._turn[1])
        over = each * self._over
        doubts = np.stack([by_nodes, over @ self._sun.half + self._sun.half])
        shares = self._bands.shares
        return CellSky(light, shares, doubts, quarters.mean(axis=0), uneven, self._lost)

    # ---- private ----

    def _first(self, rule: StopRule, sensors: int) -> int:
        if rule.samples is None:
            return FEWEST
        wanted = rule.samples * min(sensors, SENSORS) / (self._groups * max(len(self._sides), 1))
        return 1 << int(np.clip(round(np.log2(max(wanted, 1.0))), 4, np.log2(MOST)))

    def _needed(self, rule: StopRule, done: int, spent: float) -> float:
        """Paths of a cell and group after which it is enough, as it seems now."""
        ends = [np.inf]
        if rule.samples is not None:
            ends.append(done)
        if rule.error is not None:
            light = self._light[..., : self._width].sum(axis=2, dtype=np.float64)
            light = light.reshape(self._groups, -1, self._bands.count).sum(axis=2)
            error = Estimate.from_groups(light, done).relative_error()
            ends.append(done * (error / (WIDER * rule.error)) ** 2)
        if rule.seconds is not None:
            ends.append(done * SHARE_OF_TIME * rule.seconds / max(spent, 1e-9))
        return min(ends)

    def _trace(self, group: int, batch: int, done: int) -> None:
        """Paths of all cells in a group."""
        row_bytes = 8 * (2 * self._width + len(self._sides) + QUARTERS) * self._bands.count
        block = max(min(TABLE_BYTES // row_bytes, len(self._sides)), 1)
        for first in range(0, len(self._sides), block):
            count = min(block, len(self._sides) - first)
            bands = self._device_bands
            table = SkyTable(self._nodes, count, self._cells.count, self._sides, QUARTERS, bands)
            per_launch = max(LANES // batch, 1)
            for start in range(0, count, per_launch):
                if self._cancelled():
                    raise Cancelled("cancelled")
                self._launch(
                    table, group, first, start, min(per_launch, count - start), batch, done
                )
            self._add(table, group, slice(first, first + count))

    def _launch(self, table, group: int, first: int, start: int, rows: int, batch: int, done: int):
        lane = dr.arange(mi.UInt32, rows * batch)
        many = dr.opaque(mi.UInt32, int(batch))
        own, row = lane % many, dr.opaque(mi.UInt32, int(start)) + lane // many
        sample = dr.opaque(mi.UInt32, int(done)) + own
        side = dr.gather(mi.UInt32, self._on_device, dr.opaque(mi.UInt32, int(first)) + row)
        seed = hash_words(
            dr.opaque(mi.UInt32, int(group) + SALT), dr.opaque(mi.UInt32, self._seed & 0xFFFFFFFF)
        )
        own_seed = hash_words(side, seed)
        stream = random_stream(sample, own_seed)
        # Samples that follow one another are spread out together, so a quarter has those of a run.
        quarter = own * QUARTERS // many
        within = PLACES // QUARTERS
        number = dr.minimum(mi.UInt32(stream.next_float32() * within), within - 1)
        si, matt = self._cells.place(side, quarter * within + number)
        wavelengths = gather.draw_wavelengths(self._sampler, sample, own_seed)
        if wavelengths is not None:
            si.wavelengths = wavelengths
        is_matt = matt > 0
        trace_sensors(
            self._scene,
            table,
            self._cells,
            si,
            lambda cosine: 1.0 - self._cells.matt.coat(matt, cosine, is_matt),
            row,
            wavelengths,
            self._sampler,
            stream,
            (
                sobol_pair(sample, own_seed, gather.PAIR_LIGHT),
                sobol_pair(sample, own_seed, gather.PAIR_SCATTER),
            ),
            part=quarter,
        )
        table.evaluate()

    def _add(self, table: SkyTable, group: int, part: slice) -> None:
        """Add the sums of a block."""
        count, width, bands = part.stop - part.start, self._width, self._bands.count
        own = self._light[group, part.start * bands : part.stop * bands]
        own[:, :width] += read_sums(table.sky, count * bands, width)
        over = read_sums(table.cells, count * bands, len(self._sides))
        own[:, width:] += over @ self._sun.mean
        self._over[part] += over.reshape(count, bands, -1).sum(axis=1)
        # Hardly any cell looks at gloss.
        rest = read_sums(table.rest, count * bands, width)[:, :-1]
        rows = np.flatnonzero(rest.any(axis=1))
        if len(rows):
            own[rows, width:] += rest[rows] @ self._turn[0]
            self._rest[part] += rest.reshape(count, bands, -1).sum(axis=1)
        self._quarters[group, part] += read_sums(table.parts, count, QUARTERS)
        self._lost += int(np.array(table.lost).sum())


def _find_uneven(quarters: np.ndarray) -> np.ndarray:
    """Sides whose quarters (g, s, 4) differ by more than chance. (s,) bool"""
    made = Estimate.from_groups(quarters, 0)
    brightest, darkest = made.mean.max(axis=1), made.mean.min(axis=1)
    noise = np.sqrt((made.standard_error**2).mean(axis=1))
    differ = brightest - darkest > SIGNIFICANT * np.sqrt(2.0) * noise
    return differ & (brightest > UNEVEN * darkest)
