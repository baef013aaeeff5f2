"""The pilot of a lux map job: first passes that find how lumels scatter, and from it how many samples each should get."""

import time
from dataclasses import dataclass

import numpy as np

from ...accuracy.replicates import ReplicateSums
from ...errors import SceneError
from .job import PILOT_SAMPLES, TRACE_COST, TRACE_SHARES, LuxJob
from .levels import ALL_KINDS, COSTS, GATHERED, GUIDED, KINDS, NO_SAMPLES, SAMPLE_COUNTS, Levels
from .path_guiding import BINS

STEEPEST, FLATTEST = 2.0, 1.0
"""Bounds on the power of the samples of a pass by which a variance is believed to fall."""

SPREAD = 8.0
"""Largest factor between a tile's samples and the mean of all."""

MOST_SAMPLES = 1024
"""Most samples of a lumel in a pass."""

LEARNING = 1.0 / 12.0
"""Rays that tell tiles where to look for light, relative to those of all passes."""

FEWEST_RAYS, MOST_RAYS = 1, 16
"""Rays through every bin of a tile: with fewer there is no aiming, and more tell little more."""

COMPARED = 1.0 / 16.0
"""Share of the surface on which ways to gather light are compared."""

COMPARISONS = 200_000
"""First number of the passes that are made for this."""

FINEST_SHIFT = 0.01
"""How near a plan comes to the fewest samples that are enough, as a logarithm to base 2 of what another one is worth. [-]"""

LOTS = 1024
"""Lots from which lumels are chosen."""

MOST_TRACED = 0.5
"""Share of the square of a plan's error that is left to traced light, however much of it that has. [-]"""

EVENLY = 0.5
"""Share of the lumels of a trial that are drawn evenly; the others where the error is thought to come from. [-]"""

FEWEST_COMPARED, FEWEST_TRIED = 600, 2_000
"""Lumels on which ways are compared and passes are tried, at least."""


@dataclass(frozen=True)
class Trial:
    """What a planned pass takes.

    Parameters
    ----------
    trace_seconds : float    For paths from the lights. [s]
    paths : int    Number of these.
    seconds : float    For the part of the lumels that was tried. [s]
    samples : float    Sum over that part.
    """

    trace_seconds: float
    paths: int
    seconds: float
    samples: float


@dataclass(frozen=True)
class Drawn:
    """Lumels that stand for all.

    Parameters
    ----------
    rows : (n,) bool array or slice
    share : (k,) array    Of the surface, that each of them stands for. [-]
    """

    rows: np.ndarray | slice
    share: np.ndarray


