"""The live view: one camera, refined slice by slice, coarse at first."""

import time
from dataclasses import replace
from types import SimpleNamespace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...accuracy.estimate import relative_error
from ...errors import SceneError
from ...scene.camera import Camera
from ..compiled.compile import CompiledScene
from . import gather
from .channels import Channels
from .film import GROUPS, MAXIMUM_PIXELS, Film, learn_lights, sees
from .lost_samples import LostSamples
from .path_loop import trace
from .sampler import hash_words, random_stream

FIRST_PIXELS = 4096
"""Most pixels of the first image, which is made in one slice."""

SHORT_SLICE, LONG_SLICE = 0.015, 0.1
"""Duration that slices of work are cut to, at first and later: an edit is often followed by the next at once. [s]"""

CALM = 2.0
"""Time after which slices are long. [s]"""

PILOT_LANES = 1 << 15
"""Shadow rays for the comparison of the lights."""

SMALLEST_SLICE, LARGEST_SLICE = 1 << 10, 1 << 18
"""Paths in a slice."""


class LiveView:
    """Progressive picture of a camera: a ladder of coarse images, then samples upon samples.

    Every step traces an even and an odd path for a range of pixels. Pixels that a finer image does not have yet show the
    coarser one.

    Parameters
    ----------
    scene : CompiledScene
    camera : Camera    Of the whole view.
    settings : LiveSettings
    keeps_caught : bool    As of `Channels`.

    Attributes
    ----------
    changes : int    How often the image has changed.
    words : str    What a frame says of how its light was found, for people; empty: there is nothing to say.
    """

    words = ""

    def __init__(self, scene: CompiledScene, camera: Camera, settings, keeps_caught=False):
        pixels = camera.width * camera.height
        if camera.width < 1 or camera.height < 1 or pixels > MAXIMUM_PIXELS:
            raise SceneError(f"a view of {camera.width} x {camera.height} pixels cannot be shown")
        self.scene, self.camera, self.settings = scene, camera, settings
        self.factor, self._keeps_caught = 1, keeps_caught
        while pixels / self.factor**2 > FIRST_PIXELS:
            self.factor *= 2
        scene.lights.reset()
        self._has_learned = False
        self._begun = time.perf_counter()
        self._slice = FIRST_PIXELS * GROUPS
        self._has_coarser = False
        self.changes = 0
        self.error = float("inf")
        self._begin_level()

    @property
    def samples(self) -> int:
        """Samples of every pixel of the finest image, 0 while it is coarse."""
        return int(self._passes * GROUPS) if self.factor == 1 else 0

    @property
    def is_complete(self) -> bool:
        """Whether all samples were taken."""
        return self.factor == 1 and self.samples >= self.settings.samples

    def refine(self) -> bool:
        """Take one slice of samples; true when a pass over the image was finished."""
        has_image = self._has_coarser or self._passes > 0
        if self.factor == 1 and has_image and not self._has_learned:
            # Only the finest image is worth the time that it takes.
            learn_lights(self.scene, self._film, PILOT_LANES)
            self._has_learned = True
            return False
        start = time.perf_counter()
        count = min(self._slice // GROUPS, self._pixels - self._cursor)
        new = self._sample(self._cursor, count)
        part = slice(self._cursor, self._cursor + count)
        self._sums[:, part] += new
        # The image is kept up to date slice by slice: making it anew for every frame would hold up edits.
        means = self._channels.composed(self._sums[:, part] / (self._passes + 1))
        self._image[part] = means.mean(axis=0)
        self._cursor += count
        self.changes += 1
        seconds = time.perf_counter() - start
        self._slice = self._adapted(self._slice, count * GROUPS, seconds)
        if self._cursor < self._pixels:
            return False
        self._finish_pass()
        return True

    def image(self) -> np.ndarray:
        """Return what is known: X, Y, Z and, if wanted, illuminance; not to be kept. (h, w, c) float32 [cd/m2, lx]"""
        return self._image.reshape(self._camera.height, self._camera.width, -1)

    @property
    def caught_layout(self):
        """`CaughtLayout` of what is known of shadow catchers, None without any."""
        catchers = self._channels.catchers
        return None if catchers is None else catchers.layout

    @property
    def caught_columns(self) -> slice:
        """Columns of the image that hold it."""
        return self._channels.caught_columns

    def caught_halves(self) -> np.ndarray | None:
        """These of both halves at the end of a pass over the finest image. (2, n, count)"""
        return self._channels.caught(self._sums / self._passes)

    def luminance_error(self) -> np.ndarray:
        """Standard error of the luminance at the end of a pass over the finest image. (h, w) float32 [cd/m2]"""
        halves = self._channels.composed(self._sums / self._passes)[..., 1]
        error = 0.5 * np.abs(halves[0] - halves[1])
        return error.reshape(self._camera.height, self._camera.width).astype(np.float32)

    # ---- private ----

    def _adapted(self, last: int, paths: int, seconds: float, least: int = SMALLEST_SLICE) -> int:
        """Paths of the next slice, so that it takes about as long as slices should.

        ``last``: of the slice before, ``paths``: what of it there was to do.
        """
        share = min((time.perf_counter() - self._begun) / CALM, 1.0)
        goal = SHORT_SLICE + (LONG_SLICE - SHORT_SLICE) * share
        wanted = paths * goal / max(seconds, 1e-4)
        bounded = np.clip(wanted, 0.25 * last, 4.0 * last)
        return int(np.clip(bounded, least, LARGEST_SLICE))

    def _begin_level(self) -> None:
        self._camera = replace(
            self.camera,
            width=max(-(-self.camera.width // self.factor), 1),
            height=max(-(-self.camera.height // self.factor), 1),
        )
        self._pixels = self._camera.width * self._camera.height
        self._film = Film(self._camera, self.scene.origin)
        self._channels = Channels(self.scene, _wanted(self.settings), self._keeps_caught)
        self._sums = np.zeros((GROUPS, self._pixels, self._channels.count))
        self._image = np.zeros((self._pixels, self._channels.count), dtype=np.float32)
        self._cursor = self._passes = 0

    def _sample(self, first: int, count: int) -> np.ndarray:
        """Follow an even and an odd path of each of a range of pixels. (2, count, channels)"""
        seed = dr.opaque(mi.UInt32, int(self.settings.seed) & 0xFFFFFFFF)
        lane = dr.arange(mi.UInt32, count * GROUPS)
        sample = dr.opaque(mi.UInt32, self._passes)
        pixel = dr.opaque(mi.UInt32, first) + lane // GROUPS
        own = hash_words(pixel, hash_words(lane % GROUPS, seed))
        wavelengths = gather.draw_wavelengths(self._channels.sampler, sample, own)
        ray = self._film.ray_of(pixel, sample, own)
        radiance = trace(
            self.scene,
            ray,
            wavelengths,
            random_stream(sample, own),
            mi.Float(0.0),
            ray.o,
            sees(ray),
            first=gather.first_points(sample, own),
            pixel_width=self._film.pixel_width,
        )
        lost = LostSamples(1)
        none = mi.UInt32(0)
        radiance = mi.Spectrum(*lost.keep(radiance, none))
        columns = self._channels.of_light(radiance, wavelengths)
        columns |= self._channels.of_view(ray, wavelengths, sample, own, none, lost)
        dr.eval(columns)
        made = np.zeros((count * GROUPS, self._channels.count))
        for number, column in columns.items():
            made[:, number] = np.array(column)
        return made.reshape(count, GROUPS, -1).transpose(1, 0, 2)

    def _finish_pass(self) -> None:
        self._cursor = 0
        self._passes += 1
        if self.factor == 1:
            means = self._channels.composed(self._sums / self._passes)[..., 1]
            self.error = relative_error(means.mean(axis=0), 0.5 * np.abs(means[0] - means[1]))
            return
        self._refine_level()

    def _refine_level(self) -> None:
        """Go on with twice the pixels across."""
        coarse = self.image()
        self.factor //= 2
        self._begin_level()
        size = (self._camera.height, self._camera.width)
        self._image[:] = enlarge(coarse, size).reshape(self._pixels, -1)
        self._has_coarser = True


def _wanted(settings):
    """What the view tells of its pixels, as `Channels` is asked."""
    return SimpleNamespace(illuminance=settings.illuminance, bands=0, transparent=False)


def enlarge(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Repeat pixels twice in both directions and cut to size."""
    return image.repeat(2, axis=0).repeat(2, axis=1)[: size[0], : size[1]]
