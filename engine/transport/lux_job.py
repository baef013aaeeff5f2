"""The lux map job: passes over all lumels, each an independent replicate of the whole map.

A pass gives every lumel an unbiased estimate from low-discrepancy points of its own scramble and from cells that were
swept anew with points of their own, so passes differ by chance alone: their scatter is the error, which falls as one over
the root of their number. Direct light and interreflection are estimated apart, each with as many samples as a pilot has
found best for every tile of the maps: in proportion to the scatter, and to the root of the area over the cost (Neyman's
allocation).
"""

import time
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ..accuracy.replicates import ReplicateSums
from ..arrays import upload
from ..errors import Cancelled
from ..photometry.spectra import observer
from . import gather
from .cells import CellSet
from .lights import learn
from .receiving import direct, gathered
from .sampler import hash_words, random_stream, sobol_pair
from .sweeps import Sweeper
from .textures import is_spectral
from .wavelengths import WavelengthSampler

LANES = 1 << 19
"""Samples of one launch: a fraction of a second each, so that a cancel is heard soon."""

TILE = 8
"""Side of the squares that are given samples alike. [lumel]"""

GATHER_COST = 2.5
"""What a gathering ray costs, in next-event samples; measured in rooms."""

SPREAD = 8.0
"""Largest factor between a tile's samples and the mean of all."""

MOST_SAMPLES = 1024
"""Most samples of a lumel in a pass."""

CELLS_PER_LUMEL = 1.0 / 8.0
FEWEST_CELLS, MOST_CELLS = 4_000, 1_000_000
"""How many cells there are: as many as serve the lumels, within bounds."""

PILOT_SAMPLES = 2
"""Samples of a lumel in a pass of the pilot, of each kind."""

