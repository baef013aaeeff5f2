"""The lux map job: passes over all lumels, each an independent replicate of the whole map.

A pass gives every lumel an unbiased estimate from low-discrepancy points of its own scramble and from cells that were
swept anew with points of their own, so passes differ by chance alone: their scatter is the error, which falls as one over
the root of their number. Direct light and interreflection are estimated apart, each with as many samples as a pilot has
found best for every tile of the maps: in proportion to the scatter, and to the root of the area over the cost (Neyman's
allocation).
"""

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...errors import Cancelled
from ...photometry.spectra import observer
from ..compiled.textures import is_spectral
from ..light_tracing.bent_lights import BentLights
from ..light_tracing.straight_lights import StraightLights
from ..paths import gather
from ..paths.cached_gather import NEAR
from ..paths.light_learning import learn
from ..paths.sampler import hash_words, random_stream, sobol_pair
from ..paths.visible_surfaces import Sight
from ..paths.wavelengths import WavelengthSampler
from .cell_iterations import Sweeper
from .cells import CellSet
from .guide import Guide, choose_spots
from .path_guiding import BINS, SIDE, Aims, Cosine, find_densities
from .receiving import Receiver, direct, gathered, mirrored
from .survey import Survey
from .tiles import tile_numbers

PILOT_SAMPLES = 2
"""Samples of a lumel in a pass of the pilot, of each kind."""

LANES = 1 << 20
"""Samples of one launch: a fraction of a second each, so that a cancel is heard soon."""

KINDS = ("direct", "gathered", "guided", "mirrored")
"""Ways in which light is sampled: next-event to lights, rays, points on bright cells, next-event over plane mirrors."""

ALL_KINDS = DIRECT, GATHERED, GUIDED, MIRRORED = 0, 1, 2, 3

COSTS = (1.0, 2.5, 1.5, 1.1)
"""What a sample of each kind costs, relative to next-event; measured in rooms."""

SAMPLE_COST = COSTS[DIRECT] + COSTS[GATHERED]
"""Cost of what counts as one sample."""

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

CHECK_SALT, AIM_SALT = 19, 23
"""Set the points of the checks, and of the rays that aims are learned from, apart."""

SPAN_PLACES, KEPT_SPANS = 1 << 21, 2
"""Places of lumels that are worked on together, and how many such lots stay on the device."""

FEW, MOST_UNITS = 3, 1 << 22
"""Level below which lumels are worked on apart from the others, where there are more samples than this."""

NO_SAMPLES = 255
"""Level of lumels that get nothing."""


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


SAMPLE_COUNTS = np.append(2.0 ** np.arange(NO_SAMPLES), 0.0)
"""By level."""


@dataclass(frozen=True)
class Levels:
    """Samples of every lumel in a pass: two to the power of the level, by `KINDS`. (4, n) uint8"""

    columns: np.ndarray

    @classmethod
    def even(cls, count: int, samples: int, kinds: tuple[int, ...]) -> "Levels":
        """As many of each of these kinds for all; a power of two."""
        columns = np.full((len(KINDS), count), NO_SAMPLES, dtype=np.uint8)
        columns[list(kinds)] = samples.bit_length() - 1
        return cls(columns)

    def total(self) -> float:
        """Sum of `samples`."""
        sums = [
            float(np.bincount(each, minlength=NO_SAMPLES + 1) @ SAMPLE_COUNTS)
            for each in self.columns
        ]
        return float(np.dot(sums, COSTS)) / SAMPLE_COST

    def lowered(self, steps: int) -> "Levels":
        """Samples halved so many times, but at least one."""
        lower = np.arange(NO_SAMPLES + 1, dtype=np.int64) - steps
        lower = np.maximum(lower, 0)
        lower[NO_SAMPLES] = NO_SAMPLES
        return Levels(lower.astype(np.uint8)[self.columns])

    def only(self, chosen: np.ndarray) -> "Levels":
        """None outside the chosen lumels. (n,) bool"""
        return Levels(np.where(chosen, self.columns, np.uint8(NO_SAMPLES)))

    def samples(self, part=slice(None)) -> np.ndarray:
        """Samples by lumel: as many pairs of one next-event and one gathering ray would cost as much. (n,)"""
        return (
            sum(c * _count(each[part]) for c, each in zip(COSTS, self.columns, strict=True))
            / SAMPLE_COST
        )


