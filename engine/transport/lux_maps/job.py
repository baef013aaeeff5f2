"""The lux map job: passes over all lumels, each an independent replicate of the whole map.

A pass gives every lumel an unbiased estimate from low-discrepancy points of its own scramble and from cells that were
swept anew with points of their own, so passes differ by chance alone: their scatter is the error, which falls as one over
the root of their number. Direct light and interreflection are estimated apart, each with as many samples as a pilot has
found best for every tile of the maps: in proportion to the scatter, and to the root of the area over the cost (Neyman's
allocation).
"""

from dataclasses import dataclass

import numpy as np

from ...errors import Cancelled
from ..light_tracing.bent_lights import BentLights
from ..light_tracing.straight_lights import StraightLights
from ..paths import gather
from ..paths.light_learning import learn
from ..paths.visible_surfaces import Sight
from ..paths.wavelengths import make_sampler
from .cell_guide import Guide, choose_spots
from .cell_iterations import Sweeper
from .cell_reader import NEAR
from .cells import CellSet
from .levels import (
    ALL_KINDS,
    DIRECT,
    GATHERED,
    GUIDED,
    KINDS,
    LANES,
    MIRRORED,
    Levels,
    Units,
    batches,
)
from .losses import CELLS, LUMELS, TRACED, Losses
from .lumel_light import LumelLight
from .lumel_places import LumelPlaces
from .path_guiding import BINS, find_densities
from .survey import Survey

PILOT_SAMPLES = 2
"""Samples of a lumel in a pass of the pilot, of each kind."""

CELLS_PER_LUMEL = 1.0 / 8.0
FEWEST_CELLS, MOST_CELLS = 8_000, 300_000
"""How many cells there are: as many as serve the lumels, within bounds."""

NEAR_SHARE, MOST_FINER = 0.1, 4.0
"""Share of rays that may land too near for cells to be read before there are more of them, and how many times more."""

LOOKS, FEWEST_LOOKS = 4, 1 << 15
"""Rays for every cell that find which surfaces a job looks at, and the fewest of all."""

LEARNING = 1 << 14
"""Places from which the choice of lights learns."""

CHECK_INTERVAL = 4
"""Passes from check to check."""

SWEEP_SHARE = 0.1
"""Work of the sweep before a pass, relative to that of the pass: noise of cells is a few hundredths of all. [-]"""

FEWEST_SWEPT = 1 << 15
"""About how many paths such a sweep has at least. What lumels share does not average out over a map, least of all in bright
rooms."""

CHECK_SHARE, FEWEST_CHECKS, MOST_CHECKS = 0.01, 1 << 14, 1 << 19
"""Paths that compare the cells with full paths, relative to the samples of a pass, and bounds on their number."""

TRACE_SHARES = (0.125, 0.5, 2.0)
"""Paths from the lights in a pass, relative to its samples: fewest, of the pilot, and most. [-]"""

TRACE_COST = 4.0
"""Work of such a path, relative to a sample of a lumel. [-]"""

TRACED_PATHS = (1 << 16, 1 << 22)
"""Fewest and most of them."""

TRACE_STRIDE = 1_000_003
"""Distance between the points of one seed and the next."""

CHECK_SALT = 19
"""Sets the points of the checks apart."""


@dataclass(frozen=True)
class Options:
    """How a job works; all but the first two are for measuring what each of them is worth.

    Parameters
    ----------
    cells : bool    Whether the radiance beyond the first bounce is read from cells.
    exitance : bool    Whether the light that leaves the surface is estimated too.
    qmc : bool    Low-discrepancy points instead of random numbers.
    direct_apart : bool    Numbers of samples of direct light and interreflection of their own.
    adaptive : bool    Numbers of samples by tile.
    guided : bool    Points on bright cells beside rays.
    aimed : bool    Rays where light comes from instead of by the cosine law alone.
    fineness : float    Factor on the number of cells. [-]
    """

    cells: bool = True
    exitance: bool = False
    qmc: bool = True
    direct_apart: bool = True
    adaptive: bool = True
    guided: bool = True
    aimed: bool = True
    fineness: float = 1.0


