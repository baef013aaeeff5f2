"""Shadow catchers: what is behind everything, seen through a surface that shows but the shadows of what stands on it.

What a pixel shows of it is the light behind times E_s / E: the illuminance of the surface with all that stands there over
that by lamps, suns and world alone. Both come of the same samples, so they are equal where nothing stands in the way,
however few the samples are. Light that objects throw there counts in E_s. Catchers themselves shade each other in both, and
what they throw on each other counts in neither: the picture behind them holds it.

Mirrors, glass and gloss show a ground that only the camera meets as a part of the surroundings, as if nothing stood there.
So rays are followed over them to the ground, and what its shadows take from what is seen is taken away.

References
----------
A. Voloboy: Software technologies that automate the making of realistic images, dissertation, Moscow 2012, 1.4.2.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import average, table_size, upload
from ...caught_light import CaughtLayout
from ...scene.sensor import SensorKind
from ..compiled.polarisation import polarise
from ..rays import spawn_ray, spawn_ray_to, spawn_straight
from . import gather
from .film import sees
from .next_event import mirrored_light, sample_numbered_emitter
from .path_loop import trace
from .sampler import hash_words, random_stream, sobol_pair
from .spotted_light import spotted_light
from .visibility import closest_hit, first_ground, meet, transmittance
from .wavelengths import disperse

LONGEST_WAY = 1000
"""Surfaces that a ray is followed through."""

MOST_TURNS = 64
"""Mirrors, glass and gloss that a ray is followed over; what is left of light after as many is nothing that is seen."""

NO_DENSITY = 1e-20
"""Density of rays beside which next-event counts all that it can find; not 0, which says that it finds nothing. [sr-1]"""


class Catchers:
    """What a picture knows of its shadow catchers, as columns of `caught_light.CaughtLayout`.

    Parameters
    ----------
    scene : CompiledScene    With catchers.
    colour : callable    ``colour(radiance, wavelengths)`` gives X, Y, Z.
    bands : callable    ``bands(radiance, wavelengths)`` gives the light of bands.
    band_count : int

    Attributes
    ----------
    layout : CaughtLayout
    """

    def __init__(self, scene, colour, bands, band_count: int):
        self._scene, self._colour, self._bands = scene, colour, bands
        # Light groups see what is behind as it is while all shine.
        self._surroundings, self._backdrop = scene.whole_surroundings()
        self.layout = layout_of(scene, band_count)
        lamps = {id(source) for source in scene.sources().values()}
        sources = scene.lights.sources
        # What glows of the objects is one of them, and no lamp that shines without them.
        is_lamp = np.zeros(table_size(max(len(sources), 1)), dtype=bool)
        is_lamp[: len(sources)] = [s.centre is None or id(s) in lamps for s in sources]
        self._is_lamp = upload(mi.Bool, is_lamp)
        dr.eval(self._is_lamp)

    def of_view(self, ray, wavelengths, sample, seed) -> list:
        """Columns of rays of the camera."""
        stream = random_stream(sample, hash_words(seed, mi.UInt32(2)))
        seen, share, met = self._meet(ray, wavelengths)
        weight = dr.select(met, average(share), 0.0)
        behind = dr.select(met, share * _look(self._backdrop, ray, wavelengths, met), 0.0)
        place, side, at_ground, bounced = mi.Point3f(seen.p), -ray.d, None, None
        chance, chance_of_ground = mi.Float(1.0), mi.Float(0.0)
        normal, shading, extent = seen.n, seen.sh_frame.n, self._scene.extent_at(seen)
        if self.layout.has_bounced:
            ground, away, bounced, at_ground = self._bounce(ray, wavelengths, stream)
            # Where panes show both, one of them is asked for its shadows.
            both = met & at_ground
            takes = at_ground & (~met | (stream.next_float32() < 0.5))
            chance = dr.select(takes, 0.0, dr.select(both, 2.0, 1.0))
            chance_of_ground = dr.select(takes, dr.select(both, 2.0, 1.0), 0.0)
            place, side = dr.select(takes, ground.p, place), dr.select(takes, -away, side)
            normal = dr.select(takes, ground.n, normal)
            shading = dr.select(takes, ground.sh_frame.n, shading)
            extent = dr.select(takes, self._scene.extent_at(ground), extent)
        asked = met if at_ground is None else met | at_ground
        facing = dr.select(dr.dot(normal, side) > 0.0, 1.0, -1.0)
        at = gather.receiver(place, shading * facing, normal * facing, wavelengths, extent)
        light_sample = sobol_pair(sample, seed, gather.PAIR_LIGHT)
        shaded, open_light = self._with_and_without(at, stream, light_sample, asked)
        scatter_sample = sobol_pair(sample, seed, gather.PAIR_SCATTER)
        is_straight = chance > 0.0
        shaded += self._thrown(at, wavelengths, stream, scatter_sample, asked, is_straight)
        made = [weight]
        made += self._part(behind, shaded, open_light, weight * chance, wavelengths)
        if bounced is not None:
            # A ground that is darker counts less, so that pixels which show much of it are right too.
            own = average(bounced) * chance_of_ground
            made += self._part(bounced, shaded, open_light, own, wavelengths)
        # No sample that is no number may take the others with it.
        return [dr.select(dr.isfinite(each), each, 0.0) for each in made]

    # ---- private ----

    def _part(self, behind, shaded, open_light, weight, wavelengths) -> list:
        """Columns of a part: of the light behind, and of the light there with and without all, so much of which counts."""
        with_all, without = (
            [dr.select(weight > 0.0, each * weight, 0.0) for each in self._colour(v, wavelengths)]
            for v in (shaded, open_light)
        )
        colours, y, y_open = self._colour(behind, wavelengths), with_all[1], without[1]
        squares = [dr.square(y), y * y_open, dr.square(y_open), dr.square(colours[1])]
        bands = self._bands(behind, wavelengths) if self.layout.bands else ()
        return [*colours, *with_all, *without, *squares, *bands]

    def _meet(self, ray, wavelengths):
        """First catcher that rays see straight: the surface, what of light gets there, and whether there is one."""
        scene = self._scene
        ray = mi.Ray3f(ray)
        if wavelengths is not None:
            ray.wavelengths = wavelengths

        def is_caught(si, met):
            number = dr.reinterpret_array(mi.UInt32, si.shape)
            caught = met & dr.gather(mi.Bool, scene.catchers, number, met)
            if scene.hidden is not None:
                caught &= ~dr.gather(mi.Bool, scene.hidden, number, met)
            return caught

        def step(ray, share, going, steps):
            si = closest_hit(scene, ray, going, looks=mi.Bool(True))
            met = going & si.is_valid()
            caught = is_caught(si, met)
            passed = scene.bsdf(si, met).eval_null_transmission(si, met)
            if scene.hidden is not None:
                number = dr.reinterpret_array(mi.UInt32, si.shape)
                passed = dr.select(dr.gather(mi.Bool, scene.hidden, number, met), 1.0, passed)
            goes_on = met & ~caught
            share = dr.select(goes_on, share * passed, share)
            ray = dr.select(goes_on, spawn_straight(scene, si, ray), ray)
            going = goes_on & dr.any(share != 0.0) & (steps < LONGEST_WAY)
            return ray, share, going, steps + 1

        ray, share, _, _ = dr.while_loop(
            state=(ray, mi.Spectrum(1.0), sees(ray), mi.UInt32(0)),
            cond=lambda ray, share, going, steps: going,
            body=step,
            labels=("ray", "share", "going", "steps"),
        )
        active = sees(ray) & dr.any(share != 0.0)
        si = closest_hit(scene, ray, active, looks=mi.Bool(True))
        met = is_caught(si, active & si.is_valid())
        return si, dr.select(met, share, 0.0), met

    def _bounce(self, ray, wavelengths, stream):
        """Follow rays of the camera over mirrors, glass and gloss to a ground that only the camera meets.

        Returns
        -------
        (SurfaceInteraction3f, Vector3f, Spectrum, Bool)
            The ground, the direction of the ray that meets it, what is seen of the surroundings there, and whether it is.
        """
        scene = self._scene
        ray = mi.Ray3f(ray)
        if wavelengths is not None:
            ray.wavelengths = wavelengths
        diffuse = mi.BSDFFlags.Diffuse

        def marks(table, si, met):
            if table is None:
                return mi.Bool(False)
            return met & dr.gather(mi.Bool, table, dr.reinterpret_array(mi.UInt32, si.shape), met)

        def step(ray, numbers, share, polar, dispersed, turns, found, going, steps):
            begins = turns == 0
            hit, si = meet(scene, ray, going, looks=begins)
            # What is there for the camera alone mirrors do not show, but for the ground.
            ground, distance = first_ground(scene, ray, going & ~begins)
            is_ground = going & ~begins & ground.is_valid() & (distance <= hit.t)
            met = going & si.is_valid() & ~is_ground
            found |= is_ground
            passed = met & begins & marks(scene.hidden, si, met)
            acts = met & ~passed & ~(begins & marks(scene.catchers, si, met))
            bsdf = scene.bsdf(si, acts)
            choice = numbers.next_float32()
            number = mi.Point2f(numbers.next_float32(), numbers.next_float32())
            bs, weight = bsdf.sample(mi.BSDFContext(), si, choice, number, acts)
            turned = acts & ~mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
            onwards = dr.select(acts, si.to_world(bs.wo), ray.d)
            throughput, dispersed = disperse(scene, bs, share * weight, dispersed, turned)
            factor, polar = polarise(scene, si, ray.d, onwards, polar, turned, acts)
            share = dr.select(acts, throughput * factor, share)
            turns = dr.select(turned, turns + 1, turns)
            going = passed | (acts & ~mi.has_flag(bs.sampled_type, diffuse))
            going &= dr.any(share != 0.0) & (turns < MOST_TURNS) & (steps < LONGEST_WAY)
            left = dr.maximum(ray.maxt - si.t, 0.0)
            ray = dr.select(going, spawn_ray(scene, si, onwards), ray)
            # The end of the camera's clipping holds for what is seen straight.
            ray.maxt = dr.select(
                going & turned, dr.largest(mi.Float), dr.select(going, left, ray.maxt)
            )
            share = dr.select(acts & ~going, 0.0, share)
            return ray, numbers, share, polar, dispersed, turns, found, going, steps + 1

        ray, _, share, _, _, _, found, _, _ = dr.while_loop(
            state=(
                ray,
                mi.PCG32(stream),
                mi.Spectrum(1.0),
                mi.Vector3f(0.0),
                mi.Bool(False),
                mi.UInt32(0),
                mi.Bool(False),
                sees(ray),
                mi.UInt32(0),
            ),
            cond=lambda *state: state[-2],
            body=step,
            labels=(
                "ray",
                "numbers",
                "share",
                "polar",
                "dispersed",
                "turns",
                "found",
                "going",
                "steps",
            ),
        )
        met = found & dr.any(share != 0.0)
        si = scene.surface(first_ground(scene, ray, met)[0], ray, met)
        # What lies below is seen by light as if the ground were not there.
        met &= ~closest_hit(scene, ray, met).is_valid()
        light = dr.select(met, share * _look(self._surroundings, ray, wavelengths, met), 0.0)
        return si, ray.d, light, met & dr.any(light != 0.0)

    def _with_and_without(self, at, stream, light_sample, active):
        """Illuminance by light from lamps, with all that stands there and with catchers alone, by the same samples."""
        scene = self._scene
        if not scene.lights.count:
            return mi.Spectrum(0.0), mi.Spectrum(0.0)
        answer = _answer_at(at)
        index, ds, value = sample_numbered_emitter(scene, at, light_sample, active)
        lit = active & (ds.pdf > 0.0) & dr.any(value != 0.0)
        amount = value * answer(ds.d, lit)[0]
        lit &= dr.any(amount != 0.0)
        passed = transmittance(scene, at, ds, lit)
        is_lamp = dr.gather(mi.Bool, self._is_lamp, index, lit)
        hindered = lit & is_lamp & dr.any(passed != 1.0)
        comes = lit & is_lamp & ~self._is_between(at, ds, hindered)
        shaded = dr.select(lit, amount * passed, 0.0)
        return shaded, dr.select(comes, amount, 0.0)

    def _is_between(self, at, ds, active):
        """Whether a catcher stands between a place and a lamp."""
        scene = self._scene

        def step(ray, going, found, steps):
            si = closest_hit(scene, ray, going)
            going = going & si.is_valid()
            number = dr.reinterpret_array(mi.UInt32, si.shape)
            is_catcher = going & dr.gather(mi.Bool, scene.catchers, number, going)
            going &= ~is_catcher & (steps < LONGEST_WAY)
            ray = dr.select(going, spawn_straight(scene, si, ray), ray)
            return ray, going, found | is_catcher, steps + 1

        ray = spawn_ray_to(scene, at, ds.p, ds.n)
        _, _, found, _ = dr.while_loop(
            state=(ray, mi.Bool(active), mi.Bool(False), mi.UInt32(0)),
            cond=lambda ray, going, found, steps: going,
            body=step,
            labels=("ray", "going", "found", "steps"),
        )
        return found

    def _thrown(self, at, wavelengths, stream, scatter_sample, active, is_straight):
        """Illuminance by light that objects throw on a place.

        ``is_straight``: whether the camera sees the place at once, so that caustics which are traced to it are no part.
        """
        scene, answer = self._scene, _answer_at(at)
        total = mi.Spectrum(0.0)
        if scene.mirrors is not None and scene.lights.count:
            sample = mi.Point2f(stream.next_float32(), stream.next_float32())
            total += mirrored_light(scene, at, sample, stream, answer, active)
        if scene.spots is not None and scene.lights.count:
            total += spotted_light(scene, at, stream, answer, active)
        if scene.bent is not None:
            total += scene.bent.light(at, stream, answer, active, is_seen=is_straight)
        local = mi.warp.square_to_cosine_hemisphere(scatter_sample)
        ray = spawn_ray(scene, at, at.sh_frame.to_world(local))
        gathers = active & (dr.dot(ray.d, at.n) > 0.0)
        si = closest_hit(scene, ray, gathers)
        gathers &= si.is_valid()
        number = dr.reinterpret_array(mi.UInt32, si.shape)
        gathers &= ~dr.gather(mi.Bool, scene.catchers, number, gathers)
        density = mi.Float(NO_DENSITY)
        light = trace(scene, ray, wavelengths, stream, density, at.p, gathers, depth=1)
        return total + dr.select(gathers, light * dr.pi, 0.0)


def layout_of(scene, bands: int) -> CaughtLayout | None:
    """Columns that pictures of a scene keep of its shadow catchers, None without any."""
    if scene.catchers is None:
        return None
    has_surroundings = scene.whole_surroundings()[0] is not None
    return CaughtLayout(bands, scene.grounds is not None and has_surroundings)


def tell_catchers(scene) -> tuple[str, ...]:
    """Tell what of shadow catchers pictures do not show as it is, and no stated error holds."""
    notes = []
    if scene.has_lit_catchers and (scene.mirrors is not None or scene.bent is not None):
        notes.append(
            "mirrors and glass show objects that catch shadows as what they are made of, with their shadows"
        )
    layout = layout_of(scene, 0)
    if layout is not None and layout.has_bounced and any(True for _ in scene.parts()):
        notes.append(
            "light that things throw on the ground, and matt surfaces, see it as bright as the surroundings have it: "
            "close below bright things its shadow is too light, which no stated error holds"
        )
    return tuple(notes)


def _answer_at(at):
    """How a matt surface answers light, for `next_event` and the like, which shares none of it with scattered rays."""
    respond = gather.response_of(SensorKind.PLANAR, at)
    return lambda direction, asked: (respond(direction), mi.Float(0.0))


def _look(surroundings, ray, wavelengths, active):
    """Light that surroundings, or None, send along rays from infinity."""
    if surroundings is None:
        return mi.Spectrum(0.0)
    away = dr.zeros(mi.SurfaceInteraction3f)
    # A ground that the surroundings lie on is seen from where the ray comes from.
    away.wi, away.p = -ray.d, ray.o
    if wavelengths is not None:
        away.wavelengths = wavelengths
    return surroundings.eval(away, active)
