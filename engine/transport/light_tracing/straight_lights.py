"""Light that falls straight on spots too small for samples of lumels to find: traced from the lights instead.

A lumel asks its lights at a few of its places. What a lamp close to a wall gives there, or a sun through a keyhole, lies on
so small a part of the surface that hardly any place, or none, is in it: the sum is wrong, and the error does not tell. So a
pilot traces straight light, and of every light it is known how strongly its light is bundled:

    K = A * integral of E^2 dA / (integral of E dA)^2

with the illuminance E that it gives on the surface A which is looked at. Of so many evenly spread places one lies in the
light (K = 1 for a uniform illuminance). Where K is too large for the samples that the first passes make, light that lands
within a limit of the light's centre is traced (suns: all of it), and next-event leaves it out there. The limit is so wide
that beyond it no place stands for much of the light: K tells of scatter, which is small where little is hidden, but what
no place has found is missing all the same. Rays are guided to where they land on what is looked at, by a histogram for
each light.
"""

from dataclasses import dataclass, fields, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import table_size, upload
from ..paths.sampler import random_stream, sobol_pair
from .deposits import Deposits, follow, gather_deposits, lands_beside
from .emission_rays import SUN, EmissionRays, TracedLight, find_ideal_lights, find_surfaces
from .targets import SphereTree

LANES = 1 << 19
"""Paths per launch."""

PILOT = (1 << 17, 1 << 20, 1 << 19)
"""Paths of the rounds of the pilot: few where all light is seen to be spread out, or many that look for small openings."""

PILOT_SEED = 0x6D2F
"""Of these paths; the same scene always gives the same choice."""

FOUND = 200.0
"""Places in the light of the first passes from which on their scatter is believed."""

EASED = 4.0
"""How many times less bundled light is beyond the limit than it may be. [-]"""

HIDDEN = 3e-3
"""Largest share of a light's flux that one place of the first passes may stand for beyond the limit. [-]"""

LARGEST_SURFACE = 0.05
"""Radius of a luminous surface, relative to the scene's, from which on its light is not bundled anywhere. [-]"""

LEAST_SHARE = 1e-3
"""Share of a light's landed flux below which what surfaces that are not matt get of it does not matter. [-]"""

KNOWN = 64
"""Places where a light landed in the first round from which on that tells what there is of it, up to a factor `UNSURE`."""

UNSURE = 10.0
"""By how much the first round may find light less bundled than it is. [-]"""

SHORTER, SHORTEST = 4, 1 << 8
"""By how much later rounds are shorter if only light matters that is known from the first one, and if none does: they are
made for their kernels alone, so that an edit does not have to."""

MOST_LIGHTS = 64
"""Most lights that are traced; of more, those with the least bundled flux are left to next-event."""

MOST_CANDIDATES = 128
"""Most lights that the later rounds of the pilot look at, as every one has a histogram: those with the most bundled flux,
then those whose light has not been seen to land."""

GRID = 256
"""Cells along both sides of a light's histogram."""

EVEN = 0.25
"""Share of a light's rays that is not guided, so that nothing is forgotten. [-]"""

NEIGHBOURS = 0.1
"""Share of a cell that each of its neighbours in the histogram gets too. [-]"""

RARE = 1.0
"""Density, relative to even rays, below which it is asked whether a ray that landed slipped through a crack: it counts for
many. [-]"""

SALT = 0x2B9D
"""Sets these paths apart from others of the same seed."""


@dataclass(frozen=True)
class _Landed:
    """Straight light that landed on what is looked at.

    Parameters
    ----------
    light : (m,) int    Place among the lights, ascending.
    flux : (m,) array    Share of the estimate, by how often it is looked at. [lx]
    lux : (m,) array    Illuminance there by this light. [lx]
    distance : (m,) array    From the light's centre. [m]
    cell : (m,) int    Of the light's histogram.
    is_matt : (m,) bool
    """

    light: np.ndarray
    flux: np.ndarray
    lux: np.ndarray
    distance: np.ndarray
    cell: np.ndarray
    is_matt: np.ndarray

    def of(self, lights: list[int], kept=True) -> "_Landed":
        """Light of some lights alone, which are numbered anew. ``lights``: ascending; ``kept``: what of it."""
        own = np.isin(self.light, lights) & kept
        few = {each.name: getattr(self, each.name)[own] for each in fields(self)}
        return _Landed(**few | {"light": np.searchsorted(lights, few["light"])})