class LuxJob:
    """Estimates the illuminance of all lumels of a table.

    Parameters
    ----------
    scene : CompiledScene
    table : LumelTable    Validated.
    seed : int
    options : Options
    cancelled : callable    Asked before every launch.
    tracer : LightTracer or None    Traces from the lights what gathering cannot find over bends; None: nothing is traced.
    find_lumels : callable or None    Gives a `LumelFinder`, which knows the lumels on which traced light lands.
    missed : (n,) bool array or None
        Lumels on which it never lands, as on what takes no part in light: nothing is traced straight then, and these ask
        for what comes over bends as sensors do. None: there are none.
    """

    def __init__(
        self,
        scene,
        table,
        seed: int,
        options: Options,
        cancelled=lambda: False,
        tracer=None,
        find_lumels=None,
        missed: np.ndarray | None = None,
    ):
        self.scene, self.table, self.options, self.cancelled = scene, table, options, cancelled
        self.seed, self.tracer, self.finder = seed, tracer, None
        self._losses = Losses()
        self.straight: StraightLights | None = None
        self._sides: np.ndarray | None = None
        self.count = int(sum(table.counts))
        self.channels = 4 if options.exitance else 1
        self.sampler = make_sampler(scene, "colour" if options.exitance else "luminance")
        known = table.survey
        self.area, self.valid = known.area, known.valid
        self._left_out = None if tracer is None else tracer.left_out
        self._missed, self.bent = missed, None
        if missed is not None and tracer is not None:
            made = BentLights(scene)
            self.bent = made if made.is_needed else None
        self._learn(known)
        self.cells = self.sweeper = None
        self.traced: np.ndarray | None = None
        self._traced_counts = 0, 0
        try:
            if options.cells or tracer is not None:
                self._make_cells(known)
            self._traces = tracer is not None and (
                tracer.is_needed or (self.straight is not None and self.straight.is_needed)
            )
            if self._traces:
                self.finder = find_lumels()
            asking = None if self.bent is None else missed
            self.places = LumelPlaces(scene, table, known.places, asking)
        except BaseException:
            self.close()
            raise
        self.trace_share = TRACE_SHARES[1]
        self._light = LumelLight(
            scene,
            self.places,
            seed,
            self.sampler,
            self.cells,
            self.sweeper is not None,
            self._left_out,
            self.bent,
            options.qmc,
            options.exitance,
        )

    def close(self) -> None:
        """Leave the scene as other jobs expect it."""
        if self.straight is not None:
            self.straight.close()
        if self.tracer is not None:
            self.tracer.close()

    @property
    def guide(self) -> Guide | None:
        """Points on bright cells beside rays, None where there are none."""
        return self._light.guide

    @property
    def aims(self) -> dict[int, np.ndarray]:
        """Where rays go, by the first lumel of a span; empty while they go by the cosine law."""
        return self.places.aims

    @property
    def kinds(self) -> tuple[int, ...]:
        """Kinds of samples that this scene needs."""
        is_needed = {GUIDED: self.guide is not None, MIRRORED: self.scene.mirrors is not None}
        return tuple(kind for kind in ALL_KINDS if is_needed.get(kind, True))

    def prepare(self, samples: float | None = None) -> None:
        """Find the light of the cells. ``samples``: how many each lumel will get at most, where it is known."""
        self._trace(0, TRACED_PATHS[0])
        if self.sweeper is not None:
            if self.cells.traced is not None:
                # What was traced to small spots would be found by chance only.
                self._set_guide(None)
            self.sweeper.find(None if samples is None else samples * self.count)
            self._set_guide(None)

    def _set_guide(self, powers) -> None:
        if self.options.guided:
            guide = Guide(self.cells, powers, self._sides)
            self._light.guide = self.sweeper.guide = guide if guide.is_useful else None

    def state(self) -> dict[str, np.ndarray]:
        """State of the cells and of what is derived from them."""
        made = {f"aims.{first}": table for first, table in self.aims.items()}
        made["trace_share"] = np.array([self.trace_share])
        if self.sweeper is not None:
            made |= self.sweeper.state()
        if self.guide is not None:
            made["powers"] = self.guide.powers
        return made

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Go on from a state, in place of `prepare`."""
        head = "aims."
        aims = {int(k[len(head) :]): v for k, v in state.items() if k.startswith(head)}
        self.places.set_aims(aims)
        self.trace_share = float(
            np.clip(state["trace_share"][0], TRACE_SHARES[0], TRACE_SHARES[-1])
        )
        if self.sweeper is not None:
            self.sweeper.restore(state)
            if "powers" in state:
                self._set_guide(state["powers"])

    def run_pass(
        self, number: int, levels: Levels, progress=None
    ) -> list[tuple[slice, np.ndarray]]:
        """Make one replicate, of cells as they were left by `refresh`.

        Parameters
        ----------
        number : int    Of the pass; no two may be alike.
        levels : Levels
        progress : callable or None    Called with the share of the pass that is done.

        Returns
        -------
        list of (slice, (k, channels) array)    Estimates of all lumels, span by span.
        """
        self._losses = Losses()
        return [
            (part, values.sum(axis=0).astype(np.float32))
            for part, values in self.estimates(number, levels, progress)
        ]

    def losses(self) -> Losses:
        """What the last pass lost, and the light of cells and the traced light that it used."""
        made = self._losses
        if self.sweeper is not None:
            made.counts[CELLS] = self.sweeper.counts
        made.counts[TRACED] = self._traced_counts
        return made

    def object_means(self, made, objects: np.ndarray, count: int) -> np.ndarray:
        """Means that a pass gave the objects. ``objects``: number of the object of every lumel. (count,) [lx]"""
        light, surface = np.zeros(count), np.zeros(count)
        for part, values in made:
            area = np.where(self.valid[part], self.area[part], 0.0)
            light += np.bincount(objects[part], values[:, 0] * area, count)
            surface += np.bincount(objects[part], area, count)
        return light / np.maximum(surface, 1e-300)

    def estimates(self, number: int, levels: Levels, progress=None, kinds=ALL_KINDS):
        """Estimates of all lumels, span by span. ``kinds``: those that are made.

        Yields
        ------
        (part, values)    Slice of the lumels, and (4, k, channels) values by kind.
        """
        total, done = max(self.count, 1), 0.0
        for span in self.places.spans:
            count = span.stop - span.start
            values = np.zeros((len(KINDS), count, self.channels))
            columns, shares = levels.columns[:, span], {}
            for kind in kinds:
                column = columns[kind]
                for units in batches(column, self.valid[span]):
                    for part in units.split():
                        if self.cancelled():
                            raise Cancelled("cancelled")
                        sums, lost = self._light.sum(span, kind, part, number, columns)
                        part.add(sums, values[kind])
                        self._losses.note(LUMELS, int(lost.sum()), len(lost) * part.samples)
                        if lost.any():
                            own = shares.setdefault(kind, np.zeros((count, 1)))
                            part.add(lost[:, None].astype(np.float64), own)
                    if progress is not None:
                        progress(min((done + count * (kind + 0.5) / len(KINDS)) / total, 1.0))
            done += count
            if shares:
                most = np.concatenate(list(shares.values()), axis=1).max(axis=1)
                self._losses.note_shares(span, most, self.count)
            if self.traced is not None:
                self._add_traced(values[GATHERED], self.traced[span])
            yield span, values

    def _add_traced(self, values: np.ndarray, light: np.ndarray) -> None:
        """Add traced light to the rest; the colour that leaves is that of other light, for want of a spectrum by lumel."""
        before = values[:, :1]
        ratio = np.divide(values, before, out=np.zeros_like(values), where=before > 0.0)
        ratio[:, 0] = 1.0
        values += ratio * light[:, None]

    def learn_aims(self, rays: int) -> dict[int, np.ndarray]:
        """Learn where tiles get their light from, for `set_ways`. ``rays``: through every bin of a tile."""
        aims = {}
        for span in self.places.spans:
            tiles = self.places.tiles(span)
            known = np.flatnonzero(self.valid[span])
            order = known[np.argsort(tiles[known], kind="stable")]
            many = np.bincount(tiles[known], minlength=int(tiles.max(initial=-1)) + 1)
            first = np.cumsum(many) - many
            squares = np.zeros((len(many), BINS))
            most = max(LANES // (BINS * rays), 1)
            used = np.flatnonzero(many)
            for start in range(0, len(used), most):
                if self.cancelled():
                    raise Cancelled("cancelled")
                part = used[start : start + most]
                squares[part] = self._light.look_around(span, order, first[part], many[part], rays)
            aims[span.start] = find_densities(squares)
        return aims

    def set_ways(self, guide: Guide | None, aims: dict[int, np.ndarray]) -> None:
        """Gather light with these points on bright cells, and with rays that are aimed so, from now on."""
        self.places.set_aims(aims)
        self._light.guide = guide
        if self.sweeper is not None:
            self.sweeper.guide = guide

    def compare(self, number: int, levels: Levels) -> tuple[np.ndarray, np.ndarray]:
        """Differences between reading cells and full paths at lumels that are drawn by area. (k,) lumels, (k,) [lx]"""
        if self.sweeper is None:
            return np.zeros(0, dtype=np.int64), np.zeros(0)
        chances = np.where(self.valid, self.area, 0.0)
        draw = np.random.default_rng([self.seed & 0xFFFFFFFF, number, 77])
        ends = np.cumsum(chances, dtype=np.float64)
        if number % CHECK_INTERVAL or not self.valid.any():
            return np.zeros(0, dtype=np.int64), np.zeros(0)
        share = CHECK_INTERVAL * CHECK_SHARE
        checks = int(np.clip(share * levels.total(), FEWEST_CHECKS, MOST_CHECKS))
        lumels = np.searchsorted(ends, draw.random(checks) * ends[-1], side="right")
        lumels = np.sort(np.minimum(lumels, self.count - 1))
        found = np.zeros(len(lumels))
        for span in self.places.spans:
            low, high = np.searchsorted(lumels, [span.start, span.stop])
            if low == high:
                continue
            if self.cancelled():
                raise Cancelled("cancelled")
            ones = Levels.even(span.stop - span.start, 1, (DIRECT, GATHERED, MIRRORED)).columns
            # Numbers of their own, since some lumels are drawn more than once.
            units = Units(lumels[low:high] - span.start, np.arange(high - low), 1, ones[GATHERED])
            read, full = (
                self._light.sum(span, GATHERED, units, number, ones, CHECK_SALT, exact)[0][:, 0]
                for exact in (False, True)
            )
            found[low:high] = read - full
        return lumels, found

    # ---- private ----

    def _make_cells(self, known: Survey) -> None:
        """Cut what is seen into cells, and prepare what finds their light."""
        options = self.options
        wanted = int(np.clip(self.count * CELLS_PER_LUMEL, FEWEST_CELLS, MOST_CELLS))
        most = max(MOST_CELLS / wanted, 1.0)
        sight = self._look(known, LOOKS * int(wanted * min(MOST_FINER * options.fineness, most)))

        def refine(sizes: np.ndarray) -> float:
            # Where much is near at hand, such as seats in rows, finer cells can be read more often. On top of that: what
            # cells add falls with their number, however many of them nearness asks for.
            finer = (sight.near_share(NEAR * sizes) / NEAR_SHARE) ** 2
            return min(min(max(finer, 1.0), MOST_FINER) * options.fineness, most)

        self.cells = CellSet(self.scene, wanted, sight.shares, refine)
        if not (self.cells and options.cells):
            return
        self._sides, looks = sight.sides(self.cells)
        if self.tracer is not None and self._missed is None:
            places = PILOT_SAMPLES * self.count
            sampler = None if self.sampler is None else self.tracer.sampler
            worth = sight.worth(self.cells, self._sides, looks)
            self.straight = StraightLights(
                self.scene, sampler, self.cells, self._sides, places, worth, leaves_out=True
            )
        self.sweeper = Sweeper(
            self.scene, self.cells, self._sides, self.seed, self.cancelled, self._left_out, looks
        )

    def _look(self, known: Survey, rays: int) -> Sight:
        """What there is to be seen, by so many rays at least."""
        rows = known.draw(max(rays, FEWEST_LOOKS), self.seed)
        places = self.scene.local(known.positions)
        return Sight(self.scene, places[rows], known.normals[rows], self.seed)

    def _learn(self, known: Survey) -> None:
        """Let the choice of lights learn what arrives at the lumels."""
        rows = known.draw(LEARNING, self.seed)
        places = self.scene.local(known.positions[rows])
        learn(self.scene, places, known.normals[rows], gather.typical_wavelengths())

    def paths(self, levels: Levels, part: float = 1.0) -> int:
        """Paths that are traced from the lights for a part of a pass; a power of two, 0 where none are."""
        if not self._traces:
            return 0
        wanted = max(self.trace_share * levels.total() * part, 1.0)
        return 1 << int(np.clip(np.log2(wanted), *np.log2(TRACED_PATHS)))

    def trace(self, number: int, levels: Levels, part: float = 1.0) -> None:
        """Trace from the lights anew, for a part of a pass."""
        self._trace(number, self.paths(levels, part))

    def refresh(self, number: int, levels: Levels) -> None:
        """Trace from the lights and sweep the cells anew, for a pass."""
        self.trace(number, levels)
        self.sweep(number, levels)

    def sweep(self, number: int, levels: Levels) -> None:
        """Sweep the cells anew, for a pass."""
        if self.sweeper is None:
            return
        # In whole powers of two.
        work = max(SWEEP_SHARE * levels.total(), FEWEST_SWEPT)
        work /= max(self.sweeper.lanes_per_sample, 1)
        self.sweeper.refresh(number, 1 << int(np.clip(round(np.log2(max(work, 1.0))), 0, 6)))

    def _trace(self, number: int, count: int) -> None:
        """Trace light to lumels and cells; ``traced`` has it by lumel until the next time. [lx]"""
        if not self._traces:
            return
        seed = (self.seed * TRACE_STRIDE + number) & 0xFFFFFFFF
        found = self.tracer.trace(count, seed, straight=self.straight)
        self._traced_counts = found.lost, found.lost + len(found.flux)
        lumel = self.finder.find(found.shape, found.prim, found.uv, found.back)
        landed = (lumel >= 0) & (found.geometric_cosine > 0.0)
        light = found.flux * found.cosine / np.maximum(found.geometric_cosine, 1e-6)
        flux = np.bincount(lumel[landed], light[landed], self.count)
        known = self.valid & (self.area > 0.0)
        self.traced = np.where(known, flux / np.where(self.area > 0.0, self.area, 1.0), 0.0)
        if self.cells:
            self.cells.put_traced(found)
            self.cells.spots = choose_spots(self.cells, self._sides)
