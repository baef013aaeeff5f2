"""The job that finds daylight coefficients: paths for the sky, rays for the sun, sensors block by block.

Sensors look no farther than to the cells, which have been looked at before (`sky_cells`), in bands of wavelengths where
light has colours (`sky_bands`).
"""

import time
from dataclasses import dataclass
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from ...accuracy.estimate import Estimate
from ...accuracy.stopping import Progress
from ...arrays import upload
from ...daylight.coefficients import DaylightOrder, gather_suns
from ...errors import Cancelled
from ...sky.nodes import SkyNodes, find_projection
from ..paths import gather
from ..paths.illuminance import Places, Receivers
from ..paths.sampler import hash_words, random_stream, sobol_pair
from ..paths.visible_surfaces import Sight
from ..paths.wavelengths import make_sampler
from ..pictures.view_cells import Division
from .cell_landings import PATHS as LANDING_PATHS
from .cell_landings import Landings, LandingTable, find_order
from .sky_bands import SkyBands, choose_bands, find_samples
from .sky_cells import CellSky, CellTracer, SunOnCells
from .sky_paths import SkyTable, read_sums, trace_sensors
from .sun_rays import HALVES, SunRays

GROUPS = 10
"""Independent groups of paths: with what else is not known these are the sixteen causes of error of `daylight.light`."""

LOOKS = 1 << 14
"""Rays that find which surfaces matter."""

LANES = 1 << 20
"""Paths of a launch."""

TABLE_BYTES = 300 << 20
"""Memory for the sums of a block of sensors."""

LARGEST_BATCH = 1 << 16
"""Paths of a sensor in a group in one launch."""

FIRST = 32
"""Paths of a sensor in a group before its error is asked for."""

FEWEST = 2048
"""Paths of a sensor from which on groups of them tell errors well: with 512 intervals of 95 % held 77 % of the daylight
factors of a room, with 4096 95 to 98 % of all figures of sensors."""

LANDING_SALT = 0x1A2D
"""Sets the paths that find where cells are met apart from all others."""

STAGE = "daylight"
"""What the job is called while it runs."""


@dataclass(frozen=True)
class Found:
    """Fields of `DaylightCoefficients` but the provenance, and what is to be said."""

    fields: dict
    notes: tuple[str, ...]


def find_coefficients(
    scene, positions, normals, order: DaylightOrder, progress=None, cancelled=lambda: False
) -> Found:
    """Find what sensors have of the sky and the sun.

    Parameters
    ----------
    scene : CompiledScene    Lit by an even world of 1 cd/m2 alone.
    positions, normals : (n, 3) array    World space. [m]
    order : DaylightOrder
    progress : callable or None    Gets a `Progress`.
    cancelled : callable    Asked before every launch.

    Raises
    ------
    SceneError    A position or normal is not usable.
    Cancelled    When ``cancelled`` answered true.
    """
    job = _Job(scene, Receivers.at_points(positions, normals), order, progress, cancelled)
    kept = scene.spots
    scene.spots = None
    try:
        return job.run()
    finally:
        scene.spots = kept


