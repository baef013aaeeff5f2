"""Light over bends traced to the camera: caustics in pictures, as they are in lux maps.

Paths that begin at the lights end at the first surface that spreads light out (see `light_paths`). In a picture each such
place is joined with the camera, if it sees the place at once, straight or through panes: the surface answers the light that
arrives with all of its model, and the pixels about the place get what it sends to the camera. So ideal points and suns need
no size that rays could meet, and where light is gathered many paths land.

On a shadow catcher, a ground that only the camera meets among them, the light is a part of the illuminance with all that
stands there. What is joined so, paths from the camera leave out at the first surface that they meet; at later ones, and at
what is seen in mirrors or through glass, they ask for it as ever (see `bent_lights`). Which lights are traced is decided by
a pilot of both ways, by what either scatters. Nothing is prepared where nothing bends light.
"""

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import average
from ...errors import Cancelled
from ..compiled.polarisation import polarise
from ..paths import gather
from ..paths.channels import BAND_RANGE, colour_of, picture_sampler
from ..paths.film import GROUPS, sees
from ..paths.next_event import respond_by
from ..paths.pixel_filter import FILTER_RADIUS
from ..paths.sampler import random_stream
from ..paths.visibility import MOST_PASSES, closest_hit
from ..rays import spawn_ray_to
from .camera_places import CameraPlaces
from .deposits import follow
from .emission_rays import EmissionRays, has_rays
from .light_paths import LEARNED, draw_paths
from .ray_lights import RayLights

LANES = 1 << 19
"""Paths per launch."""

PILOT, ASKED = 1 << 17, 1 << 15
"""Paths from the lights and vertices in view by which both ways are compared."""

PILOT_SEED = 0x77A1
"""Of both; the same scene and view always give the same choice."""

FEWEST, MOST = 1 << 12, 1 << 21
"""Paths of one half in a pass."""

LEAST_SHARE, MOST_SHARE = 1.0 / 4.0, 4.0
"""Paths from the lights for every one from the camera; in between as their scatter asks for."""

BLOCK = 8
"""Pixels along the side of squares whose mean luminance is that of a place."""

SALT = 0xCA57
"""Sets these paths apart from others of the same seed."""

MISSED = 0.03
"""Difference of what both ways find, above which rays to lights are not believed. [-]"""

SURE = 4.0
"""Standard errors of that difference which are put down to chance."""

CHEAPER = 2.0
"""By how much what paths from the lights scatter may exceed what rays to them do: rare rays seem to scatter less than they
do, and a path from a light costs less than one from the camera. [-]"""


