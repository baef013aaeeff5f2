"""Shadow catchers: what is behind everything, seen through a surface that shows but the shadows of what stands on it.

What a pixel shows of it is the light behind times E_s / E: the illuminance of the surface with all that stands there over
that by lamps, suns and world alone. Both come of the same samples, so they are equal where nothing stands in the way,
however few the samples are. Light that objects throw there counts in E_s. Catchers themselves shade each other in both, and
what they throw on each other counts in neither: the picture behind them holds it.

References
----------
A. Voloboy: Software technologies that automate the making of realistic images, dissertation, Moscow 2012, 1.4.2.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import average, table_size, upload
from ...photometry.colour import XYZ_TO_REC709
from ...scene.sensor import SensorKind
from ..rays import spawn_ray, spawn_ray_to, spawn_straight
from . import gather
from .film import GROUPS, sees
from .next_event import mirrored_light, sample_numbered_emitter
from .path_loop import trace
from .sampler import hash_words, random_stream, sobol_pair
from .spotted_light import spotted_light
from .visibility import closest_hit, transmittance

LONGEST_WAY = 1000
"""Surfaces that a ray is followed through."""

NO_DENSITY = 1e-20
"""Density of rays beside which next-event counts all that it can find; not 0, which says that it finds nothing. [sr-1]"""

BEHIND, SHARE, SHADED, OPEN, SQUARES = slice(0, 3), 3, slice(4, 7), slice(7, 10), slice(10, 14)
"""Columns: X, Y, Z behind catchers; share of rays that meet one; X, Y, Z of the illuminance with and without what stands
there; means of the products of both, and of the square of the luminance behind, to tell how much they scatter."""

COUNT = 14


class Catchers:
    """What a picture knows of its shadow catchers, as columns of `Channels`.

    Parameters
    ----------
    scene : CompiledScene    With catchers.
    colour : callable    ``colour(radiance, wavelengths)`` gives X, Y, Z.
    bands : callable    ``bands(radiance, wavelengths)`` gives the light of bands.
    band_count : int
    """

    def __init__(self, scene, colour, bands, band_count: int):
        self._scene, self._colour, self._bands = scene, colour, bands
        self._band_count, self.count = band_count, COUNT + band_count
        lamps = {id(source) for source in scene.sources().values()}
        sources = scene.lights.sources
        # What glows of the objects is one of them, and no lamp that shines without them.
        is_lamp = np.zeros(table_size(max(len(sources), 1)), dtype=bool)
        is_lamp[: len(sources)] = [s.centre is None or id(s) in lamps for s in sources]
        self._is_lamp = upload(mi.Bool, is_lamp)
        dr.eval(self._is_lamp)

    # ---- inside kernels ----

    def of_view(self, ray, wavelengths, sample, seed) -> list:
        """Columns of rays of the camera."""
        scene = self._scene
        si, share, met = self._meet(ray, wavelengths)
        behind = mi.Spectrum(0.0)
        if scene.backdrop is not None:
            away = dr.zeros(mi.SurfaceInteraction3f)
            away.wi, away.p = -ray.d, ray.o
            if wavelengths is not None:
                away.wavelengths = wavelengths
            behind = dr.select(met, share * scene.backdrop.eval(away, met), 0.0)
        faces = dr.dot(si.n, ray.d) < 0.0
        side = dr.select(faces, 1.0, -1.0)
        at = gather.receiver(
            si.p, si.sh_frame.n * side, si.n * side, wavelengths, scene.extent_at(si)
        )
        stream = random_stream(sample, hash_words(seed, mi.UInt32(2)))
        light_sample = sobol_pair(sample, seed, gather.PAIR_LIGHT)
        shaded, open_light = self._with_and_without(at, stream, light_sample, met)
        scatter_sample = sobol_pair(sample, seed, gather.PAIR_SCATTER)
        thrown = self._thrown(at, wavelengths, stream, scatter_sample, met)
        weight = average(share)
        with_all, without = (
            [dr.select(met, each * weight, 0.0) for each in self._colour(value, wavelengths)]
            for value in (shaded + thrown, open_light)
        )
        y, y_open = with_all[1], without[1]
        colours = self._colour(behind, wavelengths)
        made = [
            *colours,
            dr.select(met, weight, 0.0),
            *with_all,
            *without,
            dr.square(y),
            y * y_open,
            dr.square(y_open),
            dr.square(colours[1]),
            *(self._bands(behind, wavelengths) if self._band_count else ()),
        ]
        # No sample that is no number may take the others with it.
        return [dr.select(dr.isfinite(each), each, 0.0) for each in made]

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

    def _thrown(self, at, wavelengths, stream, scatter_sample, active):
        """Illuminance by light that objects throw on a place, caustics aside.

        Light over bends is left out of paths by whoever answers for it; here nobody does, as caustics would be specks.
        """
        scene, answer = self._scene, _answer_at(at)
        total = mi.Spectrum(0.0)
        if scene.mirrors is not None and scene.lights.count:
            sample = mi.Point2f(stream.next_float32(), stream.next_float32())
            total += mirrored_light(scene, at, sample, stream, answer, active)
        if scene.spots is not None and scene.lights.count:
            total += spotted_light(scene, at, stream, answer, active)
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

    # ---- of means ----

    def shade(self, halves: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What is seen of catchers, by the means of both halves.

        Parameters
        ----------
        halves : (2, n, count) array

        Returns
        -------
        (2, n, 3), (2, n, bands) and (2, n) arrays
            X, Y, Z and bands of what is behind, shaded [cd/m2, W/(m2 sr nm)]; the share of pixels that stays open, which is
            that of all catchers where nothing is shaded. The means of both are those of all samples together.
        """
        pooled = self._shade(halves.mean(axis=0, keepdims=True))
        own = self._shade(halves)
        return tuple(
            each + (of_all - each.mean(axis=0)) for each, of_all in zip(own, pooled, strict=True)
        )

    def _shade(self, means: np.ndarray):
        means = means.astype(np.float64)
        behind, shaded, open_light = means[..., BEHIND], means[..., SHADED], means[..., OPEN]
        ratio = _ratio(shaded[..., 1], open_light[..., 1])
        by_colour = _ratio(*(each @ XYZ_TO_REC709.T for each in (shaded, open_light)), ratio)
        seen = ((behind @ XYZ_TO_REC709.T) * by_colour) @ np.linalg.inv(XYZ_TO_REC709).T
        bands = means[..., COUNT:] * ratio[..., None]
        return seen, bands, means[..., SHARE] * np.minimum(ratio, 1.0)

    def scatter(self, means: np.ndarray, counts: np.ndarray, white: float) -> np.ndarray:
        """Variance of the luminance that is seen of catchers.

        Parameters
        ----------
        means : (2, n, count) array
        counts : (n,) array    Samples in a half.
        white : float    Luminance that their alpha stands for, 0 where it is not wanted. [cd/m2]

        Returns
        -------
        (2, n) array    [cd2/m4]
        """
        whole = means.mean(axis=0, dtype=np.float64)
        open_light = whole[:, OPEN][:, 1]
        ratio = _ratio(whole[:, SHADED][:, 1], open_light)
        squares = np.moveaxis(means[..., SQUARES].astype(np.float64), -1, 0)
        with_all, both, without, behind = squares
        around = np.maximum(with_all - 2.0 * ratio * both + ratio**2 * without, 0.0)
        behind = np.maximum(behind - means[..., BEHIND][..., 1].astype(np.float64) ** 2, 0.0)
        amount = np.maximum(whole[:, BEHIND][:, 1], white * whole[:, SHARE])
        relative = np.divide(amount, open_light, out=np.zeros(len(amount)), where=open_light > 0.0)
        scatter = around * relative**2 + ratio**2 * behind
        return scatter / (GROUPS * np.maximum(counts - 1, 1))


def _answer_at(at):
    """How a matt surface answers light, for `next_event` and the like, which shares none of it with scattered rays."""
    respond = gather.response_of(SensorKind.PLANAR, at)
    return lambda direction, asked: (respond(direction), mi.Float(0.0))


def _ratio(part: np.ndarray, whole: np.ndarray, otherwise=1.0) -> np.ndarray:
    """Part over whole, not below 0; where there is no whole what stands for it: (...) or that of colours, (..., 3)."""
    if np.ndim(otherwise):
        otherwise = np.asarray(otherwise)[..., None]
    stands_for = np.broadcast_to(otherwise, whole.shape).copy()
    return np.maximum(np.divide(part, whole, out=stands_for, where=whole > 0.0), 0.0)