class StraightLights:
    """Lights of a scene whose straight light is too bundled for next-event.

    Parameters
    ----------
    scene : CompiledScene    Its next-event leaves out what is traced here, until `close`.
    sampler : WavelengthSampler or None    None in photometric variants.
    cells : CellSet or another that knows the sides of deposits
    sides : (n,) array    Sides of cells that a job looks at.
    samples : float    Places at which the first passes ask for light.
    looks : (2 c,) array    How often each side is looked at, over its area and of sum 1 over all. [m-2]
    leaves_out : bool    Whether next-event leaves out what is traced; it is only looked for otherwise.
    unmattering : float
        Mean square of the illuminance over the square of its mean, the latter by all straight light, that lights may have
        together which need not be looked for. [-]

    Attributes
    ----------
    is_needed : bool    Whether anything is traced.
    seen : float    Illuminance by all these lights of what is looked at, in the mean of the looks. [lx]
    reason : str    Why, for people.
    """

    def __init__(
        self,
        scene,
        sampler,
        cells,
        sides: np.ndarray,
        samples: float,
        looks,
        leaves_out=False,
        unmattering=0.0,
    ):
        self._scene, self._sampler, self._cells = scene, sampler, cells
        self._seen = np.zeros(2 * max(cells.count, 1), dtype=bool)
        self._seen[sides] = True
        # Flux counts by how often it is looked at, as if all were an area of 1. What is not matt has no sides.
        self._looks, self.seen = looks, 0.0
        self._unmattering = unmattering
        self._typical = float((looks**2 * np.repeat(cells.area, 2))[sides].sum())
        self._limits: dict[int, float] = {}
        self.reason = ""
        self.lights: tuple[TracedLight, ...] = find_candidates(scene)
        if self.lights and len(sides) and self._typical > 0.0:
            self._learn(samples / FOUND)
        self.is_needed = bool(self._limits)
        if self.is_needed and leaves_out:
            self._leave_out()

    def close(self) -> None:
        """Let next-event see these lights everywhere again."""
        self._scene.near = None
        if self.is_needed and self._scene.surroundings is not None:
            self._scene.surroundings.leave_out(())

    def trace(self, count: int, seed: int, index: int = 0) -> list[Deposits]:
        """Trace ``count`` paths; fluxes of deposits are ``count`` times their share of the estimate. [lm]"""
        made = []
        for first in range(0, count, LANES):
            width = min(LANES, count - first)
            made.append(self._launch(width, (seed + SALT) & 0xFFFFFFFF, index + first, True)[0])
        return made

    def find_places(self, count: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where what is traced lands on what is looked at.

        Returns
        -------
        light (m,) int, position (m, 3) [m], weight (m,)
            Place among ``lights``, in the scene's frame; and flux times illuminance, as spots count for scatter: the sum is
            the mean square of the illuminance, by the looks. [lx2]
        """
        made, told = self._launch(count, (seed + SALT) & 0xFFFFFFFF, 0, True)
        side, passing = self._cells.sides_of(made)
        seen = (passing > 0.0) & self._seen[side]
        lux = told[:, 2].astype(np.float64) * made.flux * made.cosine
        flux = made.flux / count * self._looks[side]
        found = told[:, 0].astype(np.int64), told[:, 4:7].astype(np.float64), flux * lux
        return tuple(each[seen] for each in found)

    # ---- private ----

    def _learn(self, most: float) -> None:
        """Choose lights and their limits. ``most``: largest K that the first passes cope with."""
        self._start(self.lights, None)
        landed, shorter = None, 1
        rounds = list(PILOT)
        if self._unmattering:
            # So many that most lights are known by them.
            rounds[0] = int(np.clip(4 * KNOWN * len(self.lights), PILOT[0], max(PILOT)))
        for number, count in enumerate(rounds):
            landed = self._look(number, count // (shorter if number else 1))
            chosen = [self._limit_of(landed, n, most) for n in range(len(self.lights))]
            if number == 0:
                whole = landed.flux.sum()
                if self._unmattering:
                    chosen, shorter = self._choose_mattering(landed, chosen)
                landed, chosen = self._choose_candidates(landed, chosen)
                left = whole - landed.flux.sum()
                if not self.lights:
                    return
            self._start(self.lights, self._histograms(landed))
        # What is bundled is known by the last round alone.
        self.seen = float(left + landed.flux.sum())
        limits, worth = {}, {}
        for number, limit in enumerate(chosen):
            if not limit:
                continue
            own = landed.light == number
            flux = landed.flux[own].sum()
            for reach in (_widen_limit(landed, own, limit, most), limit):
                inside = own & (landed.distance < reach)
                spilled = landed.flux[inside & ~landed.is_matt].sum()
                kept = landed.flux[inside & landed.is_matt].sum()
                # What a surface that is not matt makes of traced light, nothing would find.
                if spilled <= LEAST_SHARE * flux and kept > 0.0:
                    limits[number] = reach
                    worth[number] = float(landed.flux[inside] @ landed.lux[inside])
                    break
        chosen = sorted(sorted(limits, key=lambda n: -worth[n])[:MOST_LIGHTS])
        if not chosen:
            return
        reach = np.array([limits.get(n, 0.0) for n in range(len(self.lights))])
        kept = landed.is_matt & (landed.distance < reach[landed.light])
        few = landed.of(chosen, kept)
        share = few.flux.sum() / max(landed.flux.sum(), 1e-300)
        self.lights = tuple(self.lights[n] for n in chosen)
        self._limits = {place: limits[n] for place, n in enumerate(chosen)}
        self._start(self.lights, self._histograms(few))
        # The best choice follows the root of the mean square of what one light alone gives.
        squares = np.bincount(few.light, few.flux**2, len(chosen))
        self._rays.set_shares(np.maximum(np.sqrt(squares), 1e-3 * np.sqrt(squares.max())))
        kinds = ", ".join(sorted({light.kind for light in self.lights}))
        self.reason = (
            f"{100.0 * share:.2g} % of the straight light ({len(chosen)} x {kinds}) falls on spots too small for samples of "
            "lumels to find, and is traced from the lights"
        )

    def _choose_mattering(self, landed: _Landed, chosen: list) -> tuple[list, int]:
        """Leave out lights that have too little mean square of the illuminance together to matter, as the first round tells.

        Returns
        -------
        (list, int)    Limits, 0 of what is left out, and by how much later rounds may be shorter.
        """
        squares = np.bincount(landed.light, landed.flux * landed.lux, len(self.lights))
        is_known = np.bincount(landed.light, minlength=len(self.lights)) >= KNOWN
        # Of others a single ray may stand for much light by chance.
        whole = landed.flux[is_known[landed.light]].sum()
        order = np.argsort(squares, kind="stable")
        together = np.cumsum(squares[order]) * UNSURE
        is_idle = np.zeros(len(squares), dtype=bool)
        is_idle[order] = together <= self._unmattering * whole**2
        is_bundled = np.array([limit != 0.0 for limit in chosen])
        is_left = is_bundled & ~(is_idle & is_known)
        shorter = SHORTER if is_known[is_left].all() else 1
        if is_bundled.any() and not is_left.any():
            is_left[np.argmax(np.where(is_bundled, squares, -1.0))] = True
            shorter = SHORTEST
        return [limit if is_left[n] else 0.0 for n, limit in enumerate(chosen)], shorter

    def _choose_candidates(self, landed: _Landed, chosen: list):
        """Leave out lights that are not bundled; returns what the others gave, and their limits."""
        worth = np.bincount(landed.light, landed.flux * landed.lux, len(self.lights))
        # Nothing is known of those that were not seen to land but what they send.
        sent = [0.0 if light.source is None else light.source.flux for light in self.lights]
        left = [n for n, limit in enumerate(chosen) if limit != 0.0]
        left.sort(key=lambda n: (chosen[n] is None, -worth[n], -sent[n]))
        left = sorted(left[:MOST_CANDIDATES])
        self.lights = tuple(self.lights[n] for n in left)
        return landed.of(left), [chosen[n] for n in left]

    def _start(self, lights, histograms: np.ndarray | None) -> None:
        """Begin to send rays of some lights, guided by histograms (n, GRID^2), None: evenly."""
        radius = float(self._scene.radius)
        everything = SphereTree(
            np.array([[0.0, 0.0, 0.0, radius]]), np.array([[-1, -1]]), np.array([radius**2])
        )
        self._rays = EmissionRays(self._scene, lights, everything)
        self._ends = self._densities = None
        if histograms is not None:
            share = histograms / histograms.sum(axis=1, keepdims=True)
            # To the digits of the random numbers, so that densities are those of what is drawn.
            ends = np.round(np.cumsum(share, axis=1) * 2.0**24) / 2.0**24
            ends[:, -1] = 1.0
            self._ends = upload(mi.Float, ends)
            self._densities = upload(mi.Float, np.diff(ends, prepend=0.0, axis=1) * GRID * GRID)
            dr.eval(self._ends, self._densities)
        limits = np.zeros(table_size(len(lights)))
        limits[: len(lights)] = [self._limits.get(n, np.inf) for n in range(len(lights))]
        centres, extents = np.zeros((len(limits), 3)), np.zeros(len(limits))
        for number, light in enumerate(lights):
            if light.source is not None:
                centres[number], extents[number] = light.source.centre, light.source.radius
        self._limit_table, self._centres = upload(mi.Float, limits), upload(mi.Float, centres)
        self._extents = upload(mi.Float, extents)
        dr.eval(self._limit_table, self._centres, self._extents)

    def _histograms(self, landed: _Landed) -> np.ndarray:
        """Densities by cell, up to a factor, by what landed. (n, GRID^2)"""
        count = len(self.lights)
        made = np.bincount(
            landed.light * GRID * GRID + landed.cell, landed.flux**2, count * GRID * GRID
        )
        made = np.sqrt(made).reshape(count, GRID, GRID)
        around = sum(np.roll(made, step, axis=axis) for step in (-1, 1) for axis in (1, 2))
        made = (made + NEIGHBOURS * around).reshape(count, -1)
        total = made.sum(axis=1, keepdims=True)
        guided = np.divide(made, total, out=np.full_like(made, 1.0 / GRID**2), where=total > 0.0)
        return EVEN / GRID**2 + (1.0 - EVEN) * guided

    def _limit_of(self, landed: _Landed, number: int, most: float) -> float | None:
        """Distance from a light below which its light is traced, 0 for none of it; None: none was seen to land. [m]"""
        own = slice(*np.searchsorted(landed.light, [number, number + 1]))
        if landed.flux[own].sum() <= 0.0:
            return None
        return _choose_limit(landed, own, self.lights[number].start == SUN, most)

    def _look(self, number: int, count: int) -> _Landed:
        """One round of the pilot."""
        made, told = self._launch(count, PILOT_SEED + number, 0, False)
        light, cell = told[:, 0].astype(np.int64), told[:, 3].astype(np.int64)
        side, passing = self._cells.sides_of(made)
        is_matt = passing > 0.0
        # Of what has no cells, all may be looked at.
        seen = ~is_matt | self._seen[side]
        lux = told[:, 2].astype(np.float64) * made.flux * made.cosine
        flux = made.flux / count * np.where(is_matt, self._looks[side], self._typical)
        values = (light, flux, lux, told[:, 1].astype(np.float64))
        order = np.flatnonzero(seen)
        order = order[np.argsort(light[order], kind="stable")]
        return _Landed(*(each[order] for each in (*values, cell, is_matt)))

    def _launch(self, width, seed, index, is_limited: bool) -> tuple[Deposits, np.ndarray]:
        """Run one kernel; fluxes are those of single paths.

        Returns
        -------
        (Deposits, (m, 7) array)    Of each also its light, its distance from the light's centre [m], the factor from its
            flux to the illuminance of a plane that faces it [m-2], its cell of the histogram, and where it landed, in the
            scene's frame [m].
        """
        lane = dr.arange(mi.UInt32, width) + dr.opaque(mi.UInt32, int(index) & 0xFFFFFFFF)
        seed = dr.opaque(mi.UInt32, int(seed) & 0xFFFFFFFF)
        stream = random_stream(lane, seed)
        first = sobol_pair(lane, seed, 0)
        wavelengths = None if self._sampler is None else self._sampler.sample(first.x)
        light = self._rays.pair(first.y)
        place, cell, density = self._guide(light, sobol_pair(lane, seed, 1), stream)
        ray, flux, light, own = self._rays.draw(
            first.y, place, sobol_pair(lane, seed, 2), wavelengths
        )
        flux = flux / density
        centre = mi.Point3f(*(dr.gather(mi.Float, self._centres, light * 3 + k) for k in range(3)))
        limit = dr.gather(mi.Float, self._limit_table, light)
        is_sun = self._rays.starts(light, SUN)
        away, towards = ray.o - centre, mi.Vector3f(ray.d)

        def distance(length):
            return dr.select(is_sun, 0.0, dr.norm(away + towards * length))

        def counts_straight(length):
            return distance(length) < limit if is_limited else mi.Bool(True)

        end = follow(self._scene, ray, stream, dr.any(flux > 0.0), counts_straight)
        # Light over bends is left to others.
        end["landed"] &= end["bends"] == 0
        way = distance(end["length"])
        # By which the flux of a path becomes the illuminance of a plane that faces it.
        extent = dr.gather(mi.Float, self._extents, light)
        # Close to a luminous surface it fills half the sky, and its light is bundled no more.
        square = dr.square(end["length"]) + dr.square(extent)
        bundling = own * density / dr.select(is_sun, 1.0, dr.maximum(square, 1e-20))
        # Not by the way, which mirrors may have turned.
        at = self._scene.interaction_at(end["shape"], end["prim"], end["uv"], end["landed"]).p
        told = [mi.Float(light), way, bundling, mi.Float(cell), at.x, at.y, at.z]
        if self._ends is not None:
            told += [density, end["length"], *ray.o, *ray.d]
        made, told = gather_deposits(
            end, self._sampler, end["throughput"] * flux, wavelengths, told
        )
        told, ways = told[:, :7], told[:, 7:]
        if self._ends is not None:
            held = np.ones(len(ways), dtype=bool)
            # Of lamps, which stand nearer by, no single ray counts for so much.
            suns = np.array([light.start == SUN for light in self.lights])
            rare = np.flatnonzero((ways[:, 0] < RARE) & suns[told[:, 0].astype(np.int64)])
            held[rare] = lands_beside(self._scene, ways[rare, 1:], made.only(rare))
            made, told = made.only(held), told[held]
        return replace(made, light=told[:, 0].astype(np.uint32)), told

    def _guide(self, light, sample, stream):
        """Place in the unit square by a light's histogram, its cell, and the density."""
        if self._ends is None:
            below = GRID - 1
            cell = dr.minimum(mi.UInt32(sample.x * GRID), below)
            cell += dr.minimum(mi.UInt32(sample.y * GRID), below) * GRID
            return sample, cell, mi.Float(1.0)
        base = light * (GRID * GRID)
        u = sample.x
        cell = dr.binary_search(
            0, GRID * GRID - 1, lambda i: dr.gather(mi.Float, self._ends, base + i) <= u
        )
        low = dr.select(cell > 0, dr.gather(mi.Float, self._ends, base + cell - 1, cell > 0), 0.0)
        high = dr.gather(mi.Float, self._ends, base + cell)
        # In wide cells the rest of the number places the ray evenly; in narrow ones it has no digits left.
        rest = (u - low) / dr.maximum(high - low, 1e-12)
        rest = dr.select(high - low > 1e-3, rest, stream.next_float32())
        x = (mi.Float(cell % GRID) + dr.clip(rest, 0.0, 0.9999999)) / GRID
        y = (mi.Float(cell // GRID) + sample.y) / GRID
        density = dr.gather(mi.Float, self._densities, base + cell)
        return mi.Point2f(x, y), cell, dr.maximum(density, 1e-12)

    def _leave_out(self) -> None:
        """Have next-event leave out what is traced."""
        finite = {
            light.number: (light.source, self._limits[place])
            for place, light in enumerate(self.lights)
            if light.start != SUN
        }
        self._scene.near = NearLimits(self._scene.lights, finite) if finite else None
        suns = [light.number for light in self.lights if light.start == SUN]
        if suns:
            self._scene.surroundings.leave_out(suns)


class NearLimits:
    """Distances from lights within which next-event and rays that meet them leave out their straight light.

    Parameters
    ----------
    lights : LightTable
    limits : dict of int to (Source, float)    By place among the table's sources: the light and its limit. [m]
    """

    def __init__(self, lights, limits):
        self._lights = lights
        rows = np.zeros((table_size(lights.count), 4))
        for number, (source, limit) in limits.items():
            rows[number] = (*source.centre, limit**2)
        self._rows = upload(mi.Float, rows)
        dr.eval(self._rows)

    def has(self, index, point, active):
        """Whether a light's straight light at a place is left out. ``index``: as `LightTable.sample` gives it."""
        x, y, z, square = (dr.gather(mi.Float, self._rows, index * 4 + k, active) for k in range(4))
        return active & (dr.squared_norm(point - mi.Point3f(x, y, z)) < square)

    def has_emitter(self, emitter, row, point, active):
        """As `has`, for a luminous surface that a ray has met. ``row``: as of `LightTable.index`."""
        return self.has(self._lights.index(emitter, active, row), point, active)


def find_candidates(scene) -> tuple[TracedLight, ...]:
    """Lights whose straight light may be bundled: ideal ones, and luminous surfaces that are small in their scene."""
    small = (
        light
        for light in find_surfaces(scene)
        if light.source.radius < LARGEST_SURFACE * scene.radius
    )
    return (*find_ideal_lights(scene), *small)


def _choose_limit(landed: _Landed, own: np.ndarray, is_sun: bool, most: float) -> float:
    """Distance from a light below which its light is traced, 0 for none of it. [m]"""
    flux, lux, distance = landed.flux[own], landed.lux[own], landed.distance[own]
    whole = max(flux.sum(), 1e-300)
    bundled = flux * lux / whole**2
    if bundled.sum() <= most:
        return 0.0
    if is_sun:
        return np.inf
    order = np.argsort(-distance, kind="stable")
    beyond = np.cumsum(bundled[order])
    spared = int(np.searchsorted(beyond, most / EASED, side="right"))
    return float(distance[order][min(spared, len(order) - 1)] * (1.0 + 1e-6))


def _widen_limit(landed: _Landed, own: np.ndarray, limit: float, most: float) -> float:
    """Distance beyond which no place of the first passes stands for more than `HIDDEN` of a light's flux. [m]"""
    brightest = HIDDEN * landed.flux[own].sum() * most * FOUND
    bright = own & (landed.lux > brightest)
    return max(limit, float(landed.distance[bright].max(initial=0.0) * (1.0 + 1e-6)))