class _Job:
    def __init__(self, scene, receivers: Receivers, order: DaylightOrder, progress, cancelled):
        self.scene, self.receivers, self.order = scene, receivers, order
        self.progress, self.cancelled = progress, cancelled
        self.count = len(receivers.start)
        self.nodes = SkyNodes(order.steps)
        self.sampler = make_sampler(scene, "luminance")
        self.places = Places(scene, receivers)
        self.rule, self.begun = order.rule, time.perf_counter()
        self.cells, self.sides, looks = self._divide()
        self.bands = self._choose_bands(looks)
        self.middles, self.neighbours, self.shares = gather_suns(order.suns, order.spacing)

    def run(self) -> Found:
        """All sensors."""
        sun = self._find_sun()
        turn = _node_matrices(self.nodes, self.middles)
        behind = self._trace_cells(sun, turn)
        width, many = self.nodes.count + 1, len(self.middles)
        fields = {
            "steps": self.order.steps,
            "sky": np.zeros((GROUPS, self.count, width), dtype=np.float32),
            "reflected": np.zeros((GROUPS, self.count, many), dtype=np.float32),
            "doubts": np.zeros((2, self.count, many), dtype=np.float32),
            "reading": np.zeros(self.count, dtype=np.float32),
            "direct": np.zeros((self.count, len(self.order.suns)), dtype=np.float32),
            "direct_error": np.zeros((self.count, len(self.order.suns)), dtype=np.float32),
            "neighbours": self.neighbours,
            "shares": self.shares,
            "samples": 0,
            "lost": 0 if behind is None else behind.lost,
        }
        row_bytes = 8 * (2 * width + max(len(self.sides), 1) * (1 + self.bands.count)) * GROUPS
        block = max(min(TABLE_BYTES // row_bytes, self.count), 1)
        for first in range(0, self.count, block):
            part = slice(first, min(first + block, self.count))
            found = self._trace(part, behind)
            fields["sky"][:, part] = found.sky
            by_nodes = found.rest[..., :-1] @ turn[0]
            fields["reflected"][:, part] = found.cells @ sun.mean + by_nodes
            mean, coarse = by_nodes.mean(axis=0), found.rest[..., :-1].mean(axis=0) @ turn[1]
            fields["doubts"][0, part] = mean - coarse
            fields["doubts"][1, part] = found.cells.mean(axis=0) @ sun.half
            if behind is not None:
                fields["sky"][:, part] += found.read @ behind.light[..., :width]
                fields["reflected"][:, part] += found.read @ behind.light[..., width:]
                fields["doubts"][:, part] += found.read_sides.mean(axis=0) @ behind.doubts
                fields["reading"][part] = found.reading
            fields["samples"] = max(fields["samples"], found.samples)
            fields["lost"] += found.lost
            fields["direct"][part], fields["direct_error"][part] = self._see_suns(part)
        return Found(fields, self._notes(fields["samples"]))

    # ---- private ----

    def _notes(self, samples: int) -> tuple[str, ...]:
        """What is to be said."""
        notes = []
        if self.count and not len(self.sides):
            notes.append(
                "no surface is matt: the sun over surfaces is known by parts of the sky alone"
            )
        if self.count and samples < FEWEST:
            notes.append(
                f"{samples} paths of a sensor are few: stated errors may be too small; they are right from {FEWEST} on"
            )
        return tuple(notes)

    def _divide(self):
        """Cells, the sides of them that sensors may see, and how often these are looked at."""
        places, normals = self.receivers.outlooks(self.scene)
        rng = np.random.default_rng([self.order.seed & 0xFFFFFFFF, 17])
        rows = rng.integers(0, max(len(places), 1), LOOKS if len(places) else 0)
        sight = Sight(self.scene, places[rows], normals[rows], self.order.seed)
        division = Division(self.scene, sight, self.order.cells)
        sides = division.sides if len(division.cells.sides) else np.zeros(0, dtype=np.uint32)
        return division.cells, sides, division.looks[sides]

    def _choose_bands(self, looks) -> SkyBands:
        """Bands of wavelengths in which cells have to know their light."""
        if self.sampler is None or not len(self.sides):
            return SkyBands.one()
        light, sides = self.scene.mean_light, upload(mi.UInt32, self.sides)
        wavelengths = find_samples(light)
        si, matt = self.cells.place(sides, mi.UInt32(0))
        columns = []
        for start in range(0, len(wavelengths), 4):
            si.wavelengths = mi.Spectrum(*map(float, wavelengths[start : start + 4]))
            found = self.scene.bsdf(si, matt > 0).eval_diffuse_reflectance(si, matt > 0)
            columns += [np.array(found[k]) for k in range(4)]
        reflectances = np.stack(np.broadcast_arrays(*columns), axis=-1)
        return choose_bands(light, reflectances.reshape(len(self.sides), -1), looks)

    def _trace_cells(self, sun, turn) -> CellSky | None:
        """What the sides of cells have; None where there are none."""
        if not len(self.sides):
            return None
        tracer = CellTracer(
            self.scene,
            self.cells,
            self.sides,
            self.nodes,
            sun,
            self.sampler,
            self.bands,
            turn,
            self.order.seed,
            GROUPS,
            self.cancelled,
        )
        made = tracer.find(
            self.rule,
            self.count,
            lambda share: self._tell(0, float("inf"), 0.0, "daylight on surfaces"),
        )
        flags = np.ones(max(2 * self.cells.count, 1), dtype=bool)
        flags[self.sides] = made.uneven
        self.cells.uneven = upload(mi.Bool, flags)
        dr.eval(self.cells.uneven)
        return made

    def _find_sun(self) -> SunOnCells:
        """What of the sun passes the coats of cells."""
        self._tell(0, float("inf"), 0.0, "sun on surfaces")
        landings = self._find_landings()
        sides, cells, places = upload(mi.UInt32, self.sides), self.cells, landings.on_device()

        def make_surface(half, row, point):
            side = dr.gather(mi.UInt32, sides, row)
            si, matt, is_inside = cells.point(side, places.place(half, row, point))
            is_matt = matt > 0

            def passes(cosine, lit):
                return 1.0 - cells.matt.coat(matt, cosine, lit & is_matt)

            return si, passes, is_matt & is_inside

        surfaces = tuple(partial(make_surface, half) for half in range(HALVES))
        made = self._suns_of(self.middles, 1).glance(surfaces, len(self.sides))
        return SunOnCells(made.mean(axis=0), 0.5 * (made[0] - made[1]))

    def _find_landings(self) -> Landings:
        """Where paths of sensors meet the sides of cells."""
        if not self.count or not len(self.sides):
            return Landings.of(len(self.sides), *np.zeros((2, 0), dtype=int), *np.zeros((3, 0)))
        if self.cancelled():
            raise Cancelled("cancelled")
        lane = np.arange(LANDING_PATHS, dtype=np.int64)
        # Neighbours have the same sensor, where there are not more of these than paths.
        sensor = lane * self.count // LANDING_PATHS
        places, _ = self.receivers.outlooks(self.scene)
        table = LandingTable(self.sides, find_order(np.asarray(places))[sensor])
        lane, who = upload(mi.UInt32, lane), upload(mi.UInt32, sensor)
        self._follow(table, lane, who, lane, dr.opaque(mi.UInt32, LANDING_SALT))
        made = table.read()
        # Nothing tells where in a cell that many triangles share a path ends.
        made.known[:, self.cells.shared[self.sides // 2]] = False
        return made

    def _see_suns(self, part: slice) -> tuple[np.ndarray, np.ndarray]:
        """What sensors have of every sun straight, with standard errors. (n, k), (n, k) [-]"""
        start = dr.opaque(mi.UInt32, part.start)

        def make_surface(row, point):
            number = mi.UInt32(point.x * 65536.0)
            si = self.places.choose(start + row, mi.UInt32(0), number, None)
            return si, lambda cosine, lit: mi.Float(1.0), mi.Bool(True)

        rays = self._suns_of(self.order.suns, 2 + part.start)
        return rays.see(make_surface, part.stop - part.start)

    def _suns_of(self, suns: np.ndarray, salt: int) -> SunRays:
        order = self.order
        seed = order.seed + 7919 * salt
        return SunRays(self.scene, suns, order.angle, self.sampler, seed, self.cancelled)

    def _trace(self, part: slice, behind: CellSky | None) -> "_Traced":
        """Paths of a block of sensors."""
        count, sides = part.stop - part.start, len(self.sides)
        read = {}
        if behind is not None:
            beyond = behind.beyond
            # Nothing tells in which quarter of a cell that many triangles share a path ends.
            beyond[self.cells.shared[self.sides // 2]] = 0.0
            read = {"even": behind.even, "beyond": beyond, "read_bands": self.bands.on_device()}
        table = SkyTable(self.nodes, GROUPS * count, self.cells.count, self.sides, **read)
        done, batch = 0, self._within_rule(FIRST, 0)
        while True:
            self._pass(table, part.start, count, batch, done)
            done += batch
            light = _by_group(table.parts, count, 1, done)[..., 0]
            error = Estimate.from_groups(light, done * GROUPS).relative_error()
            needed = self._needed(done, error)
            self._tell(done * GROUPS, error, (part.start + count * min(done / needed, 1.0)))
            if done >= needed:
                break
            batch = self._within_rule(min(done, LARGEST_BATCH), done)
        made = _Traced(
            _by_group(table.sky, count, table.width, done),
            _by_group(table.rest, count, table.width, done),
            np.zeros((GROUPS, count, 0), dtype=np.float32),
            done * GROUPS,
            int(np.array(table.lost).sum()),
        )
        if sides:
            made.cells = _by_group(table.cells, count, sides, done)
        if behind is not None:
            made.read = _by_group(table.read, count, sides * self.bands.count, done)
            made.read_sides = made.read.reshape(GROUPS, count, sides, -1).sum(axis=3)
            more, less = (_by_group(each, count, 1, done) for each in (table.more, table.less))
            beyond = (more - less).mean(axis=(0, 2))
            off = self._doubt_reading(made.read_sides.mean(axis=0), beyond, behind)
            made.reading = off / np.maximum(light.mean(axis=0), 1e-30)
        return made

    def _doubt_reading(self, read, beyond, behind: CellSky) -> np.ndarray:
        """What reading cells may change of the light of an even world of 1 cd/m2. (n,) [lx]

        ``read``: (n, s); ``beyond``: by how much it changes with quarters of cells (n,) [lx]
        """
        is_shared = self.cells.shared[self.sides // 2]
        spread = behind.quarters[is_shared].std(axis=1)
        within = self.bands.within * (read @ behind.quarters.mean(axis=1))
        return np.sqrt(beyond**2 + within**2 + (read[:, is_shared] ** 2) @ spread**2)

    def _within_rule(self, batch: int, done: int) -> int:
        """Paths of a sensor and group that the next pass adds, not beyond what the rule has."""
        if self.rule.samples is None:
            return batch
        return max(min(batch, -(-self.rule.samples // GROUPS) - done), 1)

    def _needed(self, done: int, error: float) -> float:
        """Paths of a sensor and group after which the rule is met, as it seems now."""
        rule, ends = self.rule, [np.inf]
        if rule.samples is not None:
            ends.append(-(-rule.samples // GROUPS))
        if rule.error is not None and np.isfinite(error):
            ends.append(done * (error / rule.error) ** 2)
        if rule.seconds is not None:
            spent = time.perf_counter() - self.begun
            ends.append(done * rule.seconds / max(spent, 1e-9))
        return max(min(ends), 1.0)

    def _pass(self, table, start: int, count: int, batch: int, done: int) -> None:
        """Paths of all sensors of a block, ``batch`` each in every group."""
        per_launch = max(LANES // batch, 1)
        rows = GROUPS * count
        for first in range(0, rows, per_launch):
            if self.cancelled():
                raise Cancelled("cancelled")
            self._launch(table, start, count, first, min(per_launch, rows - first), batch, done)

    def _launch(self, table, start, count, first, rows, batch, done) -> None:
        lane = dr.arange(mi.UInt32, rows * batch)
        many = dr.opaque(mi.UInt32, int(batch))
        block = dr.opaque(mi.UInt32, int(count))
        sample = dr.opaque(mi.UInt32, int(done)) + lane % many
        row = dr.opaque(mi.UInt32, int(first)) + lane // many
        who = dr.opaque(mi.UInt32, int(start)) + row % block
        self._follow(table, row, who, sample, row // block + 1)
        table.evaluate()

    def _follow(self, table, row, who, sample, salt) -> None:
        """Follow a path of every lane's sensor ``who``, by sample and ``salt`` its random numbers, for a row of a table."""
        seed = dr.opaque(mi.UInt32, int(self.order.seed) & 0xFFFFFFFF)
        own_seed = hash_words(who, hash_words(salt, seed))
        wavelengths = gather.draw_wavelengths(self.sampler, sample, own_seed)
        trace_sensors(
            self.scene,
            table,
            self.cells,
            self.places.choose(who, sample, own_seed, wavelengths),
            lambda cosine: mi.Float(1.0),
            row,
            wavelengths,
            self.sampler,
            random_stream(sample, own_seed),
            (
                sobol_pair(sample, own_seed, gather.PAIR_LIGHT),
                sobol_pair(sample, own_seed, gather.PAIR_SCATTER),
            ),
        )

    def _tell(self, samples: int, error: float, sensors: float, stage: str = STAGE) -> None:
        """Report. ``sensors``: so many are done, in parts too."""
        if self.progress is None:
            return
        spent, share = time.perf_counter() - self.begun, sensors / max(self.count, 1)
        left = spent * (1.0 / share - 1.0) if share > 0.0 else None
        self.progress(Progress(share, samples, error, spent, left, stage))


@dataclass(eq=False)
class _Traced:
    """What paths of sensors have found, by group: of nodes, the same for the sun, of cells, and of those where paths end.

    ``read_sides``: the last without bands. ``reading``: what ending there may change, relative to the light. (n,) [-]
    """

    sky: np.ndarray
    rest: np.ndarray
    cells: np.ndarray
    samples: int
    lost: int
    read: np.ndarray | None = None
    read_sides: np.ndarray | None = None
    reading: np.ndarray | None = None


def _by_group(sums, count: int, width: int, done: int) -> np.ndarray:
    """Sums of a table by group, over the paths. (groups, count, width) float32"""
    made = read_sums(sums, GROUPS * count, width) / np.float32(done)
    return made.reshape(GROUPS, count, width)


def _node_matrices(nodes: SkyNodes, suns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """From sums by node to what comes per solid angle from suns, and the same as nodes twice as far apart would have it.

    Returns
    -------
    (nodes, m), (nodes, m) float32 array    [sr-1], in units of the sun's illuminance for 1 cd/m2 and sr.
    """
    areas = find_projection(nodes.steps).node_areas
    fine = nodes.spread(suns) / areas
    coarse = SkyNodes(max(nodes.steps // 2, 4))
    wide = find_projection(coarse.steps).node_areas
    to_coarse = coarse.spread(nodes.directions())
    doubled = to_coarse @ (coarse.spread(suns) / wide).T
    return fine.T.astype(np.float32), doubled.astype(np.float32)
