"""The second witness: a pilot from the lights that tells what every object receives, whatever gathering has found.

Gathering and light tracing fail in different places. Paths from the lights do not care how small a bright spot is, or what
bends the light on its way; only that it arrives. So a few of them tell whether an estimate can be trusted, and where the
energy of the scene goes.
"""

from dataclasses import dataclass, field

import drjit as dr
import mitsuba as mi
import numpy as np

from ...accuracy.witnesses import batch_error
from ...arrays import upload
from ...errors import Cancelled
from ..light_tracing.all_lights import SUN, AllLights
from ..light_tracing.far_disks import Focus
from ..paths.sampler import launch_stream
from ..paths.wavelengths import make_sampler
from .sums import Sums
from .walk import BENT, CLOSE, MAXIMUM_STEPS, MIRRORED, NOBODY, PASSED, make_tally, walk

PATHS, FEWEST_PATHS = 1 << 18, 1 << 15
"""Paths of a pilot, and the fewest where they are long."""

WORK = 1 << 22
"""Surfaces that all paths of a pilot may meet together before there are fewer of them."""

LOOKS = (1, 2, 8)
"""Times as many paths and surfaces in a first look, and in others where the one before leaves doubt."""

PROBE = 1 << 12
"""Paths that tell how long they are."""

SURVEY = 1 << 15
"""Paths that tell which lights matter."""

SUN_SURVEY, FINE_SURVEY = 1 << 18, 1 << 20
"""Rays of each sun that find where its light is worth following, and those of a finer look where few of them are."""

FEW = 0.01
"""Share of a sun's rays below which a finer look is worth it."""

MOST_SUNS = 4
"""Suns that are surveyed like that; more of them share the same rays."""

MOST_FEW = 4.0
"""Most that a light gets more paths since few of them bring its light."""

SURVEY_STEPS = 8
"""Surfaces on a path of the survey."""

BATCHES = 32
"""Independent batches by which errors are told."""

LANES = 1 << 19
"""Paths of one launch."""

FLUX_SHARE = 0.3
"""Share of the paths that follows the flux of the lights; the rest follows what they bring."""

SALT = 0x7717
"""Sets these paths apart from others of the same seed."""

WALKING = 2
"""Purpose of the random numbers of walks, see `all_lights.DRAWING`."""

UNLIMITED = 0x7FFFFFFF
"""Scatterings that no path has."""

REFLECTED = 16
"""Mark of light that does not come straight, beside the traces of `walk`."""


@dataclass(frozen=True)
class Amount:
    """A flux and its standard error. [lm]"""

    value: float
    error: float


@dataclass(frozen=True)
class Cause:
    """Where most of the light of something comes from.

    Parameters
    ----------
    light : str    Name of the light that gives most of it.
    way : str    How it gets there, for people.
    """

    light: str
    way: str

    def text(self) -> str:
        """Light and way in one phrase."""
        return f"light of '{self.light}' {self.way}"


@dataclass(frozen=True)
class WitnessReport:
    """What a pilot has found.

    Parameters
    ----------
    objects : tuple of (str, bool)    Ids of objects, and whether their back is meant.
    flux_batches : (b, n) array    Light that these sides receive, all reflections included, of independent batches. [lm]
    absorbed : (n,) array    What of it they keep. [lm]
    sheet_batches : (b, k) array    Illuminance of the squares about sensors. [lx]
    emitted, taken, left, cut, rest : Amount    Light of all lights, what of it is absorbed, leaves the scene, is not
        followed any further, and what these differ by: roulette, by chance.
    lights : dict of str to float    What each light emits. [lm]
    heaviest : float    Flux of the heaviest path: what brings less may have been missed altogether. [lm]
    paths : int
    lost : int    Ways that ended where their light was no number.
    """

    objects: tuple[tuple[str, bool], ...]
    flux_batches: np.ndarray
    absorbed: np.ndarray
    sheet_batches: np.ndarray
    emitted: Amount
    taken: Amount
    left: Amount
    cut: Amount
    rest: Amount
    lights: dict[str, float] = field(default_factory=dict)
    heaviest: float = 0.0
    paths: int = 0
    lost: int = 0

    @property
    def flux(self) -> np.ndarray:
        """Mean of the batches. (n,) [lm]"""
        return self.flux_batches.mean(axis=0)

    @property
    def flux_error(self) -> np.ndarray:
        """Its standard error. (n,) [lm]"""
        return batch_error(self.flux_batches)

    @property
    def sheets(self) -> np.ndarray:
        """Mean of the batches. (k,) [lx]"""
        return self.sheet_batches.mean(axis=0)

    @property
    def sheet_errors(self) -> np.ndarray:
        """Its standard error. (k,) [lx]"""
        return batch_error(self.sheet_batches)

    def balance(self) -> dict:
        """Energy of the whole, for reports. [lm]"""
        parts = ("emitted", "taken", "left", "cut", "rest")
        names = ("emitted", "absorbed", "left_the_scene", "cut_off", "remainder")
        rows = {
            name: {"value": getattr(self, part).value, "standard_error": getattr(self, part).error}
            for name, part in zip(names, parts, strict=True)
        }
        return {"unit": "lm", **rows, "paths": self.paths}

    def told(self) -> tuple[str, ...]:
        """Say how many paths were lost; nothing where none were."""
        if not self.lost:
            return ()
        return (
            f"{self.lost} of {self.paths} light paths from the lights ended where their light was no number, so they bring "
            "too little; what gathering finds beside them is held by the stated errors",
        )