def _count(levels: np.ndarray) -> np.ndarray:
    return SAMPLE_COUNTS[levels]


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
        self.straight: StraightLights | None = None
        self._sides: np.ndarray | None = None
        self.count = int(sum(table.counts))
        self.first = np.concatenate([[0], np.cumsum(table.counts)]).astype(np.int64)
        self.channels = 4 if options.exitance else 1
        self.sampler = None
        if is_spectral():
            kind = "colour" if options.exitance else "luminance"
            self.sampler = WavelengthSampler(scene.mean_light, kind)
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
        self.guide: Guide | None = None
        # Where rays go, by the first lumel of a span; empty while they go by the cosine law.
        self.aims: dict[int, np.ndarray] = {}
        try:
            if options.cells or tracer is not None:
                self._make_cells(known)
            self._traces = tracer is not None and (
                tracer.is_needed or (self.straight is not None and self.straight.is_needed)
            )
            if self._traces:
                self.finder = find_lumels()
            self.spans = self._find_spans(known.places)
        except BaseException:
            self.close()
            raise
        self.trace_share = TRACE_SHARES[1]
        self._uploaded: dict[int, dict] = {}
        self._collector = ThreadPoolExecutor(1)
        self._coming: tuple[int, Future | None] = (-1, None)

    def close(self) -> None:
        """Leave the scene as other jobs expect it."""
        if self.straight is not None:
            self.straight.close()
        if self.tracer is not None:
            self.tracer.close()

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
            self.guide = guide if guide.is_useful else None
            self.sweeper.guide = self.guide

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
        self.aims = {int(k[len(head) :]): v for k, v in state.items() if k.startswith(head)}
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
        return [
            (part, values.sum(axis=0).astype(np.float32))
            for part, values in self.estimates(number, levels, progress)
        ]

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
        for span in self.spans:
            count = span.stop - span.start
            values = np.zeros((len(KINDS), count, self.channels))
            columns = levels.columns[:, span]
            for kind in kinds:
                column = columns[kind]
                for units in _batches(column, self.valid[span]):
                    for part in units.split():
                        if self.cancelled():
                            raise Cancelled("cancelled")
                        sums = self._launch(span, kind, part, number, columns)
                        part.add(sums, values[kind])
                    if progress is not None:
                        progress(min((done + count * (kind + 0.5) / len(KINDS)) / total, 1.0))
            done += count
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
        for span in self.spans:
            tiles = self.tiles(span)
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
                squares[part] = self._look_around(span, order, first[part], many[part], rays)
            aims[span.start] = find_densities(squares)
        return aims

    def set_ways(self, guide: Guide | None, aims: dict[int, np.ndarray]) -> None:
        """Gather light with these points on bright cells, and with rays that are aimed so, from now on."""
        if aims is not self.aims:
            self.aims, self._uploaded = aims, {}
        self.guide = guide
        if self.sweeper is not None:
            self.sweeper.guide = guide

    def tiles(self, span: slice) -> np.ndarray:
        """Number of the tile of every lumel of a span, from 0 on. (k,)"""
        made, count = [], 0
        inside = (self.first[:-1] >= span.start) & (self.first[:-1] < span.stop)
        for number in np.flatnonzero(inside):
            own = tile_numbers(self.table.facts(int(number)), self.table.width(int(number)))
            made.append(own + count)
            count += int(own.max(initial=-1)) + 1
        return np.concatenate(made)

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
        for span in self.spans:
            low, high = np.searchsorted(lumels, [span.start, span.stop])
            if low == high:
                continue
            if self.cancelled():
                raise Cancelled("cancelled")
            ones = Levels.even(span.stop - span.start, 1, (DIRECT, GATHERED, MIRRORED)).columns
            # Numbers of their own, since some lumels are drawn more than once.
            units = _Units(lumels[low:high] - span.start, np.arange(high - low), 1, ones[GATHERED])
            read, full = (
                self._launch(span, GATHERED, units, number, ones, CHECK_SALT, exact)[:, 0]
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

    def _find_spans(self, counts: np.ndarray) -> list[slice]:
        """Lumels that are worked on together: those of as many blocks as their places fit. ``counts``: places of blocks."""
        spans, start, places = [], 0, 0
        for number, more in enumerate(counts.tolist()):
            if places and places + more > SPAN_PLACES:
                spans.append(slice(start, int(self.first[number])))
                start, places = int(self.first[number]), 0
            places += more
        return [*spans, slice(start, self.count)] if self.count else []

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
        lumel = self.finder.find(found.shape, found.prim, found.uv, found.back)
        landed = (lumel >= 0) & (found.geometric_cosine > 0.0)
        light = found.flux * found.cosine / np.maximum(found.geometric_cosine, 1e-6)
        flux = np.bincount(lumel[landed], light[landed], self.count)
        known = self.valid & (self.area > 0.0)
        self.traced = np.where(known, flux / np.where(self.area > 0.0, self.area, 1.0), 0.0)
        if self.cells:
            self.cells.put_traced(found)
            self.cells.spots = choose_spots(self.cells, self._sides)

    def _places(self, span: slice) -> dict:
        """Places of a span on the device; those of a few spans are kept."""
        if span.start not in self._uploaded:
            if len(self._uploaded) >= KEPT_SPANS:
                self._uploaded.pop(next(iter(self._uploaded)))
            arrays, boxes = self._collected(span), self.table.boxes
            self._uploaded[span.start] = {
                "p": [upload(mi.Float, arrays["p"][:, i]) for i in range(3)],
                "n": [upload(mi.Float, arrays["n"][:, i]) for i in range(3)],
                "g": [upload(mi.Float, arrays["g"][:, i]) for i in range(3)],
                "start": upload(mi.UInt32, arrays["start"]),
                "count": upload(mi.UInt32, arrays["count"]),
                "box": upload(mi.UInt32, arrays["box"]),
                "right": [upload(mi.Float, arrays["steps"][:, 0, i]) for i in range(3)],
                "up": [upload(mi.Float, arrays["steps"][:, 1, i]) for i in range(3)],
                "corners": [upload(mi.Float, boxes.corners[:, i]) for i in range(2)],
                "points": [upload(mi.Float, boxes.points[:, i]) for i in range(2)],
                "size": [dr.opaque(mi.Float, float(side)) for side in boxes.size],
            }
            if self.aims:
                self._uploaded[span.start] |= {
                    "aims": Aims(self.aims[span.start]),
                    "tile": upload(mi.UInt32, self.tiles(span)),
                }
            if self.bent is not None:
                self._uploaded[span.start]["missed"] = upload(mi.Bool, self._missed[span])
            dr.eval(self._uploaded[span.start])
        return self._uploaded[span.start]

    def _collected(self, span: slice) -> dict[str, np.ndarray]:
        """Places of a span on the host; those of the next one are collected meanwhile."""
        start, coming = self._coming
        arrays = coming.result() if start == span.start else self._collect(span)
        after = self.spans[(self.spans.index(span) + 1) % len(self.spans)]
        if after.start not in self._uploaded and after is not span:
            self._coming = after.start, self._collector.submit(self._collect, after)
        return arrays

    def _collect(self, span: slice) -> dict[str, np.ndarray]:
        inside = (self.first[:-1] >= span.start) & (self.first[:-1] < span.stop)
        blocks = [self.table.block(int(i)) for i in np.flatnonzero(inside)]
        parts = [block.receivers for block in blocks]
        begins = np.cumsum([0, *(len(part.positions) for part in parts)])
        starts = [part.start + begin for part, begin in zip(parts, begins, strict=False)]
        return {
            "p": self.scene.local(np.concatenate([part.positions for part in parts])),
            "n": np.concatenate([part.normals for part in parts]),
            "g": np.concatenate([part.geometric_normals for part in parts]),
            "start": np.concatenate(starts),
            "count": np.concatenate([part.count for part in parts]),
            "box": np.concatenate([block.box for block in blocks]),
            "steps": np.concatenate([block.steps for block in blocks]),
        }

    def _launch(
        self, span, kind, units: "_Units", number, columns, salt=0, is_exact=False
    ) -> np.ndarray:
        """Sums over the samples of units, (u, channels). ``kind``: one of `KINDS`."""
        scene, places = self.scene, self._places(span)
        aims = places.get("aims")
        who = upload(mi.UInt32, units.lumel)
        begin = upload(mi.UInt32, units.first)
        first = dr.opaque(mi.UInt32, int(span.start) & 0xFFFFFFFF)
        counts = [_count(column[units.lumel]) for column in columns]
        ratios = {
            k: upload(mi.Float, np.clip(counts[k] / np.maximum(counts[GATHERED], 1e-9), 1e-4, 1e4))
            for k in (DIRECT, GUIDED, MIRRORED)
        }
        many = dr.opaque(mi.UInt32, units.samples)
        seed = dr.opaque(
            mi.UInt32,
            (int(self.seed) * 2654435761 + number * 40503 + kind * 9176 + salt) & 0xFFFFFFFF,
        )
        has_guide = self.guide is not None and bool((columns[GUIDED] != NO_SAMPLES).any())
        pair = (gather.PAIR_LIGHT, gather.PAIR_SCATTER, gather.PAIR_LENS, gather.PAIR_LIGHT)[kind]

        lane = dr.arange(mi.UInt32, len(units.lumel) * units.samples)
        row = lane // many
        sample = dr.gather(mi.UInt32, begin, row) + lane % many
        lumel = dr.gather(mi.UInt32, who, row)
        own = hash_words(first + lumel, seed)
        stream = random_stream(sample, own)
        place_sample, point, tint = self._samples(sample, own, stream, pair)
        wavelengths = None if self.sampler is None else self.sampler.sample(tint)
        si = self._place(places, lumel, place_sample, wavelengths)
        ratio = dr.gather(mi.Float, ratios[DIRECT if kind == GATHERED else kind], row)
        aim = aims.of_tile(dr.gather(mi.UInt32, places["tile"], lumel)) if aims else Cosine()
        receiver = Receiver(si, wavelengths, stream, point, ratio, _facing(si), aim)
        if kind == DIRECT:
            value = direct(scene, receiver)
            if self.bent is not None:
                value += self._bent_light(places, lumel, receiver)
        elif kind == MIRRORED:
            value = mirrored(scene, receiver)
        elif kind == GUIDED:
            traced, read = self.guide.light(scene, receiver, stream)
            value = traced + read
        else:
            value = gathered(
                scene,
                self.cells,
                receiver,
                is_exact=is_exact or self.sweeper is None,
                left_out=self._left_out,
                guide=self.guide if has_guide else None,
                guided_ratio=dr.gather(mi.Float, ratios[GUIDED], row) if has_guide else 1.0,
                mirrored_ratio=dr.gather(mi.Float, ratios[MIRRORED], row),
            )
        # At the full width of the launch, also where there is no light to choose.
        kept = [
            dr.select(dr.isfinite(channel), channel, 0.0) + mi.Float(lane) * 0.0
            for channel in self._channels(value, wavelengths, si)
        ]
        # Sums are made apart, since their length would be a part of the kernel.
        dr.eval(kept)
        sums = [dr.block_reduce(dr.ReduceOp.Add, each, units.samples) for each in kept]
        return np.stack([np.array(s, dtype=np.float64) for s in sums], axis=-1)

    def _bent_light(self, places, lumel, receiver: Receiver):
        """What comes over bends to lumels on which traced light never lands."""
        respond = receiver.respond

        def respond_alone(direction, asked):
            return dr.select(asked, respond(direction), 0.0)

        asks = dr.gather(mi.Bool, places["missed"], lumel)
        return self.bent.light(receiver.si, receiver.stream, respond_alone, asks)

    def _look_around(self, span, order, first, many, rays: int) -> np.ndarray:
        """Mean squares of what rays bring, through the bins of some tiles. (t, BINS)

        ``order``: lumels of the span tile by tile; ``first``, ``many``: where each tile's begin, and their number.
        """
        places = self._places(span)
        seed = (int(self.seed) * 2654435761 + AIM_SALT) & 0xFFFFFFFF
        lane = dr.arange(mi.UInt32, len(first) * BINS * rays)
        bin_ = (lane // rays) % BINS
        tile = lane // (BINS * rays)
        lumels, starts, counts = (upload(mi.UInt32, each) for each in (order, first, many))
        unique = dr.gather(mi.UInt32, starts, tile) + dr.opaque(mi.UInt32, span.start & 0xFFFFFFFF)
        stream = random_stream(lane % (BINS * rays), hash_words(unique, dr.opaque(mi.UInt32, seed)))
        mine = dr.gather(mi.UInt32, counts, tile)
        chosen = dr.minimum(mi.UInt32(stream.next_float32() * mi.Float(mine)), mine - 1)
        lumel = dr.gather(mi.UInt32, lumels, dr.gather(mi.UInt32, starts, tile) + chosen)
        numbers = [stream.next_float32() for _ in range(5)]
        wavelengths = None if self.sampler is None else self.sampler.sample(numbers[4])
        si = self._place(places, lumel, mi.Point2f(numbers[0], numbers[1]), wavelengths)
        row, column = (mi.Float(each) for each in (bin_ // SIDE, bin_ % SIDE))
        point = mi.Point2f((row + numbers[2]) / SIDE, (column + numbers[3]) / SIDE)
        value = gathered(
            self.scene,
            self.cells,
            Receiver(si, wavelengths, stream, point, mi.Float(1.0), _facing(si)),
            is_exact=self.sweeper is None,
            left_out=self._left_out,
        )
        light = gather.photometric(self.sampler, value, wavelengths)
        square = dr.square(dr.select(dr.isfinite(light), light, 0.0))
        square += mi.Float(lane) * 0.0
        dr.eval(square)
        found = dr.block_reduce(dr.ReduceOp.Add, square, rays)
        return np.array(found, dtype=np.float64).reshape(-1, BINS) / rays

    def _samples(self, sample, seed, stream, pair: int):
        """Points for the place, the direction or light, and the wavelengths."""
        if self.options.qmc:
            return (
                sobol_pair(sample, seed, gather.PAIR_PLACE),
                sobol_pair(sample, seed, pair),
                sobol_pair(sample, seed, gather.PAIR_WAVELENGTH).x,
            )
        place, direction = (
            mi.Point2f(stream.next_float32(), stream.next_float32()) for _ in range(2)
        )
        return place, direction, stream.next_float32()

    def _place(self, places: dict, lumel, sample, wavelengths):
        """A place of a lumel, or any other in the part of the lumel that it stands for."""
        mine = dr.gather(mi.UInt32, places["count"], lumel)
        scaled = sample.x * mi.Float(mine)
        number = dr.minimum(mi.UInt32(scaled), mine - 1)
        chosen = dr.gather(mi.UInt32, places["start"], lumel) + number

        def fetch(made, name, row):
            return made(*(dr.gather(mi.Float, column, row) for column in places[name]))

        # Fixed places would miss the same edges of shadows in all passes, whose scatter would not show it.
        box = dr.gather(mi.UInt32, places["box"], chosen)
        is_box, box = box > 0, dr.maximum(box, 1) - 1
        inside = mi.Vector2f(scaled - mi.Float(number), sample.y) * mi.Vector2f(*places["size"])
        aside = dr.clip(fetch(mi.Vector2f, "corners", box) + inside, *self.table.boxes.ends)
        aside -= fetch(mi.Vector2f, "points", box)
        shift = (
            fetch(mi.Vector3f, "right", lumel) * aside.x + fetch(mi.Vector3f, "up", lumel) * aside.y
        )
        return gather.receiver(
            fetch(mi.Point3f, "p", chosen) + dr.select(is_box, shift, 0.0),
            fetch(mi.Normal3f, "n", chosen),
            fetch(mi.Normal3f, "g", chosen),
            wavelengths,
            self.scene.extent,
        )

    def _channels(self, value, wavelengths, si) -> list:
        made = [gather.photometric(self.sampler, value, wavelengths)]
        if self.options.exitance:
            leaving = value * self._reflectance(si)
            if self.sampler is not None:
                made += list(self.sampler.tristimulus(leaving, wavelengths))
            else:
                lamp = self.scene.mean_light @ observer()
                made += [leaving[0] * float(c / lamp[1]) for c in lamp]
        return made

    def _reflectance(self, si):
        """Diffuse reflectance of the surface that a place lies on, found by looking at it from a hair's breadth."""
        lift = self.scene.extent * 1e-5
        ray = mi.Ray3f(si.p + si.n * lift, -mi.Vector3f(si.n))
        ray.maxt = 3.0 * lift
        hit = self.scene.solid.ray_intersect_preliminary(ray, mi.Bool(False), mi.Bool(True))
        seen = self.scene.surface(hit, ray, mi.Bool(True))
        if si.wavelengths is not None:
            seen.wavelengths = si.wavelengths
        found = hit.is_valid()
        return dr.select(
            found, self.scene.bsdf(seen, found).eval_diffuse_reflectance(seen, found), 0.0
        )


def _facing(si):
    """How much light from a direction counts at a receiver. [-]"""

    def respond(direction):
        above = dr.dot(direction, si.n) > 0.0
        return dr.select(above, dr.maximum(dr.dot(direction, si.sh_frame.n), 0.0), 0.0)

    return respond


@dataclass(frozen=True)
class _Units:
    """Pieces of work of equal length: samples of a lumel that follow each other.

    Parameters
    ----------
    lumel : (u,) int array    Within the span.
    first : (u,) int array    Number of the first sample.
    samples : int    Of every unit.
    levels : (n,) uint8 array    Of the lumels of the span.
    """

    lumel: np.ndarray
    first: np.ndarray
    samples: int
    levels: np.ndarray

    def split(self):
        """Yield parts that fit a launch."""
        most = max(LANES // self.samples, 1)
        for start in range(0, len(self.lumel), most):
            part = slice(start, start + most)
            yield _Units(self.lumel[part], self.first[part], self.samples, self.levels)

    def add(self, sums: np.ndarray, values: np.ndarray) -> None:
        """Add the means that sums (u, channels) make to the values (n, channels) of their lumels."""
        begins = np.flatnonzero(np.diff(self.lumel, prepend=-1))
        rows = self.lumel[begins]
        values[rows] += np.add.reduceat(sums, begins, axis=0) / _count(self.levels[rows])[:, None]


def _batches(levels: np.ndarray, known: np.ndarray):
    """Yield the work of all known lumels as `_Units`; those of few samples apart where units would be too many."""
    chosen = known & (levels != NO_SAMPLES)
    if not chosen.any():
        return
    few = chosen & (levels < FEW)
    is_one = float(_count(levels[chosen]).sum()) <= MOST_UNITS or few.all() or not few.any()
    for group in [chosen] if is_one else [few, chosen & ~few]:
        lumels = np.flatnonzero(group)
        lowest = int(levels[lumels].min())
        counts = 1 << (levels[lumels].astype(np.int64) - lowest)
        lumel = np.repeat(lumels, counts)
        number = np.arange(len(lumel)) - np.repeat(np.cumsum(counts) - counts, counts)
        yield _Units(lumel, number << lowest, 1 << lowest, levels)