CHECKS = 1 << 14
"""Paths in every pass that compare the cells with full paths."""

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
    """

    cells: bool = True
    exitance: bool = False
    qmc: bool = True
    direct_apart: bool = True
    adaptive: bool = True


@dataclass
class Levels:
    """Samples of every lumel in a pass: two to the power of the level, for direct light and for gathering. (n,) uint8"""

    direct: np.ndarray
    gather: np.ndarray

    @classmethod
    def even(cls, count: int, direct: int, gathering: int) -> "Levels":
        """As many for all; both powers of two."""
        return cls(
            np.full(count, direct.bit_length() - 1, dtype=np.uint8),
            np.full(count, gathering.bit_length() - 1, dtype=np.uint8),
        )

    def total(self) -> float:
        """Sum of `samples`."""
        powers = 2.0 ** np.arange(NO_SAMPLES + 1)
        powers[NO_SAMPLES] = 0.0
        counts = [
            np.bincount(each, minlength=NO_SAMPLES + 1) for each in (self.gather, self.direct)
        ]
        return float(counts[0] @ powers + counts[1] @ powers / GATHER_COST)

    def samples(self) -> np.ndarray:
        """Samples by lumel, both kinds together in units of gathering rays. (n,)"""
        return _count(self.gather) + _count(self.direct) / GATHER_COST


def _count(levels: np.ndarray) -> np.ndarray:
    return np.where(levels == NO_SAMPLES, 0.0, 2.0 ** levels.astype(np.float64))


class LuxJob:
    """Estimates the illuminance of all lumels of a table.

    Parameters
    ----------
    scene : CompiledScene
    table : LumelTable
    seed : int
    options : Options
    cancelled : callable    Asked before every launch.
    tracer : LightTracer or None    Traces from the lights what gathering cannot find.
    """

    def __init__(
        self, scene, table, seed: int, options: Options, cancelled=lambda: False, tracer=None
    ):
        self.scene, self.table, self.options, self.cancelled = scene, table, options, cancelled
        self.seed, self.tracer = seed, tracer
        self.count = int(sum(table.counts))
        self.first = np.concatenate([[0], np.cumsum(table.counts)]).astype(np.int64)
        self.channels = 4 if options.exitance else 1
        self.sampler = None
        if is_spectral():
            kind = "colour" if options.exitance else "luminance"
            self.sampler = WavelengthSampler(scene.mean_light, kind)
        self.area = np.concatenate([table.block(i).area for i in range(len(table.counts))])
        self.valid = np.concatenate([table.block(i).valid for i in range(len(table.counts))])
        self._learn()
        self.cells = self.sweeper = None
        if options.cells:
            wanted = int(np.clip(self.count * CELLS_PER_LUMEL, FEWEST_CELLS, MOST_CELLS))
            self.cells = CellSet(scene, wanted)
            if self.cells:
                self.sweeper = Sweeper(scene, self.cells, seed, cancelled)
        self._uploaded: dict[int, dict] = {}

    def prepare(self) -> None:
        """Find the light of the cells."""
        if self.sweeper is not None:
            self.sweeper.find()

    def run_pass(self, number: int, levels: Levels, sums: ReplicateSums, progress=None) -> None:
        """Add one replicate.

        Parameters
        ----------
        number : int    Of the pass; no two may be alike.
        levels : Levels
        sums : ReplicateSums    Of all lumels.
        progress : callable or None    Called with the share of the pass that is done.
        """
        self._refresh(number, levels)
        done = 0
        for block, count in enumerate(self.table.counts):
            part = slice(int(self.first[block]), int(self.first[block]) + count)
            made = np.zeros((count, self.channels))
            own = Levels(levels.direct[part], levels.gather[part])
            for lumels, found in self.launches(block, number, own):
                made[lumels] += found.sum(axis=0)
                done += len(lumels)
                if progress is not None:
                    progress(min(0.5 * done / max(self.count, 1), 1.0))
            sums.add(part.start, made, own.samples())
        sums.end_pass()

    def launches(self, block: int, number: int, levels: Levels):
        """Estimates of the lumels of a block, launch by launch.

        Yields
        ------
        (lumels, values)    Indices within the block (k,), and means of the launch's samples (2, k, channels) for direct
            light and gathering, 0 for that which the launch did not estimate.
        """
        known = self.valid[self.first[block] : self.first[block] + len(levels.direct)]
        for kind, column in ((0, levels.direct), (1, levels.gather)):
            for level in np.unique(column[known]):
                if level == NO_SAMPLES:
                    continue
                chosen = np.flatnonzero(known & (column == level))
                samples = 1 << int(level)
                per_launch = max(LANES // samples, 1)
                for start in range(0, len(chosen), per_launch):
                    if self.cancelled():
                        raise Cancelled("cancelled")
                    lumels = chosen[start : start + per_launch]
                    values = np.zeros((2, len(lumels), self.channels))
                    values[kind] = self._launch(block, kind, lumels, samples, number, levels)
                    yield lumels, values

    def compare(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        """Differences between reading cells and full paths at lumels that are drawn by area. (k,) lumels, (k,) [lx]"""
        if self.sweeper is None:
            return np.zeros(0, dtype=np.int64), np.zeros(0)
        chances = np.where(self.valid, self.area, 0.0)
        draw = np.random.default_rng([self.seed & 0xFFFFFFFF, number, 77])
        ends = np.cumsum(chances)
        lumels = np.searchsorted(ends, draw.random(CHECKS) * ends[-1], side="right")
        lumels = np.sort(np.minimum(lumels, self.count - 1))
        found = np.zeros(len(lumels))
        for block, count in enumerate(self.table.counts):
            low, high = np.searchsorted(lumels, [self.first[block], self.first[block] + count])
            if low == high:
                continue
            if self.cancelled():
                raise Cancelled("cancelled")
            own = lumels[low:high] - self.first[block]
            levels = Levels.even(count, 1, 1)
            read, full = (
                self._launch(block, 1, own, 1, number, levels, salt=19, is_exact=exact)[:, 0]
                for exact in (False, True)
            )
            found[low:high] = read - full
        return lumels, found

    # ---- private ----

    def _learn(self) -> None:
        """Let the choice of lights learn what arrives at the lumels."""
        chosen = [self.table.block(i).receivers for i in _spread(len(self.table.counts), 16)]
        if not chosen:
            return
        learn(
            self.scene,
            self.scene.local(np.concatenate([r.positions for r in chosen])),
            np.concatenate([r.normals for r in chosen]).astype(np.float32),
            gather.typical_wavelengths(),
        )

    def _refresh(self, number: int, levels: Levels) -> None:
        if self.sweeper is None or number == 0:
            return
        # About a quarter of the pass's work, in whole quarters of cells.
        work = 0.25 * levels.total() / max(self.sweeper.lanes_per_sample, 1)
        self.sweeper.refresh(number, int(np.clip(4 * round(work / 4.0), 4, 64)))

    def _block(self, number: int) -> dict:
        """Places of a block on the device; those of a few blocks are kept."""
        if number not in self._uploaded:
            if len(self._uploaded) >= 4:
                self._uploaded.pop(next(iter(self._uploaded)))
            receivers = self.table.block(number).receivers
            columns = self.scene.local(receivers.positions)
            self._uploaded[number] = {
                "p": [upload(mi.Float, columns[:, i]) for i in range(3)],
                "n": [upload(mi.Float, receivers.normals[:, i]) for i in range(3)],
                "g": [upload(mi.Float, receivers.geometric_normals[:, i]) for i in range(3)],
                "start": upload(mi.UInt32, receivers.start),
                "count": upload(mi.UInt32, receivers.count),
            }
            dr.eval(self._uploaded[number])
        return self._uploaded[number]

    def _launch(
        self, block, kind, lumels, samples, number, levels: Levels, salt=0, is_exact=False
    ) -> np.ndarray:
        """Means over the samples of one launch, (k, channels). ``kind``: 0 direct light, 1 gathering."""
        scene, places = self.scene, self._block(block)
        who = upload(mi.UInt32, lumels)
        first = dr.opaque(mi.UInt32, int(self.first[block]) & 0xFFFFFFFF)
        share = _count(levels.direct[lumels]) / np.maximum(_count(levels.gather[lumels]), 1e-9)
        ratios = upload(mi.Float, np.clip(share, 1e-4, 1e4))
        many = dr.opaque(mi.UInt32, samples)
        lane = dr.arange(mi.UInt32, len(lumels) * samples)
        row, sample = lane // many, lane % many
        lumel = dr.gather(mi.UInt32, who, row)
        ratio = dr.gather(mi.Float, ratios, row)
        seed = dr.opaque(
            mi.UInt32,
            (int(self.seed) * 2654435761 + number * 40503 + kind * 9176 + salt) & 0xFFFFFFFF,
        )
        own = hash_words(first + lumel, seed)
        stream = random_stream(sample, own)
        if self.options.qmc:
            place_sample = sobol_pair(sample, own, gather.PAIR_PLACE)
            light_sample = sobol_pair(sample, own, gather.PAIR_LIGHT)
            scatter_sample = sobol_pair(sample, own, gather.PAIR_SCATTER)
            tint = sobol_pair(sample, own, gather.PAIR_WAVELENGTH).x
        else:
            place_sample, light_sample, scatter_sample = (
                mi.Point2f(stream.next_float32(), stream.next_float32()) for _ in range(3)
            )
            tint = stream.next_float32()
        wavelengths = None if self.sampler is None else self.sampler.sample(tint)
        mine = dr.gather(mi.UInt32, places["count"], lumel)
        chosen = dr.minimum(mi.UInt32(place_sample.x * mi.Float(mine)), mine - 1)
        chosen += dr.gather(mi.UInt32, places["start"], lumel)

        def fetch(made, name):
            return made(*(dr.gather(mi.Float, column, chosen) for column in places[name]))

        si = gather.receiver(
            fetch(mi.Point3f, "p"),
            fetch(mi.Normal3f, "n"),
            fetch(mi.Normal3f, "g"),
            wavelengths,
            scene.extent,
        )

        def respond(direction):
            above = dr.dot(direction, si.n) > 0.0
            return dr.select(above, dr.maximum(dr.dot(direction, si.sh_frame.n), 0.0), 0.0)

        everyone = mi.Bool(True)
        if kind == 0:
            value = direct(scene, si, light_sample, stream, everyone, ratio, respond)
        else:
            value = gathered(
                scene,
                self.cells,
                si,
                wavelengths,
                stream,
                scatter_sample,
                everyone,
                ratio,
                respond,
                is_exact=is_exact,
            )
        sums = []
        for channel in self._channels(value, wavelengths, si):
            kept = dr.select(dr.isfinite(channel), channel, 0.0)
            sums.append(dr.block_reduce(dr.ReduceOp.Add, kept, samples))
        dr.eval(sums)
        return np.stack([np.array(s, dtype=np.float64) for s in sums], axis=-1) / samples

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


def _spread(count: int, most: int) -> list[int]:
    """At most so many of the numbers below ``count``, evenly spread."""
    return sorted({int(i) for i in np.linspace(0, count - 1, min(count, most))}) if count else []


class Pilot:
    """First passes that find how lumels scatter, and from it how many samples each should get.

    Parameters
    ----------
    job : LuxJob
    """

    def __init__(self, job: LuxJob):
        self.job = job
        self.scatter: np.ndarray | None = None

    def run(self, sums: ReplicateSums) -> float:
        """Make two passes with few samples. Returns the seconds of the second, which makes no kernels. [s]

        Variances of single samples by tile are left in ``scatter`` (2, n), as those of direct light and gathering.
        """
        job = self.job
        levels = Levels.even(job.count, PILOT_SAMPLES, PILOT_SAMPLES)
        first = np.zeros((2, job.count), dtype=np.float32)
        scatter = np.zeros((2, job.count), dtype=np.float32)
        seconds = 0.0
        for number in range(2):
            start = time.perf_counter()
            job._refresh(number, levels)
            for block, count in enumerate(job.table.counts):
                part = slice(int(job.first[block]), int(job.first[block]) + count)
                made = np.zeros((2, count, job.channels))
                own = Levels(levels.direct[part], levels.gather[part])
                for lumels, found in job.launches(block, number, own):
                    made[:, lumels] += found
                sums.add(part.start, made.sum(axis=0), own.samples())
                if number == 0:
                    first[:, part] = made[..., 0]
                else:
                    # Of two values each, so half their squared difference is the variance of one.
                    square = 0.5 * (made[..., 0] - first[:, part]) ** 2 * PILOT_SAMPLES
                    tiles = tile_numbers(job.table.block(block), job.table.width(block))
                    for kind in range(2):
                        scatter[kind, part] = _mean_by(tiles, square[kind], job.valid[part])
            sums.end_pass()
            seconds = time.perf_counter() - start
        self.scatter = scatter
        return seconds

    def plan(self, target: float | None, samples: float | None, passes: int) -> Levels:
        """Samples of every lumel in the passes to come.

        Parameters
        ----------
        target : float or None    Square of the map's standard error that ``passes`` passes should reach. [lx2]
        samples : float or None    Or mean number of samples per lumel that they should take.
        passes : int
        """
        job, options = self.job, self.job.options
        scatter = np.maximum(self.scatter.astype(np.float64), 0.0)
        share = np.where(job.valid, job.area, 0.0)
        share /= max(share.sum(), 1e-300)
        cost = np.array([1.0, GATHER_COST])
        wanted = np.sqrt(scatter * share / cost[:, None])
        if not options.direct_apart:
            both = np.sqrt(scatter.sum(axis=0) * share / cost.sum())
            wanted = np.stack([both, both])
        mean = np.array([w[job.valid].mean() if job.valid.any() else 0.0 for w in wanted])
        if not options.adaptive:
            wanted = np.repeat(mean[:, None], job.count, axis=1)
        # Where one kind has no scatter at all, one sample of it will do.
        wanted = np.clip(wanted, mean[:, None] / SPREAD, mean[:, None] * SPREAD)
        floor = 1e-6 * max(float(mean.max()), 1e-300)
        wanted = np.maximum(wanted, floor)

        def levels(scale: float) -> Levels:
            made = np.clip(np.round(np.log2(wanted * scale)), 0, np.log2(MOST_SAMPLES))
            return Levels(made[0].astype(np.uint8), made[1].astype(np.uint8))

        def excess(scale: float) -> float:
            made = levels(scale)
            if target is not None:
                error = (
                    (scatter[0] / _count(made.direct) + scatter[1] / _count(made.gather)) * share
                ).sum() / passes
                return target - error
            return float(made.samples()[job.valid].mean()) * passes - samples

        low, high = 1e-3 / max(float(mean.max()), 1e-300), 1e6 / max(float(mean.max()), 1e-300)
        for _ in range(60):
            middle = np.sqrt(low * high)
            low, high = (low, middle) if excess(middle) >= 0.0 else (middle, high)
        return levels(high)


def tile_numbers(block, width: int) -> np.ndarray:
    """Number of the tile of every lumel of a block: a square of its chart. (n,) ``width``: of the page. [lumel]"""
    y, x = np.divmod(block.index, width)
    across = width // TILE + 1
    key = (block.chart.astype(np.int64) * across + y // TILE) * across + x // TILE
    return np.unique(key, return_inverse=True)[1].reshape(-1)


def _mean_by(group: np.ndarray, values: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Mean of a lumel's group at every lumel. (n,)"""
    total = np.bincount(group, weights=values * counts)
    number = np.bincount(group, weights=counts.astype(np.float64))
    return (total / np.maximum(number, 1.0))[group]