class Pilot:
    """First passes that find how lumels scatter, and from it how many samples each should get.

    Parameters
    ----------
    job : LuxJob
    """

    def __init__(self, job: LuxJob):
        self.job = job
        share = np.where(job.valid, job.area, 0.0)
        self._share = (share / max(share.sum(), 1e-300)).astype(np.float32)
        self._scatter = np.zeros((len(KINDS), job.count), dtype=np.float32)
        # By which power of its samples the variance of each kind falls.
        self._powers = np.ones(len(KINDS))
        # Square of the error that light traced by a single path would have. [lx2]
        self._traced = 0.0
        # Trials are made on some lumels of all tiles: those of a tile are alike in what is not known of them.
        draw = np.random.default_rng([job.seed & 0xFFFFFFFF, 5])
        self._lot = draw.integers(0, LOTS, job.count, dtype=np.uint16)

    @classmethod
    def from_state(cls, job: LuxJob, state: dict[str, np.ndarray]) -> "Pilot":
        """Pilot of a job that knows what another one had found.

        Raises
        ------
        SceneError    The arrays do not fit the job.
        """
        made = cls(job)
        wanted = {"scatter": made._scatter, "powers": made._powers, "traced": np.zeros(1)}
        for name, like in wanted.items():
            array = state.get(name)
            if (
                array is None
                or (array.shape, array.dtype) != (like.shape, like.dtype)
                or not np.isfinite(array).all()
                or (array < 0.0).any()
            ):
                raise SceneError(f"the state of the pilot holds {name} that do not fit the maps")
        made._scatter, made._powers = state["scatter"].copy(), state["powers"].copy()
        made._traced = float(state["traced"][0])
        return made

    def state(self) -> dict[str, np.ndarray]:
        """What was found, for a checkpoint."""
        return {
            "scatter": self._scatter,
            "powers": self._powers,
            "traced": np.array([self._traced]),
        }

    def run(self, sums: ReplicateSums) -> None:
        """Make two passes with few samples, and note the variances of single samples by tile, apart by kind."""
        self._scatter = self._find_scatter(sums, 0)

    def choose_ways(self, levels: Levels, passes: int) -> None:
        """Find out whether points on bright cells pay, and aimed rays where so many passes are worth learning for.

        Each makes single samples scatter less, but variances fall less steeply with their number then. So all pairs are
        tried with the numbers of a pass, on some of the lumels.
        """
        job = self.job
        before = job.guide, job.aims
        rays = self._learning_rays(levels, passes)
        guides = [None] if job.guide is None else [job.guide, None]
        if job.guide is not None and job.cells.traced is not None:
            # What was traced to small spots so few samples would not miss, and later ones would by chance.
            guides = [job.guide]
        aims = [job.aims]
        if job.options.aimed and rays >= FEWEST_RAYS:
            aims.append(job.learn_aims(rays))
        ways = [(guide, aim) for aim in aims for guide in guides]
        if len(ways) > 1:
            job.set_ways(*min(ways, key=lambda way: self._try_ways(levels, *way)))
        if (job.guide, job.aims) != before:
            self._scatter = self._find_scatter(None, 2)

    def _try_ways(self, levels: Levels, guide, aims) -> float:
        """Work for a given error with these ways to gather light, up to a factor."""
        job = self.job
        job.set_ways(guide, aims)
        chosen = self._choose(COMPARED, FEWEST_COMPARED)
        few = levels.only(chosen)
        kinds = [GATHERED] if guide is None else [GATHERED, GUIDED]
        found = np.zeros((2, len(KINDS), job.count), dtype=np.float32)
        for half in range(2):
            for part, values in job.estimates(COMPARISONS + half, few, kinds=kinds):
                found[half][:, part] = values[..., 0]
        squares = ((found[0] - found[1]) ** 2 * self._share).sum(axis=1, dtype=np.float64)
        counts = SAMPLE_COUNTS[levels.columns[:, chosen]].mean(axis=1)
        return float(np.sqrt(squares * counts * np.array(COSTS))[kinds].sum())

    def _learning_rays(self, levels: Levels, passes: int) -> int:
        """Rays through every bin of a tile that are worth their time; a power of two, 0 for none."""
        counts = SAMPLE_COUNTS[levels.columns[GATHERED][self.job.valid]]
        places = self.job.places
        tiles = sum(int(places.tiles(span).max(initial=-1)) + 1 for span in places.spans)
        rays = LEARNING * passes * float(counts.sum()) / max(tiles * BINS, 1)
        return 0 if rays < FEWEST_RAYS else 1 << int(np.log2(min(rays, MOST_RAYS)))

    def _find_scatter(self, sums: ReplicateSums | None, first_number: int) -> np.ndarray:
        """Variances of single samples, mean over tiles. (kinds, n) [lx2]"""
        job = self.job
        levels = Levels.even(job.count, PILOT_SAMPLES, job.kinds)
        first = np.zeros((len(KINDS), job.count), dtype=np.float32)
        scatter = np.zeros_like(first)
        for half in range(2):
            # Sweeps of so few samples would make the cells worse.
            if first_number + half > 0:
                job.trace(first_number + half, levels)
            for part, values in job.estimates(first_number + half, levels):
                if sums is not None:
                    sums.add(part.start, values.sum(axis=0), levels.samples(part))
                if job.traced is not None:
                    values[GATHERED, :, 0] -= job.traced[part]
                if half == 0:
                    first[:, part] = values[..., 0]
                    continue
                # Of two values each, so half their squared difference is the variance of one.
                square = 0.5 * (values[..., 0] - first[:, part]) ** 2 * PILOT_SAMPLES
                tiles = job.places.tiles(part)
                for kind in range(len(KINDS)):
                    scatter[kind, part] = _mean_by(tiles, square[kind], job.valid[part])
            if sums is not None:
                sums.end_pass()
        return scatter

    def plan(self, square: float | None = None, samples: float | None = None) -> Levels:
        """Samples of every lumel in a pass.

        Parameters
        ----------
        square : float or None    Square of the map's standard error that one pass should have. [lx2]
        samples : float or None    Or mean number of samples of a lumel.
        """
        job, options = self.job, self.job.options
        power = self._powers[:, None].astype(np.float32)
        cost = np.array(COSTS, dtype=np.float32)[:, None]
        scatter = self._scatter
        if not options.direct_apart:
            power, cost = np.float32(power.min()), cost.sum()
            scatter = np.repeat(scatter.sum(axis=0)[None, :], len(KINDS), axis=0)
        # Least work for an error: samples such that another one of any kind and tile is worth the same.
        worth = power * scatter * self._share * PILOT_SAMPLES ** (power - 1.0) / cost
        wanted = worth ** (1.0 / (1.0 + power))
        mean = wanted[:, job.valid].mean(axis=1)
        if not options.adaptive:
            wanted = np.repeat(mean[:, None], job.count, axis=1)
        # Of what little was seen not too much is believed.
        wanted = np.clip(wanted, mean[:, None] / SPREAD, mean[:, None] * SPREAD)
        # Where one kind has no scatter at all, one sample of it will do.
        wanted = np.log2(np.maximum(wanted, 1e-6 * max(float(mean.max()), 1e-30)))

        def levels(shift: float) -> Levels:
            made = wanted + np.float32(shift) / (1.0 + power)
            made = np.clip(np.round(made), 0, np.log2(MOST_SAMPLES))
            made = made.astype(np.uint8)
            made[[kind for kind in ALL_KINDS if kind not in job.kinds]] = NO_SAMPLES
            return Levels(made)

        def is_enough(shift: float) -> bool:
            made = levels(shift)
            if square is not None:
                # What paths of such a pass cannot do, further passes have to.
                traced = min(self._traced_square(made), MOST_TRACED * square)
                return self._kinds_square(made) + traced <= square
            return made.total() >= samples * job.count

        most = 1.0 + STEEPEST
        high = most * (float(-wanted.min(initial=0.0)) + np.log2(MOST_SAMPLES))
        low = most * (float(-wanted.max(initial=0.0)) - 1.0)
        while high - low > FINEST_SHIFT:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if is_enough(middle) else (middle, high)
        return levels(high)

    def square(self, levels: Levels) -> float:
        """Square of the map's standard error after one pass. [lx2]"""
        return self._kinds_square(levels) + self._traced_square(levels)

    def _kinds_square(self, levels: Levels) -> float:
        """What all kinds of samples contribute to `square`. [lx2]"""
        return sum(
            self._square_of(kind, levels, Drawn(slice(None), self._share), power)
            for kind, power in enumerate(self._powers)
        )

    def _traced_square(self, levels: Levels) -> float:
        """What light that is traced contributes to `square`. [lx2]"""
        return self._traced / self.job.paths(levels) if self._traced > 0.0 else 0.0

    def _square_of(self, kind: int, levels: Levels, drawn: Drawn, power: float) -> float:
        """What a kind contributes to `square` by some lumels, if its variance falls by this power. [lx2]"""
        return float(self._squares_of(kind, levels, drawn, power).sum(dtype=np.float64))

    def _squares_of(self, kind: int, levels: Levels, drawn: Drawn, power: float) -> np.ndarray:
        """Likewise lumel by lumel. (k,) [lx2]"""
        inverse = _variance(power).astype(np.float32)[levels.columns[kind][drawn.rows]]
        return self._scatter[kind][drawn.rows] * drawn.share * inverse

    def correct(self, levels: Levels, square: float) -> None:
        """Take over the square of the error that passes have really shown. ``square``: of one of them. [lx2]"""
        supposed = self.square(levels)
        if supposed > 0.0:
            self._scatter *= np.float32(square / supposed)
            self._traced *= square / supposed

    def try_pass(self, number: int, levels: Levels, part: float) -> Trial:
        """Make a part of a planned pass twice, and learn from it how the variances fall.

        Parameters
        ----------
        number : int    Of the first; the second has the next one.
        levels : Levels
        part : float    Share of the lumels, about, that is tried.
        """
        job = self.job
        drawn = self._draw(levels, part)
        chosen = drawn.rows
        few = levels.only(chosen)
        place = np.cumsum(chosen) - chosen
        found = np.zeros((2, len(KINDS), int(chosen.sum())), dtype=np.float32)
        tracing, sampling = 0.0, np.inf
        # Light that is traced for lumels alone falls on all of them, so a few paths are enough.
        paths = job.paths(levels, part)
        traced = np.zeros((2, job.count))
        for half in range(2):
            start = time.perf_counter()
            job.trace(number + half, levels, part)
            # The first one may have to make kernels.
            middle = time.perf_counter()
            tracing = middle - start
            for span, values in job.estimates(number + half, few):
                own = chosen[span]
                found[half][:, place[span][own]] = values[:, own, 0]
            # Of these the faster one was disturbed less.
            sampling = min(sampling, time.perf_counter() - middle)
            if job.traced is not None:
                traced[half] = job.traced
                found[half][GATHERED] -= job.traced[chosen]
        light = traced[0] - traced[1]
        self._traced = paths * float((0.5 * light**2) @ self._share)
        self._learn(levels, drawn, found[0] - found[1], light[chosen])
        return Trial(tracing, paths, sampling, few.total())

    def choose_trace_share(self, levels: Levels) -> None:
        """Have as many paths from the lights as give the least work for an error together with the samples of a pass."""
        rest = self._kinds_square(levels)
        if self._traced <= 0.0 or rest <= 0.0:
            return
        # Work grows and the square of the error falls with the number of both.
        share = np.sqrt(self._traced / max(levels.total(), 1.0) / (TRACE_COST * rest))
        low, _, high = TRACE_SHARES
        self.job.trace_share = float(np.clip(share, low, high))

    def _draw(self, levels: Levels, part: float) -> Drawn:
        """Draw lumels for a trial, more where the error is thought to come from: few may make most of it."""
        everyone = Drawn(slice(None), self._share)
        worth = sum(
            self._squares_of(kind, levels, everyone, power)
            for kind, power in enumerate(self._powers)
        )
        count = max(int(np.count_nonzero(self._share)), 1)
        part = max(part, min(FEWEST_TRIED / count, 1.0))
        mean = float(worth.sum(dtype=np.float64)) / count
        chance = part * (
            EVENLY + (1.0 - EVENLY) * (worth / mean if mean > 0.0 else np.ones_like(worth))
        )
        # As exactly as lots tell.
        chance = np.clip(np.ceil(chance * LOTS), 1, LOTS) / LOTS
        rows = (self._lot < chance * LOTS) & (self._share > 0.0)
        return Drawn(rows, (self._share[rows] / chance[rows]).astype(np.float32))

    def _choose(self, part: float, fewest: int) -> np.ndarray:
        """So many random lumels that they hold such a share of the surface, at least. (n,) bool"""
        area = np.cumsum(np.bincount(self._lot, self._share, LOTS))
        number = np.cumsum(np.bincount(self._lot, minlength=LOTS))
        enough = (area >= min(part, area[-1])) & (number >= min(fewest, number[-1]))
        return self._lot <= int(np.argmax(enough))

    def _learn(self, levels: Levels, drawn: Drawn, differences: np.ndarray, traced=0.0) -> None:
        """Find how variances fall from differences of two passes on drawn lumels, (kinds, n), and of traced light, (n,)."""
        share = drawn.share
        measured = (0.5 * differences**2 * share).sum(axis=1, dtype=np.float64)
        for kind, square in enumerate(measured.tolist()):
            if square > 0.0:
                self._powers[kind] = self._find_power(kind, square, levels, drawn)
                supposed = self._square_of(kind, levels, drawn, self._powers[kind])
                self._scatter[kind] *= np.float32(square / supposed if supposed > 0.0 else 1.0)
        # Kinds that hang together by the cells, and with the light that is traced.
        whole = float((0.5 * (differences.sum(axis=0) + traced) ** 2 * share).sum(dtype=np.float64))
        whole -= float((0.5 * traced**2 * share).sum(dtype=np.float64))
        if whole > 0.0 and measured.sum() > 0.0:
            self._scatter *= np.float32(whole / measured.sum())

    def _find_power(self, kind: int, square: float, levels: Levels, drawn: Drawn) -> float:
        """Power, within its bounds, by which the variance of a kind has come down to a square. [lx2]"""
        low, high = FLATTEST, STEEPEST
        for _ in range(10):
            middle = 0.5 * (low + high)
            falls_short = self._square_of(kind, levels, drawn, middle) > square
            low, high = (middle, high) if falls_short else (low, middle)
        return 0.5 * (low + high)


def _variance(power: float) -> np.ndarray:
    """Variance of the mean of 2^level samples, relative to that of one, by level; 0 for none."""
    count = np.where(SAMPLE_COUNTS > 0.0, SAMPLE_COUNTS, 1.0)
    made = np.where(
        count > PILOT_SAMPLES, (count / PILOT_SAMPLES) ** -power / PILOT_SAMPLES, 1.0 / count
    )
    return np.where(SAMPLE_COUNTS > 0.0, made, 0.0)


def _mean_by(group: np.ndarray, values: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Mean of a lumel's group at every lumel. (n,)"""
    total = np.bincount(group, weights=values * counts)
    number = np.bincount(group, weights=counts.astype(np.float64))
    return (total / np.maximum(number, 1.0))[group]
