"""The denoised copy of a live view that rests: what is asked of it, how far it is, and what it shows.

Guides are traced slice by slice like the view itself, and the filter works in a process of its own, so that edits wait for
neither; both are given up as soon as the view changes.
"""

import time

import numpy as np

from .analysis.block_means import keep_means
from .analysis.denoiser import Denoising, find_denoiser
from .analysis.looking import WORDS
from .errors import LumenrayError
from .photometry.colour import scene_linear

REST = 1.0
"""How long a view has to stay the same. [s]"""

FEWEST = 4
"""Samples per pixel of the first copy; each of the next has twice those of the one before."""

GUIDE_SAMPLES = 2
"""Rays of a pixel for the guides."""

SLICE = 1 << 16
"""Rays of a slice of the guides."""

NAP = 0.02
"""How long is waited for a copy where nothing else is left to do. [s]"""


class DenoisedView:
    """Makes copies of the picture of a live view.

    Parameters
    ----------
    compiled : CompiledScene
    camera : Camera

    Attributes
    ----------
    colour : (h, w, 3) float32 array or None    The newest copy, linear Rec. 709, 1 at 1 cd/m2.
    samples : int    Of that.
    words : str    What a frame with it says of itself, or why there is none.
    """

    def __init__(self, compiled, camera):
        from .transport.paths.film import Film
        from .transport.paths.guides import GuideJob

        self.colour, self.samples, self.words = None, 0, ""
        self._guides = GuideJob(compiled, Film(camera, compiled.origin), GUIDE_SAMPLES)
        self._begun = time.perf_counter()
        self._task = self._raw = None
        self._task_samples = 0
        self._is_able = find_denoiser() is not None

    def is_wanted(self, work) -> bool:
        """Whether a better copy of a view is to come."""
        return self._is_able and (self._task is not None or self.samples < work.samples)

    def refine(self, work) -> bool:
        """Do something for the next copy of a `LiveView`, for a moment; tell whether there is news."""
        if not self._is_able:
            return False
        if self._task is not None:
            return self._task.wait(NAP if work.is_complete else 0.0) and self._take()
        goal = max(2 * self.samples, FEWEST)
        is_due = work.samples >= goal or (work.is_complete and work.samples > self.samples)
        if not is_due:
            return False
        if time.perf_counter() - self._begun < REST:
            if work.is_complete:
                time.sleep(NAP)
        elif not self._guides.is_complete:
            self._guides.refine(SLICE)
        else:
            self._begin(work)
        return not self._is_able

    def cancel(self) -> None:
        """Give up the copy that is being made."""
        if self._task is not None:
            self._task.cancel()
            self._task = None

    def _begin(self, work) -> None:
        guides = self._guides.layers()
        self._raw, self._task_samples = scene_linear(work.image()[..., :3], 1.0), work.samples
        try:
            self._task = Denoising(
                self._raw, guides["denoising_normal"], guides["denoising_albedo"], is_modest=True
            )
        except LumenrayError as error:
            self._give_up(error)

    def _take(self) -> bool:
        """Take the copy over, where it could be made; else the view stays as it is, and says so."""
        task, self._task = self._task, None
        try:
            self.colour = keep_means(task.result(), np.asarray(self._raw))
        except LumenrayError as error:
            self._give_up(error)
        else:
            self.samples, self.words = self._task_samples, WORDS
        return True

    def _give_up(self, error: LumenrayError) -> None:
        self._is_able, self.words = False, f"not denoised: {error}"