class CameraLight:
    """Adds traced light to the pixels of a picture.

    Parameters
    ----------
    scene : CompiledScene    With its light over bends prepared.
    film : Film
    settings : ViewSettings
    cancelled : callable    Asked before every launch.

    Attributes
    ----------
    is_needed : bool    Whether anything is traced.
    lost : (int, int)    Paths that were no numbers, and all.
    notes : tuple of str    What is traced, for people.
    """

    def __init__(self, scene, film, settings, cancelled=lambda: False):
        self._scene, self._film, self._seed = scene, film, int(settings.seed)
        self._places = CameraPlaces(film)
        self._bands = settings.bands
        self._sampler = picture_sampler(scene, settings.bands)
        self._colour, self._band_colour = colour_of(scene.mean_light, settings.bands)
        self._pixels = film.camera.width * film.camera.height
        self._cancelled = cancelled
        self._meets_grounds = scene.grounds is not None
        self._rays: EmissionRays | None = None
        self._sets: RayLights | None = None
        self._share = 1.0
        self.lost = 0, 0
        self.notes: tuple[str, ...] = ()
        if scene.bent is not None and not self._places.is_possible:
            self.notes = (
                "light over bends is not traced to a camera of this projection or lens; paths of the camera look for it",
            )
        elif scene.bent is not None:
            self._choose(scene.bent)
        self.is_needed = self._rays is not None or self._sets is not None
        if self.is_needed:
            self.notes = (
                "what the camera sees at once of light over bends is traced from the lights",
            )

    def add(self, sums: np.ndarray, done: int, samples: int, channels) -> None:
        """Add what traced light gives to sums of samples.

        Parameters
        ----------
        sums : (halves, pixels, channels) array    The first three of these are X, Y, Z, the last ones the bands. [cd/m2]
        done, samples : int    Of every pixel and half before and in this pass.
        channels : Channels    What else there is.
        """
        count = int(np.clip(self._pixels * samples * self._share, FEWEST, MOST))
        found = np.zeros((GROUPS, self._pixels, 3 + self._bands))
        caught = np.zeros((GROUPS, self._pixels, 3))
        for half in range(GROUPS):
            words = [self._seed & 0xFFFFFFFF, done, half, SALT]
            seed = int(np.random.default_rng(words).integers(1 << 32))
            for landed in self._launches(count, seed):
                self._splat(landed.only(~landed.is_caught), found[half])
                self._splat(landed.only(landed.is_caught), caught[half])
        paths = None if done else channels.composed(sums / samples)[..., 1]
        sums[..., :3] += samples * found[..., :3]
        if self._bands:
            sums[..., -self._bands :] += samples * found[..., 3:]
        if channels.catchers is not None:
            sums[..., channels.shaded_columns] += samples * caught
        if not done:
            whole = channels.composed(sums / samples)[..., 1]
            self._share_out(paths, whole - paths, samples, count)

    # ---- private ----

    def _share_out(self, paths, traced, samples: int, count: int) -> None:
        """Choose how many paths there are for every one of the camera, by what both scatter in the first pass.

        ``paths``, ``traced``: means of both halves (2, pixels) by so many samples of each pixel, and paths of all. [cd/m2]
        """
        whole = (paths + traced).mean(axis=0)
        # As the picture's error does, relative to the larger of a place's and the mean luminance.
        camera = self._film.camera
        place = np.arange(self._pixels) // camera.width // BLOCK * (camera.width // BLOCK + 1)
        place += np.arange(self._pixels) % camera.width // BLOCK
        around = np.bincount(place, whole) / np.maximum(np.bincount(place), 1)
        scale = np.maximum(around[place], max(float(whole.mean()), 1e-300))
        scatter = [
            float((((each[0] - each[1]) / scale) ** 2).mean()) * many
            for each, many in ((paths, samples), (traced, count / self._pixels))
        ]
        wanted = np.sqrt(scatter[1] / max(scatter[0], 1e-300))
        self._share = float(np.clip(wanted, LEAST_SHARE, MOST_SHARE))

    def _choose(self, bent) -> None:
        """Compare both ways, and trace those lights that scatter less so; of ray sets their rays in any case."""
        lights, count = bent.lights, len(bent.lights)
        sets = {n for n, light in enumerate(lights) if has_rays(light)}
        if sets:
            made = RayLights(
                self._scene,
                self._sampler,
                has_near=False,
                meets_grounds=self._meets_grounds,
            )
            self._sets = made if made.is_needed else None
        traced: set[int] = set() if self._sets is None else sets
        others = [n for n in range(count) if n not in sets]
        if others:
            traced = traced | self._compare(lights, np.array(others), bent.tree)
        bent.trace_to_camera(traced)

    def _compare(self, lights, others: np.ndarray, tree) -> set[int]:
        """Lights among others that scatter less if they are traced; their rays are prepared."""
        rays = EmissionRays(self._scene, tuple(lights[n] for n in others), tree)
        landed = self._launch(rays, PILOT, PILOT_SEED, 0)
        luminance = landed.luminance
        squares = luminance**2
        # Mean squares of a pixel's luminance by one path for each pixel, and by one question for each vertex.
        scale = 1.0 / (PILOT * float(self._pixels) ** 2)
        traced = scale * np.bincount(landed.pair // rays.targets, squares, len(others))
        light = np.bincount(landed.pair // rays.targets, luminance, len(others))
        # Where nothing has landed these counts are whole numbers.
        light = light / (PILOT * self._pixels)
        asked, seen = (each[others] for each in self._ask(len(lights)))
        # Rays that surely find another amount of light miss some of it, whatever they scatter.
        chance = np.sqrt(traced / PILOT + asked / ASKED)
        is_found = np.abs(seen - light) < MISSED * light + SURE * chance
        chosen = np.flatnonzero((traced > 0.0) & (~is_found | (traced < CHEAPER * asked)))
        if not len(chosen):
            return set()
        wanted = np.bincount(landed.pair, squares, rays.pairs) * rays.shares
        wanted = np.sqrt(wanted.reshape(len(others), -1)[chosen].ravel())
        self._rays = EmissionRays(self._scene, tuple(lights[n] for n in others[chosen]), tree)
        # Fewer lights may have more targets each, for which nothing was learned.
        if wanted.size == self._rays.pairs:
            learned = wanted / wanted.sum()
            self._rays.set_shares((1.0 - LEARNED) * self._rays.shares + LEARNED * learned)
        return set(others[chosen].tolist())

    def _ask(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Mean squares and means of the luminance that rays to each light give vertices in view. (count,), (count,)"""
        scene, film = self._scene, self._film
        lane = dr.arange(mi.UInt32, ASKED)
        stream = random_stream(lane, dr.opaque(mi.UInt32, PILOT_SEED))
        x, y = stream.next_float32() * film.size.x, stream.next_float32() * film.size.y
        ray = film.ray(x, y, mi.Point2f(stream.next_float32(), stream.next_float32()))
        looks = mi.Bool(True)
        si = closest_hit(scene, ray, sees(ray), looks=looks, passes_veil=True)
        wavelengths = None
        if self._sampler is not None:
            wavelengths = self._sampler.sample(stream.next_float32())
            si.wavelengths = wavelengths
        bsdf = scene.bsdf(si, si.is_valid())
        smooth = si.is_valid() & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
        respond = respond_by(bsdf, si)
        if scene.seen_catchers is not None:
            number = dr.reinterpret_array(mi.UInt32, si.shape)
            is_caught = dr.gather(mi.Bool, scene.seen_catchers, number, si.is_valid())
            smooth |= is_caught
            respond = _respond_by_catchers(respond, si, ray, is_caught)
        value, light = scene.bent.ask(si, stream, respond, smooth)
        amount = gather.photometric(self._sampler, value, wavelengths)
        dr.eval(amount, light)
        amount, light = np.array(amount, dtype=np.float64), np.array(light)
        amount = np.where(np.isfinite(amount), amount, 0.0)
        return tuple(np.bincount(light, amount**k, count)[:count] / ASKED for k in (2, 1))

    def _launches(self, count: int, seed: int):
        """Trace about so many paths of every kind; yields what the camera sees of them, over their number."""
        if self._rays is not None:
            for first in range(0, count, LANES):
                self._check()
                width = min(LANES, count - first)
                yield self._launch(self._rays, width, seed, first).over(count)
        if self._sets is not None:
            for end, power, wavelengths in self._sets.sent(count, seed):
                self._check()
                stream = random_stream(
                    dr.arange(mi.UInt32, dr.width(power)), dr.opaque(mi.UInt32, seed ^ SALT)
                )
                yield self._join(end, power, wavelengths, stream, mi.UInt32(0))

    def _check(self) -> None:
        if self._cancelled():
            raise Cancelled("cancelled")

    def _launch(self, rays: EmissionRays, width: int, seed: int, index: int) -> "_Splats":
        """Trace paths and join what lands with the camera; amounts are those of single paths."""
        scene = self._scene
        lane = dr.arange(mi.UInt32, width) + dr.opaque(mi.UInt32, int(index) & 0xFFFFFFFF)
        seed = dr.opaque(mi.UInt32, int(seed) & 0xFFFFFFFF)
        ray, flux, pair, wavelengths = draw_paths(rays, self._sampler, lane, seed)
        stream = random_stream(lane, seed)
        end = follow(scene, ray, stream, dr.any(flux > 0.0), meets_grounds=self._meets_grounds)
        return self._join(end, end["throughput"] * flux, wavelengths, stream, pair)

    def _join(self, end: dict, power, wavelengths, stream, pair) -> "_Splats":
        """What places that paths have come to send to the camera. ``end``: as of `follow`; ``power``: that arrives."""
        scene = self._scene
        landed = end["landed"] & (end["geometric_cosine"] > 0.0)
        si = scene.interaction_at(end["shape"], end["prim"], end["uv"], landed)
        if wavelengths is not None:
            si.wavelengths = wavelengths
        # Of numbers of its own: the path may have used any of the stream's.
        numbers = random_stream(stream.next_uint32(), mi.UInt32(SALT))
        link = self._places.link(si.p, numbers)
        seen = landed & link.seen
        is_caught = mi.Bool(False)
        if scene.seen_catchers is not None:
            is_caught = seen & dr.gather(mi.Bool, scene.seen_catchers, end["shape"], seen)
        if scene.hidden is not None:
            seen &= is_caught | ~dr.gather(mi.Bool, scene.hidden, end["shape"], seen)
        si.wi = si.to_local(link.direction)
        bsdf = scene.bsdf(si, seen)
        towards = si.to_local(-end["ray"].d)
        answer = bsdf.eval(mi.BSDFContext(), si, towards, seen)
        # A catcher has the illuminance of the side that is seen.
        is_front = dr.dot(si.n, link.direction) * dr.dot(si.n, end["ray"].d) < 0.0
        cosine = dr.select(is_front, dr.abs(mi.Frame3f.cos_theta(towards)), 0.0)
        answer = dr.select(is_caught, cosine, answer)
        facing = dr.abs(dr.dot(si.n, link.direction))
        value = power * answer * (link.density * facing / dr.maximum(end["geometric_cosine"], 1e-6))
        seen &= dr.any(value != 0.0)
        passed = _passed(scene, link, si, seen)
        value = value * dr.select(is_caught, average(passed), passed)
        return self._fetch(link, value, wavelengths, pair, seen, is_caught)

    def _fetch(self, link, value, wavelengths, pair, seen, is_caught) -> "_Splats":
        if self._sampler is None:
            colour = [value[0] * float(c) for c in self._colour]
        else:
            colour = list(self._sampler.tristimulus(value, wavelengths))
        parts = []
        if self._bands and self._sampler is not None:
            density = self._sampler.density(wavelengths)
            width = (BAND_RANGE[1] - BAND_RANGE[0]) / self._bands
            parts = [value[k] / (4.0 * density[k] * width) for k in range(4)]
            parts += list(wavelengths)
        amount = sum(colour[1:], colour[0])
        is_number = dr.isfinite(amount)
        # Places beside the film are no part of the picture, and next to the camera's plane their light is boundless.
        kept = seen & is_number & (amount != 0.0) & self._is_on_film(link)
        columns = [*(each[0] for each in link.places), *(each[1] for each in link.places)]
        columns += [dr.zeros(mi.Float, dr.width(kept)) + mi.Float(is_caught), *colour, *parts]
        dr.eval(columns, kept, is_number, seen, pair)
        lost = int(np.count_nonzero(np.array(seen & ~is_number)))
        self.lost = self.lost[0] + lost, self.lost[1] + dr.width(kept)
        chosen = np.flatnonzero(np.array(kept))
        table = [np.array(each)[chosen].astype(np.float64) for each in columns]
        many = len(link.places)
        x, y = np.stack(table[:many], axis=1), np.stack(table[many : 2 * many], axis=1)
        caught, *rest = table[2 * many :]
        pairs = np.broadcast_to(np.array(pair), len(np.array(kept)))[chosen]
        return _Splats(x, y, np.stack(rest[:3], axis=1), pairs, rest[3:], caught > 0.0)

    def _is_on_film(self, link):
        """Whether any pixel gets light of a place."""
        size, held = self._film.size, mi.Bool(False)
        for x, y in link.places:
            held |= (x > -0.5) & (x < size.x + 0.5) & (y > -0.5) & (y < size.y + 0.5)
        return held

    def _splat(self, landed: "_Splats", sums: np.ndarray) -> None:
        """Share light out among the pixels about where it is seen. ``sums``: (pixels, 3 or 3 + bands)."""
        for x, y in zip(landed.x.T, landed.y.T, strict=True):
            # No more than two pixels in a row are within the filter.
            left, low = np.floor(x - 0.5), np.floor(y - 0.5)
            for step in range(4):
                column, row = left + step % 2, low + step // 2
                weight = _tent(x - 0.5 - column) * _tent(y - 0.5 - row)
                self._add_to(sums, landed, column, row, weight)

    def _add_to(self, sums, landed: "_Splats", column, row, weight) -> None:
        """Add what one pixel each gets."""
        camera = self._film.camera
        held = (weight > 0.0) & (column >= 0) & (row >= 0)
        held = np.flatnonzero(held & (column < camera.width) & (row < camera.height))
        if not len(held):
            return
        pixel = (row[held] * camera.width + column[held]).astype(np.int64)
        weight = weight[held]
        if self._sampler is None:
            # All light has one colour.
            own = np.bincount(pixel, weight * landed.colour[held, 1], self._pixels)
            columns = [*self._colour, *self._band_colour][: sums.shape[1]]
            sums += (own / float(self._colour[1]))[:, None] * columns
            return
        for k in range(3):
            sums[:, k] += np.bincount(pixel, weight * landed.colour[held, k], self._pixels)
        if sums.shape[1] == 3:
            return
        for band, share in self._band_columns(landed):
            known = (band[held] >= 0) & (band[held] < self._bands)
            place = pixel * (self._bands + 3) + 3 + np.clip(band[held], 0, self._bands - 1)
            own = np.where(known, weight * share[held], 0.0)
            sums += np.bincount(place, own, sums.size).reshape(sums.shape)

    def _band_columns(self, landed: "_Splats") -> list:
        """Numbers of bands and what of the light lies in them."""
        width = (BAND_RANGE[1] - BAND_RANGE[0]) / self._bands
        made = []
        for value, wavelength in zip(landed.parts[:4], landed.parts[4:], strict=True):
            # A wavelength stands for the nanometre about it, which an edge between two bands may divide.
            start = (wavelength - 0.5 - BAND_RANGE[0]) / width
            first = np.floor(start)
            beyond = np.clip((start + 1.0 / width - first - 1.0) * width, 0.0, 1.0)
            made += [(first.astype(np.int64), value * (1.0 - beyond))]
            made += [(first.astype(np.int64) + 1, value * beyond)]
        return made


@dataclass(frozen=True)
class _Splats:
    """Light that the camera sees, of single paths.

    ``x``, ``y``: (m, k) places on the film [pixel], of which only those on it count. ``colour``: (m, 3) X, Y, Z times
    pixels. ``pair``: (m,) of light and target. ``parts``: columns of four amounts and wavelengths, where there are bands.
    ``is_caught``: (m,) whether it lands on a shadow catcher, whose ``colour`` is that of the illuminance.
    """

    x: np.ndarray
    y: np.ndarray
    colour: np.ndarray
    pair: np.ndarray
    parts: list
    is_caught: np.ndarray

    @property
    def luminance(self) -> np.ndarray:
        """Y; a shadow catcher counts as white and matt. (m,)"""
        return np.where(self.is_caught, self.colour[:, 1] / np.pi, self.colour[:, 1])

    def only(self, kept: np.ndarray) -> "_Splats":
        """Some of it. ``kept``: (m,) bool."""
        parts = [each[kept] for each in self.parts]
        return _Splats(
            self.x[kept],
            self.y[kept],
            self.colour[kept],
            self.pair[kept],
            parts,
            self.is_caught[kept],
        )

    def over(self, count: int) -> "_Splats":
        """The same with amounts over the number of paths."""
        parts = [each / count for each in self.parts[:4]] + self.parts[4:]
        return replace(self, colour=self.colour / count, parts=parts)


def _respond_by_catchers(respond, si, ray, is_caught):
    """As `respond_by`, where shadow catchers answer like what is white and matt."""
    side = dr.select(dr.dot(si.n, ray.d) < 0.0, 1.0, -1.0)

    def answer(direction, asked):
        value, density = respond(direction, asked)
        cosine = dr.maximum(dr.dot(direction, si.sh_frame.n) * side, 0.0)
        return dr.select(is_caught, mi.Spectrum(cosine * dr.inv_pi), value), density

    return answer


def _tent(away: np.ndarray) -> np.ndarray:
    """Pixel filter: as `picture._filter_offset` draws from it."""
    return np.maximum(1.0 - np.abs(away) / FILTER_RADIUS, 0.0) / FILTER_RADIUS


def _passed(scene, link, target, active):
    """Share of light that goes straight from a surface to the camera, as paths from there find it."""
    eye = dr.zeros(mi.SurfaceInteraction3f)
    eye.p, eye.wavelengths = link.start, target.wavelengths
    ray = spawn_ray_to(scene, eye, target.p, target.n)

    def step(ray, share, polar, on_way, steps):
        si = closest_hit(scene, ray, on_way, looks=mi.Bool(True))
        met = on_way & si.is_valid()
        passes = scene.bsdf(si, met).eval_null_transmission(si, met)
        is_hidden = mi.Bool(False)
        if scene.hidden is not None:
            number = dr.reinterpret_array(mi.UInt32, si.shape)
            is_hidden = dr.gather(mi.Bool, scene.hidden, number, met)
        factor, polar = polarise(scene, si, ray.d, ray.d, polar, mi.Bool(False), met & ~is_hidden)
        passes = dr.select(is_hidden, mi.Spectrum(1.0), passes * factor)
        share = dr.select(met, share * passes, share)
        # Each ray is aimed anew: by its own rounding it might meet the surface where it is to end.
        ray = dr.select(met, spawn_ray_to(scene, si, target.p, target.n), ray)
        goes_on = met & dr.any(share != 0.0)
        share = dr.select(goes_on & (steps >= MOST_PASSES), 0.0, share)
        return ray, share, polar, goes_on & (steps < MOST_PASSES), steps + 1

    _, share, _, _, _ = dr.while_loop(
        state=(ray, mi.Spectrum(1.0), mi.Vector3f(0.0), mi.Bool(active), mi.UInt32(0)),
        cond=lambda ray, share, polar, on_way, steps: on_way,
        body=step,
        labels=("ray", "share", "polar", "on_way", "steps"),
    )
    return dr.select(active, share, 0.0)
