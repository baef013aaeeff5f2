"""Light over glass and curved mirrors to points of the scene: next-event where a straight line does not lead.

Sensors and pictures look for light from where it arrives. A lamp in a glass bulb, a point behind a lens or a sun in a mirror
ball are met by so few scattered rays, or by none, that not even the error tells what is missing. So a pilot traces such
lights forwards and notes by which lines they arrive. From elsewhere each seems to come from about one place (a lamp
in a bulb, through a slab) or direction (the sun in a window): rays are aimed there, some of them at all that bends its
light, and followed over glass and mirrors until they meet the chosen light or do not. What scattered rays meet of these
lights over bends is left out, so that every way counts once.

Ideal points have no size that a ray could meet. They are taken for spheres, and suns for disks as the true one, as far as
their light is bent; the notes say so. Where bends spread light evenly the error is of second order in that size, and edges
of caustics are as much less sharp.
"""

from contextlib import contextmanager
from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import table_size, upload
from ...materials.plugins import DISPERSED_COMPONENT
from ..compiled.polarisation import polarise
from ..compiled.textures import is_spectral
from ..paths import path_loop as paths
from ..paths.cached_gather import LeftOut
from ..paths.wavelengths import WavelengthSampler
from ..rays import spawn_ray
from .deposits import ROULETTE_START, SURVIVAL
from .emission_rays import IDEAL, SUN, SURFACE, EmissionRays, TracedLight, in_cap, solid_cap
from .light_paths import find_bent_lights, left_out_of, send_pilot
from .targets import find_targets

PILOT = 1 << 17
"""Paths that tell by which lines light arrives."""

MOST_AIMS = 512
"""Most aims of all lights together; of more, lights that give the least are missing, and a note says so."""

MOST_PARTS, ALL_PARTS, FEWEST_PARTS = 32, 64, 4
"""Most parts of one light's lines with an aim each; of all lights' together, about; and of one light in any case."""

LEAST_SHARE = 1e-4
"""Share of all bent light below which a light's is left out of account. [-]"""

LEAST_PART = 3e-3
"""Share of a light's below which a part of its lines is not parted again. [-]"""

NARROW = 0.03
"""Angle within which a light seems to be in one place for all that are lit, so that it needs but one aim. [rad]"""

FEWEST_LINES, MOST_LINES = 32, 1 << 14
"""Lines that an aim is made of, at least, and those of a light that are looked at."""

POINT_SIZE = 0.01
"""Radius for which an ideal point is taken, relative to its distance from what bends its light. [-]"""

SUN_RADIUS = 0.00465
"""Angular radius for which suns that have less are taken: that of the true one. [rad]"""

QUANTILES = (0.5, 0.99)
"""Shares of the light within the inner and the outer cone of an aim. [-]"""

SHARES = (0.45, 0.4, 0.15)
"""Of an aim's rays to these cones, and to all that bends the light. [-]"""

ASKED, FEWEST_ASKED = 8.0, 1.0 / 16.0
"""Vertices of a path that ask for bent light, relative to its share of all light, and the fewest of them. [-]"""

SPARE = 1.1
"""By which aims are larger than what the pilot saw. [-]"""

PLACE, DIRECTION = 0, 1
"""What an aim is: a place where light seems to come from, or a direction."""

COLUMNS = 19
"""Of the table of aims; see `BentLights._upload`."""

MAXIMUM_STEPS = 256
"""Stops a ray between surfaces of which numerical trouble would let none end it."""


@dataclass(frozen=True)
class _Aim:
    """Where light of one source that comes from a part of what bends it seems to come from.

    Parameters
    ----------
    flux : float    That the pilot saw land. [lm]
    kind : int    `PLACE` or `DIRECTION`.
    centre : (3,) array    Place in the scene's frame [m], or unit vector towards the light.
    sizes : (2,) array    Radii about the place [m], or 1 - cos of angles about the direction, by `QUANTILES`.
    sphere : (4,) array    Holds all places where this light leaves for where it lands; in the end those of all of a light's
        aims. [m]
    spread : float    Angle within which it seems to come from there. [rad]
    """

    flux: float
    kind: int
    centre: np.ndarray
    sizes: np.ndarray
    sphere: np.ndarray
    spread: float


