"""Sweeps over the cells: each gives every cell the light that it gets from the lights and from the cells as they were."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...errors import Cancelled
from ..paths import gather
from ..paths.lost_samples import LostSamples
from ..paths.sampler import hash_words, random_stream, sobol_pair
from .cell_division import PLACES
from .cells import CellSet
from .receiving import Receiver, direct, gathered, mirrored

LANES = 1 << 19
"""Samples of one launch."""

FIRST_SWEEPS = 1 << 30
"""Numbers of the sweeps that find the light; later ones have those of their passes."""

FEWEST = 2
"""Samples of a cell in the first sweeps, over all turns."""

CAREFUL, CAREFUL_PATHS = 32, 1 << 21
"""Samples by which the quarters of a cell are compared, likewise; and paths of a sweep, where cells are few."""

LEAST_CAREFUL, QUARTERS = 8, 4
"""Samples of a turn by which they are compared, at least: one of each quarter for either half. And of jobs that are to begin
soon: one of each quarter, where every other turn is a half."""

CAREFUL_SHARE, MOST_CAREFUL = 0.1, 256
"""Samples of such a sweep, relative to those of the job where they are known; and most for a cell. [-]"""

ROUGH_SHARE = 0.25
"""Samples of the sweep before that one, relative to it. [-]"""

GROWING = 0.005
"""Share of cells that a sweep must have lit anew for light to be still on its way. [-]"""

MOST_SCALED = 2.0
"""A scale beyond this, or below its inverse, is no error of the cells but chance."""

MOST_RAISED = 20.0
"""Likewise in the first sweeps, whose cells do not hold the light of later reflections yet."""

FEWEST_SWEEPS, MOST_SWEEPS = 3, 100
"""First sweeps: so many before a small change means anything, and most in rooms whose surfaces lose next to nothing."""

NEGLIGIBLE = 1e-3
"""Share of all light that further sweeps would add. [-]"""

SOON = 0.01
"""The same of jobs that are to begin soon: the careful sweep and those that follow add most of it. [-]"""

SHADE, SHADE_SAMPLES = 0.02, 8
"""Light of a side, relative to the mean, below which it counts as dark; and samples of it in a sweep of dark ones, over all
turns. [-]"""

EMPTY, STEADY = 1e-4, 0.98
"""Such sweeps end where dark sides have less light than this, relative to the mean, or keep this share of it. [-]"""

SIGNIFICANT = 3.5
"""Difference between quarters of a cell, in standard errors, that is not taken for chance."""

UNEVEN = 1.25
"""Ratio between the brightest and the darkest quarter of a cell from which it is not read."""

MIRROR_SALT = 0x51ED27
"""Sets the points of light over mirrors apart from those of straight light."""

MOST_RENEWED, RENEWED = 8, 0.01
"""Sweeps that set out from the light of another state of the scene, at most; and the share of all light that more of them
would move from place to place. [-]"""

EDGE = 10.0
"""Ratio between neighbouring cells from which neither is read."""

DARK = 1e-3
"""Light of a quarter, relative to the mean of all cells, below which differences do not matter. [-]"""


class Sweeper:
    """Keeps the light of cells up to date.

    Parameters
    ----------
    scene : CompiledScene
    cells : CellSet
    sides : (n,) array    Sides of cells that may be seen; all others are not read.
    seed : int
    cancelled : callable    Asked before every launch.
    left_out : LeftOut or None    As of `cached_gather.incoming`.
    looks : (2 c,) array or None
        How often the job looks at every side. What light there is, is counted by it: the sunlit ground before a window holds
        a thousand times the light of the room. None: by area.
    margin : (m,) array    Neighbours of ``sides`` that are not read: they only tell which of these are uneven.

    Attributes
    ----------
    counts : (2,) int array    Samples that were no numbers, and all, since `refresh` began the last time.
    lanes : int    Most samples of a launch. How many they are changes no value.
    """

    def __init__(
        self,
        scene,
        cells: CellSet,
        sides: np.ndarray,
        seed: int,
        cancelled=lambda: False,
        left_out=None,
        looks: np.ndarray | None = None,
        margin: np.ndarray | tuple = (),
    ):
        self.scene, self.cells, self.cancelled = scene, cells, cancelled
        self._left_out = left_out
        self.guide, self.counts = None, np.zeros(2, dtype=np.int64)
        self.seed, self.lanes = seed, LANES
        self._luminous = cells.bands.luminous()
        is_known = looks is not None and looks[sides].sum() > 0.0
        self._worth = looks if is_known else np.repeat(cells.area, 2)
        self._set_sides(sides)
        self._margin = np.asarray(margin, dtype=self._sides.dtype)

    def find(self, work: float | None = None, careful: int = CAREFUL_PATHS) -> None:
        """Find the light of all cells from nothing, and which cells are too uneven to be read.

        Parameters
        ----------
        work : float or None    Samples of the job, where they are known: sweeps need not be more careful than that.
        careful : int    Paths of the last sweep, where cells are few.
        """
        finish(self.finding(work, careful))

    def finding(
        self,
        work: float | None = None,
        careful: int = CAREFUL_PATHS,
        is_warm=False,
        least: int = LEAST_CAREFUL,
    ):
        """As `find`, but a generator that pauses after every launch.

        ``is_warm``: whether to set out from the light that the cells hold, that of another state of the scene. ``least``:
        samples of a turn in the last sweep, `LEAST_CAREFUL` or `QUARTERS`.
        """
        turns = self.cells.bands.turns
        negligible = SOON if least < LEAST_CAREFUL else NEGLIGIBLE
        lit = yield from self._renewing() if is_warm else self._converging(negligible)
        lanes = max(self.lanes_per_sample, 1)
        wanted = max(CAREFUL // turns, careful // lanes)
        if work is not None:
            wanted = min(wanted, max(CAREFUL_SHARE * work, careful) / lanes)
        # In photometric variants one turn is all there is.
        wanted = max(wanted, least if turns > 1 else LEAST_CAREFUL)
        samples = 1 << min(int(np.log2(wanted)), int(np.log2(MOST_CAREFUL)))
        rough = int(ROUGH_SHARE * samples)
        # What is as rough already, or has no lack of samples, gains nothing.
        if not is_warm and rough > max(FEWEST // turns, 1):
            made = yield from self._sweeping(FIRST_SWEEPS - 1, rough)
            values = self._balanced(made)
            lit |= values.max(axis=1, initial=0.0) > 0.0
            self._store(values)
        read = self._sides
        self._set_sides(np.concatenate([read, self._margin]))
        made = yield from self._sweeping(FIRST_SWEEPS - 2, samples)
        values = self._balanced(made)[: len(read)]
        lit |= values.max(axis=1, initial=0.0) > 0.0
        self._mark_uneven(made.sum(axis=0), len(read))
        self._set_sides(read)
        self._store(values)
        yield from self._emptying_shade(values)
        # Sides that no light was ever found on lie inside solids.
        self._set_sides(self._sides[lit])

    def _renewing(self):
        """Sweep on from the light of another state until little changes; returns as `_converging`."""
        held, last = self._held(), None
        lit = held.max(axis=1, initial=0.0) > 0.0
        for _ in range(MOST_RENEWED):
            made = yield from self._sweeping(FIRST_SWEEPS, max(FEWEST // self.cells.bands.turns, 1))
            if not made[0].any():
                break
            values = self._balanced(made, MOST_RAISED)
            lit |= values.max(axis=1, initial=0.0) > 0.0
            self._store(values)
            # Of light that has moved the sum tells nothing.
            change, now = self._total(np.abs(values - held)), self._total(values)
            if last is not None:
                share = min(change / last, 0.98) if last > 0.0 else 0.0
                if change * max(share / (1.0 - share), 1.0) <= RENEWED * now:
                    return lit
            held, last = values, change
        # Light that nothing sends any more would die away slowly.
        self._store(np.zeros((len(self._sides), self.cells.bands.count)))
        return (yield from self._converging())

    def _converging(self, negligible: float = NEGLIGIBLE):
        """Sweep from nothing until the rest is negligible; returns which sides any light was found on."""
        total, before = 0.0, None
        turns = self.cells.bands.turns
        lit = np.zeros(len(self._sides), dtype=bool)
        for number in range(MOST_SWEEPS):
            # The same points each time, so that what is added falls evenly, without noise.
            made = yield from self._sweeping(FIRST_SWEEPS, max(FEWEST // turns, 1))
            values = self._balanced(made, MOST_RAISED)
            before_lit = int(lit.sum())
            lit |= values.max(axis=1, initial=0.0) > 0.0
            grows = lit.sum() > (1.0 + GROWING) * before_lit
            self._store(values)
            now = self._total(values)
            change, total = abs(now - total), now
            if now <= 0.0 and number > 0:
                break
            if before is not None and number >= FEWEST_SWEEPS and not grows:
                share = min(change / before, 0.98) if before > 0.0 else 0.0
                if change * max(share / (1.0 - share), 1.0) <= negligible * now:
                    break
            before = change
        return lit

    def refresh(self, number: int, samples: int) -> None:
        """Sweep once. ``number``: which points, ``samples``: for every cell and turn, a power of two.

        Nothing of what cells held is kept. On the average over passes that would lower no noise; it would only be the
        same in passes that follow each other, whose scatter would not show it.
        """
        finish(self.refreshing(number, samples))

    def refreshing(self, number: int, samples: int):
        """As `refresh`, but a generator that pauses after every launch. Until its end the cells hold what they held."""
        self.counts = np.zeros(2, dtype=np.int64)
        if len(self._sides):
            made = yield from self._sweeping(number, samples)
            self._store(self._balanced(made))

    def _held(self) -> np.ndarray:
        """Ratios (sides, nodes) of the sides at work, as they are."""
        return np.array(self.cells.values).reshape(2 * self.cells.count, -1)[self._sides]

    def _balanced(self, made: np.ndarray, most: float = MOST_SCALED) -> np.ndarray:
        """Light of all other kinds plus that of the cells, the latter scaled so that light gained is light lost.

        What the cells held before may have been too much or too little all over, and in bright rooms such an error dies away
        slowly. The light T that they held should have been the other light D plus the part G that came back of it; so its
        scale was off by D / (T - G).
        """
        straight, back = _whole(made[:1]), _whole(made[1:])
        lost = self._total(self._held()) - self._total(back)
        gained = self._total(straight)
        scale = gained / lost if lost > 0.0 and gained > 0.0 else 1.0
        return straight + back * (scale if 1.0 / most < scale < most else 1.0)

    def state(self) -> dict[str, np.ndarray]:
        """What `restore` needs."""
        return {
            "values": np.array(self.cells.values, dtype=np.float32),
            "uneven": np.array(self.cells.uneven).astype(np.uint8),
            "sides": self._sides,
        }

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Go on from a state."""
        self._set_sides(state["sides"])
        self.cells.values = upload(mi.Float, state["values"])
        self.cells.uneven = upload(mi.Bool, state["uneven"] > 0)
        dr.eval(self.cells.values, self.cells.uneven)

    @property
    def lanes_per_sample(self) -> int:
        """Paths that one more sample of every cell takes."""
        return len(self._sides) * self.cells.bands.turns

    # ---- private ----

    def _set_sides(self, sides: np.ndarray) -> None:
        self._sides, self._weights = sides, self._worth[sides]
        self._rows = upload(mi.UInt32, self._sides if len(self._sides) else [0])
        dr.eval(self._rows)

    def _total(self, values: np.ndarray) -> float:
        """Light that the job sees, up to a factor, of ratios (sides, nodes) of the sides at work."""
        return float((values @ self._luminous * self._weights).sum())

    def _mean(self, light: np.ndarray) -> float:
        """Mean of what the job sees, of light (sides,) of the sides at work."""
        return float((light * self._weights).sum() / max(self._weights.sum(), 1e-300))

    def _store(self, values: np.ndarray) -> None:
        """Write ratios (sides, nodes) of the sides at work."""
        bands = self.cells.bands.count
        table = np.zeros((2 * self.cells.count, bands), dtype=np.float32)
        table[self._sides] = values
        self.cells.values = upload(mi.Float, table)
        dr.eval(self.cells.values)

    def _mark_uneven(self, made: np.ndarray, read: int | None = None) -> None:
        """Mark sides that are too uneven to be read. ``read``: how many of those at work may be; None: all."""
        light = self._light_of_halves(made.astype(np.float64))
        quarters = light.mean(axis=2)
        noise = np.sqrt(((light[..., 0] - light[..., 1]) ** 2).mean(axis=1) / 4.0)
        brightest, darkest = quarters.max(axis=1), quarters.min(axis=1)
        mean = self._mean(quarters.mean(axis=1))
        noise = _pool(noise, quarters.mean(axis=1), DARK * mean)
        marked = brightest - darkest > SIGNIFICANT * np.sqrt(2.0) * noise
        marked &= (brightest > UNEVEN * darkest) & (brightest > DARK * mean)
        marked |= self._edges(quarters.mean(axis=1), noise, mean)
        flags = np.ones(max(2 * self.cells.count, 1), dtype=bool)
        flags[self._sides[:read]] = marked[:read]
        self.cells.uneven = upload(mi.Bool, flags)
        dr.eval(self.cells.uneven)

    def _light_of_halves(self, made: np.ndarray) -> np.ndarray:
        """Light of quarters by halves: those of the samples, or every other turn where there is but one sample of a turn.

        Nodes of turns lie between each other, so that either half has all colours. (sides, nodes, 4, 1 or 2) to
        (sides, 4, 2)
        """
        if made.shape[-1] == 2:
            return np.tensordot(self._luminous, made, axes=(0, 1))
        bands, halves = self.cells.bands, []
        for parity in range(2):
            own = np.arange(bands.count) % bands.turns % 2 == parity
            halves.append(np.tensordot(bands.luminous(own), made[..., 0][:, own], axes=(0, 1)))
        return np.stack(halves, axis=-1)

    def _emptying_shade(self, values: np.ndarray):
        """Sweep dark sides until they have lost what came from cells that are not read any more.

        Cells that reach under a wall bring light into the dark room behind it before they are known as uneven. There it
        would die away slowly, as it is all the light there is.
        """
        everyone, light = self._sides, values @ self._luminous
        mean = self._mean(light)
        shade = (light < SHADE * mean) & ~np.array(self.cells.uneven)[everyone]
        if not shade.any():
            return
        dark = everyone[shade]
        worth = self._weights[shade]
        least = EMPTY * mean * worth.sum()
        samples = max(SHADE_SAMPLES // self.cells.bands.turns, 1)
        for number in range(MOST_SWEEPS):
            before = float((values[shade] @ self._luminous * worth).sum())
            self._set_sides(dark)
            made = yield from self._sweeping(FIRST_SWEEPS - 3 - number, samples)
            values[shade] = _whole(made)
            self._set_sides(everyone)
            self._store(values)
            after = float((values[shade] @ self._luminous * worth).sum())
            if after <= least or after >= STEADY * before:
                break

    def _edges(self, light: np.ndarray, noise: np.ndarray, mean: float) -> np.ndarray:
        """Sides that differ much from a neighbour: what parts them may run through either. (n,) bool"""
        cells = self.cells
        values, errors = np.zeros(2 * cells.count), np.zeros(2 * cells.count)
        values[self._sides], errors[self._sides] = light, 0.5 * noise
        marked = np.zeros(2 * cells.count, dtype=bool)
        for face in (0, 1):
            a, b = (2 * each + face for each in cells.neighbours)
            high, low = np.maximum(values[a], values[b]), np.minimum(values[a], values[b])
            far = high - low > SIGNIFICANT * np.hypot(errors[a], errors[b])
            far &= (high > EDGE * low) & (high > DARK * mean)
            marked[a[far]] = marked[b[far]] = True
        return marked[self._sides]

    def _sweeping(self, salt: int, samples: int):
        """Ratios, that of the cells apart from the rest, by side, node, quarter and half.

        Returns
        -------
        (2, sides, nodes, 4, 2) float32 array of ``samples`` of 8 and more, (.., 4, 1) of 4, (.., 1, 1) of fewer.

        It pauses after every launch.
        """
        turns = self.cells.bands.turns
        split = {QUARTERS: (4, 1)}.get(samples, (4, 2) if samples >= LEAST_CAREFUL else (1, 1))
        block = samples // (split[0] * split[1])
        per_launch = max(LANES // (turns * samples), 1)
        nodes = self.cells.bands.count
        found = np.empty((2, len(self._sides), nodes, *split), dtype=np.float32)
        first = 0
        while first < len(self._sides):
            if self.cancelled():
                raise Cancelled("cancelled")
            # The numbers of samples begin anew with every whole launch, however it is cut.
            begun = first % per_launch
            count = min(per_launch - begun, max(self.lanes // (turns * samples), 1))
            count = min(count, len(self._sides) - first)
            launched = self._launch(first, count, samples, salt, begun)
            for part, ratios in zip(found, launched, strict=True):
                for k, ratio in enumerate(ratios):
                    sums = dr.block_reduce(dr.ReduceOp.Add, ratio, block)
                    made = np.array(sums).reshape(count, turns, *split) / block
                    # Number of a node = turn + turns * place in the path.
                    part[first : first + count, k * turns : (k + 1) * turns] = made
            first += count
            yield
        return found

    def _launch(self, first: int, count: int, samples: int, salt: int, begun: int) -> list[list]:
        scene, cells = self.scene, self.cells
        turns = cells.bands.turns
        many = dr.opaque(mi.UInt32, samples)
        start = dr.opaque(mi.UInt32, first)
        seed = dr.opaque(mi.UInt32, (int(self.seed) * 747796405 + salt * 2891336453) & 0xFFFFFFFF)

        lane = dr.arange(mi.UInt32, count * turns * samples)
        sample, turn = lane % many, (lane // many) % turns
        side = dr.gather(mi.UInt32, self._rows, start + lane // (many * turns))
        own = hash_words(side, seed)
        # Four quarters in turn, so that each sees as many samples; the first by chance, for as few samples as one. Their
        # places evenly too, so that a border which runs through a quarter does not pass for noise.
        quarter = ((sample * 4) // many + hash_words(own, turn) * mi.UInt32(many < 4)) % 4
        even = sobol_pair(turn * many + sample, own, gather.PAIR_PLACE).x
        of_quarter = PLACES // 4
        number = quarter * of_quarter + dr.minimum(mi.UInt32(even * of_quarter), of_quarter - 1)
        si, row = cells.place(side, number)
        wavelengths = cells.bands.wavelengths(turn)
        if wavelengths is not None:
            si.wavelengths = wavelengths
        serial = lane + dr.opaque(mi.UInt32, begun * turns * samples)
        stream, one = random_stream(serial, own), mi.Float(1.0)

        def respond(direction):
            cosine = dr.maximum(dr.dot(direction, si.sh_frame.n), 0.0)
            passes = 1.0 - cells.matt.coat(row, cosine, True)
            return dr.select(dr.dot(direction, si.n) > 0.0, cosine * passes, 0.0)

        def receiver(pair: int, salt: int = 0) -> Receiver:
            point = sobol_pair(turn * many + sample, own ^ salt, pair)
            return Receiver(si, wavelengths, stream, point, one, respond)

        straight = receiver(gather.PAIR_LIGHT)
        parts = [
            direct(scene, straight) + mirrored(scene, receiver(gather.PAIR_LIGHT, MIRROR_SALT)),
            *gathered(
                scene,
                cells,
                receiver(gather.PAIR_SCATTER),
                is_apart=True,
                left_out=self._left_out,
                guide=self.guide,
            ),
        ]
        # Light of the cells last, all other before.
        parts = [parts[0] + parts[1], parts[2]]
        if scene.bent is not None:
            parts[0] += scene.bent.light(si, stream, straight.answer, mi.Bool(True))
        if self.guide is not None:
            traced, read = self.guide.light(scene, receiver(gather.PAIR_LENS), stream)
            parts = [parts[0] + traced, parts[1] + read]
        lost = LostSamples(1)
        ratios = [cells.bands.ratios(value, wavelengths) for value in parts]
        kept = lost.keep([each for part in ratios for each in part], mi.UInt32(0))
        # At the full width of the launch, also where there is no light to choose.
        kept = [each + mi.Float(lane) * 0.0 for each in kept]
        dr.eval(kept)
        self.counts += int(lost.counts()[0]), dr.width(lane)
        return [kept[: len(ratios[0])], kept[len(ratios[0]) :]]


def finish(steps):
    """Run a generator to its end; returns what it returns."""
    try:
        while True:
            next(steps)
    except StopIteration as end:
        return end.value


def _pool(noise: np.ndarray, light: np.ndarray, least: float) -> np.ndarray:
    """Standard errors of quarters of cells, drawn towards those that are usual, relative to their light. (n,)

    Four differences tell a cell's own error so badly that, of all that differ by chance, those would stand out whose halves
    happen to agree (Student). ``least``: light of a cell that tells what is usual.
    """
    lit = light > least
    if not lit.any():
        return noise
    usual = float(np.median(noise[lit] / light[lit]))
    return np.sqrt(0.5 * (noise**2 + (usual * light) ** 2))


def _whole(made: np.ndarray) -> np.ndarray:
    """Sum of the kinds of light, mean over quarters and halves: (sides, nodes)."""
    return made.sum(axis=0, dtype=np.float64).mean(axis=(2, 3))
