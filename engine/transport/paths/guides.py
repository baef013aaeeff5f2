"""What guides the filters of noise: colours, directions and distances of what the camera sees, over the pixel's filter.

Panes, mirrors and clear glass show what is seen in them. Where a surface may send light either way, the guides follow what
it does most, so that a few rays a pixel are enough.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ..compiled.compile import CompiledScene
from ..compiled.textures import is_spectral
from ..rays import spawn_ray
from . import gather
from .film import sees
from .pixel_filter import filter_offset
from .sampler import hash_words, sobol_pair
from .visibility import closest_hit

SAMPLES = 8
"""Rays of a pixel of a picture."""

LANES = 1 << 21
"""Rays of a launch."""

LONGEST_WAY = 16
"""Surfaces that a ray is followed through; the last one is shown."""

COLOURS = (610.0, 550.0, 460.0)
"""Wavelengths that stand for red, green and blue. [nm]"""


def trace_guides(scene: CompiledScene, film) -> dict:
    """Return ``denoising_albedo``, ``denoising_normal`` and ``denoising_depth`` of `views.Picture`."""
    job = GuideJob(scene, film, SAMPLES)
    while not job.is_complete:
        job.refine()
    return job.layers()


class GuideJob:
    """Guides of a view, traced range by range.

    Parameters
    ----------
    scene : CompiledScene
    film : film.Film
    samples : int    Rays of a pixel, a power of two.
    """

    def __init__(self, scene: CompiledScene, film, samples: int):
        self._scene, self._film, self._samples = scene, film, samples
        self._pixels = film.camera.width * film.camera.height
        self._made = np.empty((self._pixels, 7), dtype=np.float32)
        self._done = 0

    @property
    def is_complete(self) -> bool:
        """Whether all pixels have theirs."""
        return self._done == self._pixels

    def refine(self, rays: int = LANES) -> None:
        """Trace the next pixels, by so many rays."""
        count = min(max(rays // self._samples, 1), self._pixels - self._done)
        self._made[self._done : self._done + count] = self._launch(count)
        self._done += count

    def layers(self) -> dict:
        """Fields of `views.Picture`, by name."""
        camera = self._film.camera
        made = self._made.reshape(camera.height, camera.width, 7)
        return {
            "denoising_albedo": made[..., :3],
            "denoising_normal": made[..., 3:6],
            "denoising_depth": made[..., 6],
        }

    def _launch(self, count: int) -> np.ndarray:
        """Means of albedo, normal and depth of the next pixels. (count, 7)"""
        film, samples = self._film, self._samples
        lane = dr.arange(mi.UInt32, count * samples)
        pixel = dr.opaque(mi.UInt32, self._done) + lane // samples
        sample, seed = lane % samples, hash_words(pixel, mi.UInt32(1))
        offset = filter_offset(sobol_pair(sample, seed, gather.PAIR_FILM))
        ray = film.ray(
            mi.Float(pixel % film.width) + 0.5 + offset.x,
            mi.Float(pixel // film.width) + 0.5 + offset.y,
            sobol_pair(sample, seed, gather.PAIR_LENS),
        )
        ends = _follow(self._scene, ray)
        columns = [dr.block_reduce(dr.ReduceOp.Add, c, samples) for c in ends]
        dr.eval(columns)
        return np.stack([np.array(c, dtype=np.float32) for c in columns], axis=-1) / samples


def _follow(scene, ray) -> list:
    """Albedo, normal and depth at the ends of rays."""
    ray = mi.Ray3f(ray)
    if is_spectral():
        ray.wavelengths = mi.Spectrum(*COLOURS, COLOURS[1])
    begins, middle = mi.Bool(True), mi.Point2f(0.5, 0.5)
    seen = sees(ray)

    def step(ray, share, albedo, normal, depth, begins, active, steps):
        si = closest_hit(scene, ray, active, looks=begins)
        met = active & si.is_valid()
        glows = met & (scene.emitter(si, met) != None)  # noqa: E711 - element-wise
        hidden = mi.Bool(False)
        if scene.hidden is not None:
            number = dr.reinterpret_array(mi.UInt32, si.shape)
            hidden = dr.gather(mi.Bool, scene.hidden, number, met & begins) & begins & met
        bsdf = scene.bsdf(si, met)
        # At the middle of its choices a surface does what it does most.
        bs, weight = bsdf.sample(mi.BSDFContext(), si, mi.Float(0.5), middle, met)
        lit = dr.any(weight != 0.0)
        spreads = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Smooth)
        goes_on = met & (hidden | (~glows & ~spreads & lit)) & (steps < LONGEST_WAY)
        ends = met & ~goes_on

        matt = ends & mi.has_flag(bsdf.flags(), mi.BSDFFlags.DiffuseReflection)
        own = dr.select(matt, bsdf.eval_diffuse_reflectance(si, matt), weight)
        own = dr.select(glows | ~(spreads & (matt | lit)), 1.0, dr.clip(own, 0.0, 1.0))
        if scene.catchers is not None:
            # They show what is behind everything.
            number = dr.reinterpret_array(mi.UInt32, si.shape)
            caught = dr.gather(mi.Bool, scene.catchers, number, met & begins) & begins
            own = dr.select(caught, 1.0, own)
        albedo = dr.select(ends, share * own, albedo)
        facing = dr.select(dr.dot(si.n, ray.d) < 0.0, 1.0, -1.0)
        normal = dr.select(ends, mi.Vector3f(si.sh_frame.n) * facing, normal)
        depth = dr.select(met, depth + si.t, depth)
        share = dr.select(goes_on & ~hidden, share * dr.clip(weight, 0.0, 1.0), share)
        straight = hidden | mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
        direction = dr.select(hidden, ray.d, si.to_world(bs.wo))
        begins &= straight
        left = dr.maximum(ray.maxt - si.t, 0.0)
        left = dr.select(straight, left, dr.largest(mi.Float))
        ray = dr.select(goes_on, spawn_ray(scene, si, direction), ray)
        ray.maxt = dr.select(goes_on, left, ray.maxt)
        # What leaves the scene has met nothing that could be told.
        depth = dr.select(active & ~si.is_valid(), 0.0, depth)
        return ray, share, albedo, normal, depth, begins, goes_on, steps + 1

    *_, albedo, normal, depth, _, _, _ = dr.while_loop(
        state=(
            ray,
            mi.Spectrum(1.0),
            mi.Spectrum(1.0),
            mi.Vector3f(0.0),
            mi.Float(0.0),
            begins,
            seen,
            mi.UInt32(0),
        ),
        cond=lambda ray, share, albedo, normal, depth, begins, active, steps: active,
        body=step,
        labels=("ray", "share", "albedo", "normal", "depth", "begins", "active", "steps"),
    )
    colours = [albedo[i] for i in range(3)] if is_spectral() else [albedo[0]] * 3
    return [*colours, normal.x, normal.y, normal.z, depth]