class Witness:
    """Traces light of all lights of a scene.

    Parameters
    ----------
    scene : CompiledScene
    seed : int    The same seed gives the same report.
    wanted : collection of (str, bool) or None    Sides of objects that matter, see `WitnessReport.objects`; None: all.
    sheets : Sheets or None    Squares about sensors.
    cancelled : callable    Asked before every launch.
    """

    def __init__(self, scene, seed: int, wanted=None, sheets=None, cancelled=lambda: False):
        self._scene, self._sheets, self._cancelled = scene, sheets, cancelled
        sampler = make_sampler(scene, "luminance")
        self._seed = (int(seed) + SALT) & 0xFFFFFFFF
        keys = list(dict.fromkeys(key for key, _, _ in scene.parts()))
        self.objects = tuple((key, is_back) for key in keys for is_back in (False, True))
        place = {each: row for row, each in enumerate(self.objects)}
        rows = np.full((scene.shape_count, 2), NOBODY, dtype=np.uint32)
        for key, part, _ in scene.parts():
            rows[part.number] = place[key, False], place[key, True]
        self._all_rows = upload(mi.UInt32, rows)
        matters = np.array([wanted is None or each in wanted for each in self.objects], dtype=bool)
        chosen = np.append(matters, [False])[np.minimum(rows, len(matters))]
        self._wanted_rows = upload(mi.UInt32, np.where(chosen, rows, NOBODY))
        dr.eval(self._all_rows, self._wanted_rows)
        self._limit, self._lanes = UNLIMITED, LANES
        asked = {key for (key, _), own in zip(self.objects, matters, strict=True) if own}
        corners = [corner for key in asked for corner in scene.object_bounds(key)]
        margin = 0.0
        if sheets is not None:
            corners += list(sheets.squares.centre)
            margin = sheets.view_distance()
        self._lights = AllLights(scene, sampler, self._seed, _focus(corners, margin))
        self._flux = float(sum(origin.flux for origin in self._lights.origins))

    def run(
        self, paths: int = PATHS, reflections: int | None = None, look: int = 1
    ) -> WitnessReport:
        """Trace.

        Parameters
        ----------
        paths : int
        reflections : int or None    Most reflections of light that counts; None: no limit.
        look : int    Of `LOOKS`: so many times as many paths, and other ones.

        Raises
        ------
        Cancelled    When ``cancelled`` answered true.
        """
        self._limit = UNLIMITED if reflections is None else int(reflections)
        self._paths = 0
        if not self._lights.origins:
            return self._empty()
        self._shares = self._learn()
        self._paths = paths = self._affordable(paths * look, look)
        which, chance = _spread(self._shares, paths, self._seed)
        tally = make_tally(self._all_rows, len(self.objects), BATCHES, self._flux)
        if self._sheets is not None:
            self._sheets.prepare(BATCHES, self._flux)
        given, heaviest = np.zeros((len(self._lights.origins), BATCHES)), 0.0
        for first in range(0, paths, self._lanes):
            rows = np.arange(first, min(first + self._lanes, paths))
            rays, *_ = self._launch(which[rows], chance, tally, rows, 2 + first // self._lanes)
            flux = np.array(rays.lumens(rays.power), dtype=np.float64)
            given += np.bincount(which[rows] * BATCHES + rows % BATCHES, flux, given.size).reshape(given.shape)  # fmt: skip
            heaviest = max(heaviest, float(flux.max(initial=0.0)))
        return self._report(tally, given, heaviest)

    def explain(self, row: int | None = None, sheet: int | None = None) -> Cause:
        """Trace the same paths again and tell where the light of one row or sheet comes from."""
        watcher = Watcher(self._scene, len(self._lights.origins), self._flux, row, sheet)
        which, chance = _spread(self._shares, self._paths, self._seed)
        tally = make_tally(self._all_rows, len(self.objects), BATCHES, self._flux)
        if self._sheets is not None:
            self._sheets.prepare(BATCHES, self._flux)
        for first in range(0, self._paths, self._lanes):
            rows = np.arange(first, min(first + self._lanes, self._paths))
            self._launch(which[rows], chance, tally, rows, 2 + first // self._lanes, watcher)
        return watcher.cause([origin.name for origin in self._lights.origins])

    # ---- private ----

    def _launch(self, which, chance, tally, rows, salt, watcher=None, steps=None):
        """Draw and follow rays; ``which``: light of each, ``rows``: their numbers. Gives the rays and what `walk` does."""
        if self._cancelled():
            raise Cancelled("cancelled")
        rays = self._lights.draw(which, chance[which], salt)
        batch = upload(mi.UInt32, rows % tally.batches)
        if watcher is not None:
            watcher.light = upload(mi.UInt32, which)
        # Numbers of the walk must not be tied to those that rays were drawn with.
        stream = launch_stream(upload(mi.UInt32, rows), salt, self._seed, WALKING)
        use, met = walk(
            self._scene, rays, tally, batch, stream, dr.opaque(mi.UInt32, self._limit),
            dr.opaque(mi.UInt32, steps or MAXIMUM_STEPS), self._sheets, watcher,
        )  # fmt: skip
        if watcher is not None:
            watcher.keep()
        if self._sheets is not None:
            dr.eval(self._sheets.flux.counts)
        return rays, use, met

    def _affordable(self, paths: int, look: int) -> int:
        """So many paths, or fewer where they are long, then a power of two. No launch is longer in a later look."""
        which, chance = _spread(self._shares, PROBE, self._seed)
        tally = make_tally(self._all_rows, len(self.objects), 1, self._flux)
        if self._sheets is not None:
            self._sheets.prepare(1, self._flux)
        *_, met = self._launch(which, chance, tally, np.arange(PROBE), 900)
        many = max(float(np.array(met, dtype=np.float64).mean()), 1.0)
        wanted = max(1 << int(np.log2(WORK / many)), FEWEST_PATHS)
        self._lanes = min(LANES, wanted)
        return min(paths, wanted * look)

    def _learn(self) -> np.ndarray:
        """Shares of the paths for each light, by what they bring; maps of suns learn too."""
        origins, flux = self._lights.origins, self._lights.flux_shares()
        brought = np.zeros(len(origins))
        plain = np.array([origin.kind != SUN for origin in origins])
        if len(origins) == 1 and plain[0]:
            return flux
        if plain.any():
            which, chance = _spread(np.where(plain, flux, 0.0), SURVEY, self._seed)
            _, use = self._survey(which, chance, 0)
            use *= chance[which]
            count, total, square = (
                np.bincount(which, weights, len(origins)) for weights in (None, use, use**2)
            )
            mean = total / np.maximum(count, 1.0)
            # Where few of its rays bring all, a light gets more of them.
            few = np.sqrt(square * count) / np.maximum(total, 1e-300)
            brought += mean * np.clip(few, 1.0, MOST_FEW)
        for place in np.flatnonzero(~plain):
            brought[place] = self._learn_sun(int(place), max((~plain).sum() / MOST_SUNS, 1.0))
        if not brought.sum() > 0.0:
            return flux
        return FLUX_SHARE * flux + (1.0 - FLUX_SHARE) * brought / brought.sum()

    def _learn_sun(self, place: int, sharing: float) -> float:
        """Teach the map of a sun; returns what its light brings. [lm]"""
        cells, uses = [], []
        for salt, size in ((0, SUN_SURVEY), (1, FINE_SURVEY)):
            wanted = int(size / sharing)
            for first in range(0, wanted, LANES):
                count = min(LANES, wanted - first)
                which = np.full(count, place)
                chance = np.full(len(self._lights.origins), 1.0)
                number = (1 + salt + first // LANES) * 64 + place
                rays, use = self._survey(which, chance, number)
                cells.append(np.array(rays.cell))
                uses.append(use)
            found = np.concatenate(uses)
            if (found > 0.0).mean() >= FEW or salt == 1:
                break
        self._lights.maps[place].learn(np.concatenate(cells), found)
        return float(found.mean())

    def _survey(self, which, chance, salt):
        tally = make_tally(self._wanted_rows, len(self.objects), 1, self._flux)
        if self._sheets is not None:
            self._sheets.prepare(1, self._flux)
        rows = np.arange(len(which))
        rays, use, _ = self._launch(which, chance, tally, rows, 1000 + salt, steps=SURVEY_STEPS)
        return rays, np.array(use, dtype=np.float64)

    def _report(self, tally, given: np.ndarray, heaviest: float) -> WitnessReport:
        def batches(sums: Sums) -> np.ndarray:
            return sums.values().reshape(-1, BATCHES).T * BATCHES

        known = len(self.objects)
        incident, absorbed = (batches(a)[:, :known] for a in (tally.incident, tally.absorbed))
        emitted = given.sum(axis=0) * BATCHES
        taken, left, cut = (batches(a)[:, 0] for a in (tally.lost, tally.left, tally.cut))
        parts = (emitted, taken, left, cut, emitted - taken - left - cut)
        amounts = [Amount(float(p.mean()), float(batch_error(p))) for p in parts]
        sheets = np.zeros((BATCHES, 0))
        if self._sheets is not None:
            sheets = batches(self._sheets.flux) / self._sheets.squares.area
        names: dict[str, float] = {}
        for origin, flux in zip(self._lights.origins, given.sum(axis=1), strict=True):
            names[origin.name] = names.get(origin.name, 0.0) + float(flux)
        return WitnessReport(
            self.objects,
            incident,
            absorbed.mean(axis=0),
            sheets,
            *amounts,
            names,
            heaviest,
            self._paths,
            int(tally.faults.counts()[0]),
        )

    def _empty(self) -> WitnessReport:
        none, nothing = np.zeros((BATCHES, len(self.objects))), Amount(0.0, 0.0)
        sheets = np.zeros((BATCHES, 0 if self._sheets is None else len(self._sheets)))
        return WitnessReport(self.objects, none, none[0], sheets, *[nothing] * 5)


class Watcher:
    """Notes by which lights and ways one row or sheet gets its light."""

    CLASSES = 2 * REFLECTED

    def __init__(self, scene, lights: int, flux: float, row: int | None, sheet: int | None):
        self._scene = scene
        self._row = dr.opaque(mi.UInt32, NOBODY if row is None else row)
        self._sheet = dr.opaque(mi.UInt32, NOBODY if sheet is None else sheet)
        self._by_light, self._by_way, self._by_bender = (
            Sums(size, flux) for size in (lights, self.CLASSES, scene.shape_count)
        )
        self.light = mi.UInt32(0)

    def see_row(self, row, amount, scatterings, trace, bender, active) -> None:
        """Note what a row receives."""
        self._note(amount, scatterings, trace, bender, active & (row == self._row))

    def see_sheet(self, sheet, amount, scatterings, trace, bender, active) -> None:
        """Note what a sheet receives."""
        self._note(amount, scatterings, trace, bender, active & (sheet == self._sheet))

    def _note(self, amount, scatterings, trace, bender, active) -> None:
        way = (trace & (BENT | MIRRORED | PASSED | CLOSE)) + dr.select(
            scatterings > 0, REFLECTED, 0
        )
        self._by_light.add(amount, self.light, active)
        self._by_way.add(amount, way, active)
        self._by_bender.add(amount, bender, active & (bender != NOBODY))

    def keep(self) -> None:
        """Finish a launch."""
        dr.eval(self._by_light.counts, self._by_way.counts, self._by_bender.counts)

    def cause(self, names: list[str]) -> Cause:
        """Tell what was found. The ways that gathering finds hardest come first, if they carry a tenth of the light."""
        lights = self._by_light.values()
        light = names[int(np.argmax(lights))]
        ways = self._by_way.values()
        total = max(ways.sum(), 1e-300)
        number = np.arange(self.CLASSES)
        shares = {bit: ways[number & bit > 0].sum() / total for bit in (BENT, MIRRORED, PASSED)}
        through = {BENT: "through", MIRRORED: "by way of", PASSED: "straight through"}
        for bit, words in through.items():
            if shares[bit] > 0.1:
                return Cause(light, f"{words} {self._bender()}")
        if ways[number & CLOSE > 0].sum() > 0.25 * total:
            return Cause(light, "that begins very near a surface")
        if ways[0] > 0.5 * total:
            return Cause(light, "that falls straight into it")
        return Cause(light, "that other surfaces reflect, perhaps from a small bright spot")

    def _bender(self) -> str:
        number = int(np.argmax(self._by_bender.values()))
        for key, part, material in self._scene.parts():
            if part.number == number:
                return f"'{self._scene.object_name(key)}' (material '{material.name}')"
        return "another body"


def _focus(corners: list[np.ndarray], margin: float) -> Focus | None:
    """Sphere around points and as far about them; None without any."""
    if not corners:
        return None
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    radius = 0.55 * float(np.linalg.norm(high - low)) + margin
    return Focus(0.5 * (low + high), max(radius, 1e-3))


def _spread(shares: np.ndarray, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Light of every path, ascending, and the expected number of paths of each light."""
    shares = shares / shares.sum()
    limits = np.cumsum(shares)
    limits[np.flatnonzero(shares)[-1] :] = 2.0
    draw = np.random.default_rng([seed, 7]).random(count)
    return (
        np.searchsorted(limits, (np.arange(count) + draw) / count, side="right"),
        np.maximum(shares * count, 1e-30),
    )
