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

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import table_size, upload
from ...luminaires.emitters.limb import darken
from ..paths.left_out import LeftOut
from ..paths.visibility import closest_hit
from ..paths.wavelengths import make_sampler
from ..rays import spawn_ray
from .aims import DIRECTION, PLACE, SUN_RADIUS, AimedLight, Lines, find_aimed_lights
from .bent_rays import BentRays
from .emission_rays import (
    IDEAL,
    SUN,
    SURFACE,
    EmissionRays,
    TracedLight,
    find_ray_points,
    has_rays,
    in_cap,
    solid_cap,
)
from .light_paths import find_bent_lights, left_out_of
from .targets import find_targets

MOST_AIMS = 512
"""Most aims of all lights together; of more, lights that give the least are missing, and a note says so."""

SHARES = (0.45, 0.4, 0.15)
"""Of an aim's rays to its inner and its outer cone, and to all that bends the light. [-]"""

ASKED, FEWEST_ASKED = 8.0, 1.0 / 4.0
"""Vertices of a path that ask for bent light, relative to its share of all light, and the fewest of them. [-]"""

COLUMNS = 21
"""Of the table of aims; see `BentLights._upload`."""

MAXIMUM_STEPS = 256
"""Stops a ray between surfaces of which numerical trouble would let none end it."""


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
    lights : tuple of TracedLight    Whose light is found so, in the order of their numbers.
    tree : SphereTree or None    Of what bends light.
    lines : Lines or None    By which light arrives; of lights beyond ``lights`` too.
    notes : tuple of str    What is approximated, for people.
    is_compared : bool    Whether points give, in place of their light, how much less they would give with half their disk.
    """

    def __init__(self, scene):
        self.scene = scene
        self.is_compared = False
        self.left_out = LeftOut(False)
        self.notes: tuple[str, ...] = ()
        self.lights: tuple[TracedLight, ...] = ()
        targets = find_targets(scene)
        self.tree = targets.tree
        found: list[AimedLight] = []
        self.lines: Lines | None = None
        if targets.tree is not None:
            sampler = make_sampler(scene, "luminance")
            lights = find_bent_lights(scene, targets.tree, sampler) + find_ray_points(scene)
            if lights:
                rays = EmissionRays(scene, lights, targets.tree)
                found, self.lines = find_aimed_lights(scene, rays, sampler)
        ends = np.cumsum([len(each.aims) for each in found])
        kept = found[: int(np.searchsorted(ends, MOST_AIMS, side="right"))]
        self.is_needed = bool(kept)
        if not kept:
            return
        self.left_out = left_out_of(scene, [each.light for each in kept]) or self.left_out
        self.lights = tuple(each.light for each in kept)
        self.notes = tuple(_notes(kept, found[len(kept) :], targets.names))
        self._kept, self._unseen = kept, None
        self._upload(kept)
        bent = sum(each.flux for each in kept)
        every = sum(source.flux for source in scene.lights.sources)
        chance = np.clip(ASKED * bent / max(every, 1e-300), FEWEST_ASKED, 1.0)
        # What a sun gives far outside tells nothing of its share in a room behind glass.
        self._asks = dr.opaque(mi.Float, 1.0 if self._suns else float(chance))

    def trace_to_camera(self, numbers: set[int]) -> None:
        """Leave some lights, by their places in ``lights``, to others where the camera sees at once what they light."""
        self._upload(self._kept, numbers)

    def _upload(self, lights: list[AimedLight], traced: set[int] | None = None) -> None:
        traced = traced or set()
        pairs = [(i, each, aim) for i, each in enumerate(lights) for aim in each.aims]
        # Those that vertices in view of the camera ask come first.
        pairs.sort(key=lambda pair: pair[0] in traced)
        asked = sum(number not in traced for number, _, _ in pairs)
        self._first_aims = {number: row for row, (number, _, _) in reversed(list(enumerate(pairs)))}
        self._unseen = dr.opaque(mi.UInt32, asked) if traced else None
        rows = np.zeros((table_size(len(pairs)), COLUMNS))
        for row, (number, each, aim) in zip(rows, pairs, strict=False):
            light = each.light
            row[:3], row[3] = aim.centre, aim.kind
            row[4:6] = aim.sizes
            row[6:10] = aim.sphere
            row[10], row[11] = aim.flux, each.size
            row[12:14] = light.start, light.number
            if light.source is not None:
                row[15:18] = light.source.centre
            row[14], row[18:21] = number, aim.along
        self._rows = upload(mi.Float, rows)
        self._count = dr.opaque(mi.UInt32, len(pairs))
        self._suns = any(each.light.start == SUN for each in lights)
        self._points = any(each.light.start == IDEAL for each in lights)
        self._surfaces = any(each.light.start == SURFACE for each in lights)
        dr.eval(self._rows)

    def first_aim(self, number: int) -> int:
        """Row of the first aim of a light, by its place in ``lights``."""
        return self._first_aims[number]

    @property
    def has_points(self) -> bool:
        """Whether some lights are points, for which spheres stand."""
        return self._points

    # ---- inside kernels ----

    def light(
        self,
        si,
        stream,
        respond,
        active,
        dispersed=False,
        limit=None,
        is_first=None,
        is_seen=None,
        known=None,
    ):
        """One-sample estimate of what lights send to a place over bends.

        Parameters
        ----------
        si : SurfaceInteraction3f    The place.
        stream : PCG32
        respond : callable    As of `next_event`.
        dispersed : Bool    Whether the path has one wavelength left.
        limit : UInt32 or None    Most bends and reflections on the way.
        is_first : Bool or None    Whether the place is the first of a path that spreads light; None: all are.
        is_seen : Bool or None    Whether a camera sees the place at once; None: none does.
        known : known_directions.Directions or None    Where this place is known to get such light from.

        Returns
        -------
        Spectrum    Response times radiance.
        """
        return self.look(si, stream, respond, active, dispersed, limit, is_first, is_seen, known)[0]

    def ask(self, si, stream, respond, active):
        """As `light`, and the number of the light that was asked."""
        value, index, _ = self.look(si, stream, respond, active)
        return value, self.light_of(index)

    def light_of(self, index):
        """Number of the light that an aim belongs to."""
        return mi.UInt32(self._number(index, 14))

    def look(
        self,
        si,
        stream,
        respond,
        active,
        dispersed=False,
        limit=None,
        is_first=None,
        is_seen=None,
        known=None,
    ):
        """As `light`, and the aim by which was looked, and the direction."""
        lit, count = mi.Bool(active), self._count
        if is_seen is not None and self._unseen is not None:
            count = dr.select(is_seen, self._unseen, count)
            lit &= count > 0
        chance = mi.Float(1.0)
        if is_first is not None:
            # Where little of the light is bent, few vertices of a path ask for it.
            chance = dr.select(is_first, 1.0, self._asks)
            lit &= stream.next_float32() < chance
        index, total = self._choose(si.p, stream.next_float32(), count, lit)
        direction = self._direct(index, si.p, stream)
        if known is not None:
            index, direction = known.draw(stream, index, direction)
        density = self._density(index, total, si.p, direction, count, lit)
        if known is not None:
            density = known.density(density, self.light_of(index), direction)
        response, _ = respond(direction, lit)
        amount = mi.Spectrum(response / dr.maximum(chance * density, 1e-30))
        lit &= (density > 0.0) & dr.any(amount != 0.0)
        ray = spawn_ray(self.scene, si, direction)
        scale = mi.Float(1.0) if known is None else known.scale()
        value = self._follow(index, ray, stream, lit, dispersed, limit, scale)
        return dr.select(lit, amount * value, 0.0), index, direction

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

    def _choose(self, point, u, count, active):
        """One of the first aims, and the sum of their weights."""

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
            cond=lambda total, index, u, i: active & (i < count),
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

    def _density(self, index, total, point, direction, count, active):
        """Density with which all of the first aims that are of one light give a direction together. [sr-1]"""
        light = self._number(index, 14)

        def add(density, i):
            pdf = mi.Float(0.0)
            for share, (axis, cap) in zip(SHARES, self._cones(i, point), strict=True):
                # By the chord, since cosines of narrow cones have no digits left.
                inside = 0.5 * dr.squared_norm(direction - axis) <= cap * (1.0 + 1e-4) + 1e-13
                pdf += dr.select(inside, share * dr.inv_two_pi / cap, 0.0)
            is_own = self._number(i, 14) == light
            return dr.select(is_own, density + self._weigh(i, point) * pdf, density), i + 1

        density, _ = dr.while_loop(
            state=(mi.Float(0.0), mi.UInt32(0)),
            cond=lambda density, i: active & (i < count),
            body=add,
            labels=("density", "i"),
        )
        return density / dr.maximum(total, 1e-30)

    def _cones(self, index, point) -> list:
        """Axes of an aim's cones and 1 - cos of their half angles, by `SHARES`."""
        is_far, centre = self._number(index, 3) == DIRECTION, self._vector(index, 0)
        # Light that is still to be gathered comes from the other side.
        away = centre - point
        away = dr.select(dr.dot(away, self._vector(index, 18)) > 0.0, -away, away)
        made = []
        for column in (4, 5):
            size = self._number(index, column)
            axis, cap = _cone(away, size)
            made.append((dr.select(is_far, centre, axis), dr.select(is_far, size, cap)))
        made.append(_cone(self._vector(index, 6) - point, self._number(index, 9)))
        return made

    def _follow(self, index, ray, stream, active, dispersed, limit, scale):
        """Radiance of a light along a ray over bends; what it gives straight does not count.

        ``scale``: size of spheres that stand for points, relative to the usual one.
        """
        scene = self.scene
        start = self._number(index, 12)
        light = mi.UInt32(self._number(index, 13))
        most = mi.UInt32(MAXIMUM_STEPS) if limit is None else mi.UInt32(limit)

        def body(rays, value, turns):
            si = closest_hit(scene, rays.ray, rays.active)
            counts = rays.active & (rays.bends > 0)
            valid = rays.active & si.is_valid()
            if self._surfaces and not self.is_compared:
                emitter = scene.emitter(si, valid)
                met = counts & valid & (start == SURFACE) & (emitter != None)  # noqa: E711 - element-wise
                met &= scene.lights.index(emitter, met, si.time) == light
                value = value + dr.select(met, rays.throughput * emitter.eval(si, met), 0.0)
            if self._points:
                is_point = counts & (start == IDEAL)
                way = dr.select(si.is_valid(), si.t, dr.inf)
                radiance = self._point_radiance(index, rays.ray, way, is_point, scale)
                value = value + rays.throughput * radiance
            if self._suns and not self.is_compared:
                leaves = counts & ~si.is_valid() & (start == SUN)
                value = value + rays.throughput * self._sun_radiance(index, rays.ray, leaves)

            bsdf = scene.bsdf(si, valid)
            rays.active = valid & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Delta)
            choice = rays.stream.next_float32()
            sample = mi.Point2f(rays.stream.next_float32(), rays.stream.next_float32())
            bs, weight = bsdf.sample(mi.BSDFContext(), si, choice, sample, rays.active)
            turned = rays.go_on(scene, si, bs, weight)
            turns = dr.select(turned, turns + 1, turns)
            rays.play_roulette(turned, MAXIMUM_STEPS)
            rays.active &= turns <= most
            return rays, value, turns

        rays = BentRays(mi.Ray3f(ray), mi.PCG32(stream), mi.Bool(active), mi.Bool(dispersed))
        rays, value, _ = dr.while_loop(
            state=(rays, mi.Spectrum(0.0), mi.UInt32(0)),
            cond=lambda rays, value, turns: rays.active,
            body=body,
            labels=("rays", "value", "turns"),
        )
        stream.state = rays.stream.state
        return value

    def _point_radiance(self, index, ray, way, active, scale):
        """Radiance of the sphere that stands for an ideal point, where a ray meets it before ``way``. [m]"""
        centre, radius = self._vector(index, 15), self._number(index, 11) * scale
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
        part = mi.Float(1.0)
        if self.is_compared:
            part -= dr.select(apart < 0.5 * dr.square(radius), 2.0, 0.0)
        return dr.select(met, intensity * (part * dr.inv_pi / dr.square(radius)), 0.0)

    def _sun_radiance(self, index, ray, active):
        """Radiance of a sun as large as it is taken for, where a ray goes to it."""
        scene, number = self.scene, mi.UInt32(self._number(index, 13))
        size, value = self._number(index, 11), mi.Spectrum(0.0)
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.wavelengths = ray.wavelengths
        for k, (radiance, towards, cap, _, _, limb) in enumerate(scene.surroundings.suns):
            inside = 0.5 * dr.squared_norm(ray.d - towards) <= size
            met = active & (number == k) & inside
            given = darken(radiance.eval(si, met), limb, ray.d, towards, size)
            value += dr.select(met, given * (cap / size), 0.0)
        return value


def _cone(away, radius):
    """Axis to a sphere and 1 - cos of the half angle that it fills."""
    _, cap = solid_cap(away, radius)
    distance = dr.norm(away)
    axis = dr.select(distance > 0.0, away / dr.maximum(distance, 1e-30), mi.Vector3f(0.0, 0.0, 1.0))
    return axis, dr.maximum(cap, 1e-14)


def _notes(lights: list[AimedLight], missing: list[AimedLight], names: tuple[str, ...]):
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
    sets = [each for each in points if has_rays(each.light)]
    if sets:
        more = f" and {len(sets) - 1} more" if len(sets) > 1 else ""
        yield (
            f"light of the ray set '{sets[0].name}'{more} that '{names[0]}' bends is computed for a point with its "
            "intensities, but for what the camera sees of it at once"
        )
    if missing:
        yield (
            f"light of {len(missing)} lights that '{names[0]}' bends is missing, '{missing[0].name}' first: it would "
            f"take more than {MOST_AIMS} aims to find it"
        )
