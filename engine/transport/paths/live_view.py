"""The live view: one camera, refined slice by slice, coarse at first."""

import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from ...accuracy.stopping import StopRule
from ...errors import SceneError
from ...scene.camera import Camera
from ..compiled.compile import CompiledScene
from .picture import GROUPS, MAXIMUM_PIXELS, Film, PictureJob, learn_lights, relative_error

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
    """

    def __init__(self, scene: CompiledScene, camera: Camera, settings):
        pixels = camera.width * camera.height
        if camera.width < 1 or camera.height < 1 or pixels > MAXIMUM_PIXELS:
            raise SceneError(f"a view of {camera.width} x {camera.height} pixels cannot be shown")
        self.scene, self.camera, self.settings = scene, camera, settings
        self.factor = 1
        while pixels / self.factor**2 > FIRST_PIXELS:
            self.factor *= 2
        scene.lights.reset()
        self._has_learned = False
        self._begun = time.perf_counter()
        self._slice = FIRST_PIXELS * GROUPS
        self._has_coarser = False
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
        new = self._job.launch(self._cursor, count, 1, self._passes)
        part = slice(self._cursor, self._cursor + count)
        self._sums[:, part] += new
        # The image is kept up to date slice by slice: making it anew for every frame would hold up edits.
        self._image[part] = self._sums[:, part].sum(axis=0) / (GROUPS * (self._passes + 1))
        self._cursor += count
        self._adapt(count * GROUPS, time.perf_counter() - start)
        if self._cursor < self._pixels:
            return False
        self._finish_pass()
        return True

    def image(self) -> np.ndarray:
        """Return what is known: X, Y, Z and, if wanted, illuminance; not to be kept. (h, w, c) float32 [cd/m2, lx]"""
        return self._image.reshape(self._camera.height, self._camera.width, -1)

    # ---- private ----

    def _adapt(self, paths: int, seconds: float) -> None:
        """Let the next slice take about as long as slices should."""
        share = min((time.perf_counter() - self._begun) / CALM, 1.0)
        goal = SHORT_SLICE + (LONG_SLICE - SHORT_SLICE) * share
        wanted = paths * goal / max(seconds, 1e-4)
        bounded = np.clip(wanted, 0.25 * self._slice, 4.0 * self._slice)
        self._slice = int(np.clip(bounded, SMALLEST_SLICE, LARGEST_SLICE))

    def _begin_level(self) -> None:
        self._camera = replace(
            self.camera,
            width=max(-(-self.camera.width // self.factor), 1),
            height=max(-(-self.camera.height // self.factor), 1),
        )
        self._pixels = self._camera.width * self._camera.height
        self._film = Film(self._camera, self.scene.origin)
        self._job = PictureJob(self.scene, self._film, _view_settings(self.settings))
        self._sums = np.zeros((GROUPS, self._pixels, self._job.channels))
        self._image = np.zeros((self._pixels, self._job.channels), dtype=np.float32)
        self._cursor = self._passes = 0

    def _finish_pass(self) -> None:
        self._cursor = 0
        self._passes += 1
        if self.factor == 1:
            means = self._sums[..., 1] / self._passes
            self.error = relative_error(means.mean(axis=0), 0.5 * np.abs(means[0] - means[1]))
            return
        coarse = self.image()
        self.factor //= 2
        self._begin_level()
        size = (self._camera.height, self._camera.width)
        self._image[:] = _enlarge(coarse, size).reshape(self._pixels, -1)
        self._has_coarser = True


def _view_settings(settings):
    """Settings of the picture job whose launches the view uses."""
    return SimpleNamespace(
        rule=StopRule(samples=settings.samples),
        seed=settings.seed,
        illuminance=settings.illuminance,
        bands=0,
        transparent=False,
    )


def _enlarge(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Repeat pixels twice in both directions and cut to size."""
    return image.repeat(2, axis=0).repeat(2, axis=1)[: size[0], : size[1]]