@dataclass(frozen=True)
class _BentLight:
    """A light and its aims. ``size``: radius of an ideal point [m], or 1 - cos of the angular radius of a sun."""

    light: TracedLight
    name: str
    flux: float
    size: float
    aims: tuple[_Aim, ...]


@contextmanager
def bent_lights(scene):
    """Let the paths of a `CompiledScene` find its lights over bends; gives the notes on it."""
    made = BentLights(scene)
    scene.bent = made if made.is_needed else None
    try:
        yield made.notes
    finally:
        scene.bent = None


class BentLights:
    """Lights of a scene over what bends their light.

    Parameters
    ----------
    scene : CompiledScene    Must stay as it is while this object is used.

    Attributes
    ----------
    is_needed : bool    Whether there are any that scattered rays would not find.
    left_out : LeftOut    What scattered rays must not count after a bend.
    notes : tuple of str    What is approximated, for people.
    """

    def __init__(self, scene):
        self.scene = scene
        self.left_out = LeftOut(False)
        self.notes: tuple[str, ...] = ()
        targets = find_targets(scene)
        found: list[_BentLight] = []
        if targets.tree is not None:
            sampler = WavelengthSampler(scene.mean_light, "luminance") if is_spectral() else None
            lights = find_bent_lights(scene, targets.tree, sampler)
            if lights:
                found = self._find(EmissionRays(scene, lights, targets.tree), sampler)
        ends = np.cumsum([len(each.aims) for each in found])
        kept = found[: int(np.searchsorted(ends, MOST_AIMS, side="right"))]
        self.is_needed = bool(kept)
        if not kept:
            return
        self.left_out = left_out_of([each.light for each in kept]) or self.left_out
        self.notes = tuple(_notes(kept, found[len(kept) :], targets.names))
        self._upload(kept)
        bent = sum(each.flux for each in kept)
        every = sum(source.flux for source in scene.lights.sources)
        chance = np.clip(ASKED * bent / max(every, 1e-300), FEWEST_ASKED, 1.0)
        # What a sun gives far outside tells nothing of its share in a room behind glass.
        self._asks = dr.opaque(mi.Float, 1.0 if self._suns else float(chance))

    def _find(self, rays: EmissionRays, sampler) -> list[_BentLight]:
        """Trace all lights and see where they seem to be; those that give most first."""
        landed = send_pilot(self.scene, rays, sampler, PILOT)
        names = {id(source): name for name, source in self.scene.named_sources()}
        total, made = max(float(landed["flux"].sum()), 1e-300), []
        parts = int(np.clip(ALL_PARTS // len(rays.lights), FEWEST_PARTS, MOST_PARTS))
        for number, light in enumerate(rays.lights):
            own = landed["light"] == number
            lines = {name: values[own] for name, values in landed.items()}
            flux = float(lines["flux"].sum())
            if flux <= LEAST_SHARE * total:
                continue
            name = "sun" if light.source is None else names.get(id(light.source), "light")
            size = _size_of(light, lines, self.scene)
            few = {key: values[:MOST_LINES] for key, values in lines.items()}
            few["flux"] = few["flux"] * (flux / few["flux"].sum())
            aims = tuple(_find_aims(light, few, size, self.scene.radius, parts))
            made.append(_BentLight(light, name, flux, size, aims))
        return sorted(made, key=lambda each: -each.flux)

    def _upload(self, lights: list[_BentLight]) -> None:
        pairs = [(i, each, aim) for i, each in enumerate(lights) for aim in each.aims]
        rows = np.zeros((table_size(len(pairs)), COLUMNS))
        for row, (number, each, aim) in zip(rows, pairs, strict=False):
            light = each.light
            row[:3], row[3] = aim.centre, aim.kind
            row[4:6] = aim.sizes
            row[6:10] = aim.sphere
            row[10], row[11] = aim.flux, each.size
            row[12:14] = light.start, light.number
            if light.source is not None:
                row[14] = light.source.number
                row[15:18] = light.source.centre
            row[18] = number
        self._rows = upload(mi.Float, rows)
        self._count = dr.opaque(mi.UInt32, len(pairs))
        self._suns = any(each.light.start == SUN for each in lights)
        self._points = any(each.light.start == IDEAL for each in lights)
        self._surfaces = any(each.light.start == SURFACE for each in lights)
        dr.eval(self._rows)

    # ---- inside kernels ----

    def light(self, si, stream, respond, active, dispersed=False, limit=None, is_first=None):
        """One-sample estimate of what lights send to a place over bends.

        Parameters
        ----------
        si : SurfaceInteraction3f    The place.
        stream : PCG32
        respond : callable    Given a direction and which lanes ask: how much radiance from there counts, cosine included.
        dispersed : Bool    Whether the path has one wavelength left.
        limit : UInt32 or None    Most bends and reflections on the way.
        is_first : Bool or None    Whether the place is the first of a path that spreads light; None: all are.

        Returns
        -------
        Spectrum    Response times radiance.
        """
        lit = mi.Bool(active)
        chance = mi.Float(1.0)
        if is_first is not None:
            # Where little of the light is bent, few vertices of a path ask for it.
            chance = dr.select(is_first, 1.0, self._asks)
            lit &= stream.next_float32() < chance
        index, total = self._choose(si.p, stream.next_float32(), lit)
        direction = self._direct(index, si.p, stream)
        density = self._density(index, total, si.p, direction, lit)
        response = respond(direction, lit)
        amount = mi.Spectrum(response / dr.maximum(chance * density, 1e-30))
        lit &= (density > 0.0) & dr.any(amount != 0.0)
        ray = spawn_ray(self.scene, si, direction)
        value = self._follow(index, ray, stream, lit, dispersed, limit)
        return dr.select(lit, amount * value, 0.0)

    def _number(self, index, column: int):
        return dr.gather(mi.Float, self._rows, index * COLUMNS + column)

    def _vector(self, index, column: int):
        return mi.Vector3f(*(self._number(index, column + k) for k in range(3)))

    def _weigh(self, index, point):
        """How much the light of an aim may give at a point, up to a factor."""
        is_place = self._number(index, 3) == PLACE
        sphere, radius = self._vector(index, 6), self._number(index, 9)
        centre = dr.select(is_place, self._vector(index, 0), sphere)
        extent = dr.select(is_place, self._number(index, 5), radius)
        away = dr.squared_norm(point - centre)
        return self._number(index, 10) / dr.maximum(away + dr.square(extent), 1e-12)

    def _choose(self, point, u, active):
        """An aim, and the sum of all weights."""

        def add(total, index, u, i):
            weight = self._weigh(i, point)
            total = total + weight
            # In one walk: every aim takes the place of those before with its share of the sum so far.
            share = weight / dr.maximum(total, 1e-30)
            is_taken = u < share
            u = dr.select(is_taken, u / dr.maximum(share, 1e-30), (u - share) / (1.0 - share))
            return total, dr.select(is_taken, i, index), dr.clip(u, 0.0, 0.9999999), i + 1

        total, index, _, _ = dr.while_loop(
            state=(mi.Float(0.0), mi.UInt32(0), mi.Float(u), mi.UInt32(0)),
            cond=lambda total, index, u, i: active & (i < self._count),
            body=add,
            labels=("total", "index", "u", "i"),
        )
        return index, total

    def _direct(self, index, point, stream):
        """A direction within an aim."""
        cones = self._cones(index, point)
        u = stream.next_float32()
        sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        axis, cap = cones[-1]
        start = 0.0
        for share, (own_axis, own_cap) in zip(SHARES[:-1], cones[:-1], strict=True):
            is_own = (u >= start) & (u < start + share)
            axis, cap = dr.select(is_own, own_axis, axis), dr.select(is_own, own_cap, cap)
            start += share
        return mi.Frame3f(axis).to_world(in_cap(cap, sample))

    def _density(self, index, total, point, direction, active):
        """Density with which all aims of a light together give a direction. [sr-1]"""
        light = self._number(index, 18)

        def add(density, i):
            pdf = mi.Float(0.0)
            for share, (axis, cap) in zip(SHARES, self._cones(i, point), strict=True):
                # By the chord, since cosines of narrow cones have no digits left.
                inside = 0.5 * dr.squared_norm(direction - axis) <= cap * (1.0 + 1e-4) + 1e-13
                pdf += dr.select(inside, share * dr.inv_two_pi / cap, 0.0)
            is_own = self._number(i, 18) == light
            return dr.select(is_own, density + self._weigh(i, point) * pdf, density), i + 1

        density, _ = dr.while_loop(
            state=(mi.Float(0.0), mi.UInt32(0)),
            cond=lambda density, i: active & (i < self._count),
            body=add,
            labels=("density", "i"),
        )
        return density / dr.maximum(total, 1e-30)

    def _cones(self, index, point) -> list:
        """Axes of an aim's cones and 1 - cos of their half angles, by `SHARES`."""
        is_far, centre = self._number(index, 3) == DIRECTION, self._vector(index, 0)
        made = []
        for column in (4, 5):
            size = self._number(index, column)
            axis, cap = _cone(centre - point, size)
            made.append((dr.select(is_far, centre, axis), dr.select(is_far, size, cap)))
        made.append(_cone(self._vector(index, 6) - point, self._number(index, 9)))
        return made

    def _follow(self, index, ray, stream, active, dispersed, limit):
        """Radiance of a light along a ray over bends; what it gives straight does not count."""
        scene, spectral = self.scene, is_spectral()
        start = self._number(index, 12)
        emitter_number = mi.UInt32(self._number(index, 14))
        most = mi.UInt32(MAXIMUM_STEPS) if limit is None else mi.UInt32(limit)
        state = {
            "ray": mi.Ray3f(ray),
            "stream": mi.PCG32(stream),
            "throughput": mi.Spectrum(1.0),
            "value": mi.Spectrum(0.0),
            "bends": mi.UInt32(0),
            "turns": mi.UInt32(0),
            "steps": mi.UInt32(0),
            "polar": mi.Vector3f(0.0),
            "dispersed": mi.Bool(dispersed),
            "active": mi.Bool(active),
        }

        def body(ray, stream, throughput, value, bends, turns, steps, polar, dispersed, active):
            si = paths.closest_hit(scene, ray, active)
            if spectral:
                si.wavelengths = ray.wavelengths
            counts = active & (bends > 0)
            valid = active & si.is_valid()
            if self._surfaces:
                emitter = scene.emitter(si, valid)
                number = dr.reinterpret_array(mi.UInt32, emitter)
                met = counts & valid & (start == SURFACE) & (number == emitter_number)
                value = value + dr.select(met, throughput * emitter.eval(si, met), 0.0)
            if self._points:
                is_point = counts & (start == IDEAL)
                way = dr.select(si.is_valid(), si.t, dr.inf)
                value = value + throughput * self._point_radiance(index, ray, way, is_point)
            if self._suns:
                leaves = counts & ~si.is_valid() & (start == SUN)
                value = value + throughput * self._sun_radiance(index, ray, leaves)

            bsdf = scene.bsdf(si, valid)
            active = valid & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Delta)
            choice = stream.next_float32()
            sample = mi.Point2f(stream.next_float32(), stream.next_float32())
            bs, weight = bsdf.sample(mi.BSDFContext(), si, choice, sample, active)
            active &= mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
            straight = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
            throughput = dr.select(active, throughput * weight, throughput)
            turned = active & ~straight
            if scene.requirements.dispersive:
                splits = turned & (bs.sampled_component == DISPERSED_COMPONENT) & ~dispersed
                hero = mi.Spectrum(0.0)
                hero[0] = 4.0 * throughput[0]
                throughput = dr.select(splits, hero, throughput)
                dispersed = dispersed | splits
            is_bend = mi.Bool(turned)
            if scene.mirrors is not None:
                is_bend &= scene.mirror_at(si, turned) == 0
            bends = dr.select(is_bend, bends + 1, bends)
            turns = dr.select(turned, turns + 1, turns)
            direction = dr.select(straight, ray.d, si.to_world(bs.wo))
            factor, polar = polarise(scene, si, ray.d, direction, polar, turned, active)
            throughput = throughput * factor
            onwards = spawn_ray(scene, si, direction)
            onwards.wavelengths = ray.wavelengths
            ray = dr.select(active, onwards, ray)
            steps = steps + 1

            tried = turned & (bends >= ROULETTE_START)
            # Radiance is larger in a dense body and smaller again outside.
            survival = dr.minimum(dr.max(throughput), SURVIVAL)
            active &= ~tried | (stream.next_float32() < survival)
            throughput = dr.select(
                tried & active, throughput / dr.maximum(survival, 1e-20), throughput
            )
            active &= dr.any(throughput != 0.0) & (steps < MAXIMUM_STEPS) & (turns <= most)
            return ray, stream, throughput, value, bends, turns, steps, polar, dispersed, active

        result = dr.while_loop(
            state=tuple(state.values()),
            cond=lambda *values: values[-1],
            body=body,
            labels=tuple(state),
        )
        stream.state = result[1].state
        return result[3]

    def _point_radiance(self, index, ray, way, active):
        """Radiance of the sphere that stands for an ideal point, where a ray meets it before ``way``. [m]"""
        centre, radius = self._vector(index, 15), self._number(index, 11)
        away = centre - ray.o
        along = dr.dot(away, ray.d)
        apart = dr.squared_norm(away - ray.d * along)
        met = active & (along > 0.0) & (along < way) & (apart < dr.square(radius))
        scene = self.scene
        number = dr.select(met, mi.UInt32(self._number(index, 13)), 0)
        it = dr.zeros(mi.Interaction3f)
        it.p, it.n = mi.Point3f(centre - ray.d * scene.extent), mi.Normal3f(ray.d)
        it.wavelengths = ray.wavelengths
        it.time = scene.lights.row(number)
        ds, value = scene.lights.pointer(number).sample_direction(it, mi.Point2f(0.5), met)
        intensity = value * dr.square(ds.dist)
        return dr.select(met, intensity * (dr.inv_pi / dr.square(radius)), 0.0)

    def _sun_radiance(self, index, ray, active):
        """Radiance of a sun as large as it is taken for, where a ray goes to it."""
        scene, number = self.scene, mi.UInt32(self._number(index, 13))
        size, value = self._number(index, 11), mi.Spectrum(0.0)
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.wavelengths = ray.wavelengths
        for k, (radiance, towards, cap, _, _) in enumerate(scene.surroundings.suns):
            inside = 0.5 * dr.squared_norm(ray.d - towards) <= size
            met = active & (number == k) & inside
            value += dr.select(met, radiance.eval(si, met) * (cap / size), 0.0)
        return value


def _cone(away, radius):
    """Axis to a sphere and 1 - cos of the half angle that it fills."""
    _, cap = solid_cap(away, radius)
    distance = dr.norm(away)
    axis = dr.select(distance > 0.0, away / dr.maximum(distance, 1e-30), mi.Vector3f(0.0, 0.0, 1.0))
    return axis, dr.maximum(cap, 1e-14)


def _size_of(light: TracedLight, lines: dict, scene) -> float:
    """What an ideal light is taken for: radius of a sphere [m], or 1 - cos of a sun's angular radius; 0 for surfaces."""
    if light.start == SUN:
        cap = float(np.array(scene.surroundings.suns[light.number][2]).ravel()[0])
        return max(cap, 2.0 * np.sin(0.5 * SUN_RADIUS) ** 2)
    return (
        POINT_SIZE * _quantile(lines["reach"], lines["flux"], 0.1) if light.start == IDEAL else 0.0
    )


def _find_aims(light: TracedLight, lines: dict, size: float, radius: float, most: int):
    """Aims of a light by the lines on which its light arrives, see `light_paths.send_pilot`.

    Lines are parted again and again, by where they begin or by where they go, until each part seems to come from one place.
    """
    whole = _aim_of(light, lines, size, radius)
    parts, done = [(whole, lines)], []
    while parts:
        aim, own = parts.pop(int(np.argmax([aim.flux * aim.spread**2 for aim, _ in parts])))
        halves = None
        if aim.spread > NARROW and len(parts) + len(done) + 2 <= most:
            halves = _part(light, own, size, radius)
        if halves is None or aim.flux < LEAST_PART * whole.flux:
            done.append(aim)
        else:
            parts += halves
    for aim in done:
        yield replace(aim, sphere=whole.sphere)


def _part(light: TracedLight, lines: dict, size: float, radius: float) -> list | None:
    """Two parts of lines with their aims, by where they differ most; None where that is no gain."""
    best, least = None, np.inf
    weight = lines["flux"] / lines["flux"].sum()
    for name in ("direction", "start"):
        away = lines[name] - weight @ lines[name]
        _, axes = np.linalg.eigh(away.T @ (weight[:, None] * away))
        is_high = away @ axes[:, -1] > 0.0
        if min(is_high.sum(), (~is_high).sum()) < FEWEST_LINES:
            continue
        made = []
        for half in (is_high, ~is_high):
            own = {key: values[half] for key, values in lines.items()}
            made.append((_aim_of(light, own, size, radius), own))
        square = sum(aim.flux * aim.spread**2 for aim, _ in made)
        if square < least:
            best, least = made, square
    return best


def _aim_of(light: TracedLight, lines: dict, size: float, radius: float) -> _Aim:
    """Place or direction that lines of light share best. ``radius``: of the scene. [m]"""
    weight = lines["flux"] / lines["flux"].sum()
    start, direction = lines["start"], lines["direction"]
    mean = weight @ direction
    mean /= max(np.linalg.norm(mean), 1e-300)
    chords = np.linalg.norm(direction - mean, axis=1)
    middle = weight @ start
    away = start - middle
    along = (away * direction).sum(axis=1)
    # The point that all lines pass as closely as possible; parallel ones do not tell it.
    system = np.eye(3) * (1.0 + 1e-9) - direction.T @ (weight[:, None] * direction)
    centre = middle + np.linalg.solve(system, weight @ away - (weight * along) @ direction)
    off = centre - start
    apart = np.linalg.norm(off - (off * direction).sum(axis=1)[:, None] * direction, axis=1)
    landing = start + direction * lines["way"][:, None]
    seen = apart / np.maximum(np.linalg.norm(landing - centre, axis=1), 1e-30)
    spreads = [_quantile(each, weight, QUANTILES[1]) for each in (seen, chords)]
    kind = PLACE if spreads[0] <= spreads[1] else DIRECTION
    # What is taken for larger than it is seems larger too.
    extra = 0.0
    if light.start == SUN and kind == DIRECTION:
        extra = np.sqrt(2.0 * size)
    elif light.start == IDEAL and kind == PLACE:
        extra = 2.0 * size
    values = apart if kind == PLACE else chords
    sizes = np.array([SPARE * _quantile(values, weight, q) + extra for q in QUANTILES])
    sizes = np.maximum(sizes, 1e-6 * radius if kind == PLACE else 1e-6)
    if kind == DIRECTION:
        sizes = np.minimum(0.5 * sizes**2, 2.0)
    low, high = start.min(axis=0), start.max(axis=0)
    ball = 0.5 * (low + high)
    reach = SPARE * float(np.linalg.norm(start - ball, axis=1).max()) + 1e-5 * radius
    return _Aim(
        float(lines["flux"].sum()),
        kind,
        centre if kind == PLACE else -mean,
        sizes,
        np.append(ball, reach),
        min(spreads),
    )


def _quantile(values, weight, share: float) -> float:
    order = np.argsort(values, kind="stable")
    held = np.cumsum(weight[order])
    return float(values[order][min(np.searchsorted(held, share * held[-1]), len(order) - 1)])


def _notes(lights: list[_BentLight], missing: list[_BentLight], names: tuple[str, ...]):
    """Say what ideal lights are taken for, and what is missing."""
    points = [each for each in lights if each.light.start == IDEAL]
    if points:
        largest = max(points, key=lambda each: each.size)
        more = f" and {len(points) - 1} more" if len(points) > 1 else ""
        yield (
            f"light of '{largest.name}'{more} that '{names[0]}' bends is computed as if it came from a sphere of "
            f"{2000.0 * largest.size:.2g} mm; edges of its caustics are as much less sharp"
        )
    true = 2.0 * np.sin(0.5 * SUN_RADIUS) ** 2
    if any(each.light.start == SUN and each.size <= true * (1.0 + 1e-6) for each in lights):
        yield (
            f"light of the sun that '{names[0]}' bends is computed for a disk of 0.53 degrees, as the true sun has"
        )
    if missing:
        yield (
            f"light of {len(missing)} lights that '{names[0]}' bends is missing, '{missing[0].name}' first: it would "
            f"take more than {MOST_AIMS} aims to find it"
        )
