"""The live view of a session: how far it is, and when its next frame is worth showing."""

import time
from dataclasses import dataclass, fields, replace

import numpy as np

from .denoised_view import DenoisedView
from .scene.camera import Camera
from .scene.light_groups import share_out
from .scene.scene import Scene
from .views import Commit, Display, Frame, LiveSettings

FRAME_INTERVAL = 0.08
"""Shortest time between two frames. [s]"""

FRAME_SHARE = 0.25
"""Largest share of the time that is spent on making frames."""


@dataclass
class WatchedView:
    """The view that was asked for, and its state of work.

    Parameters
    ----------
    camera : Camera
    settings : LiveSettings
    display : Display
    work : transport.pictures.cell_view.CellView, that of groups, or None    None: it has not begun.
    denoised : DenoisedView or None    Its copy without noise; None: none is wanted.
    revision : int    State of the scene that it shows.
    is_shown : bool    Whether the last frame shows all that there is.
    shown_changes : int    How often its image had changed by then.
    shown_at : float    When that was made, by `time.perf_counter`. [s]
    frame_seconds : float    What making it took. [s]
    """

    camera: Camera
    settings: LiveSettings
    display: Display
    work: object = None
    denoised: DenoisedView | None = None
    revision: int = -1
    is_shown: bool = False
    shown_changes: int = -1
    shown_at: float = 0.0
    frame_seconds: float = 0.0

    def changed(self, camera: Camera, settings: LiveSettings, display: Display) -> "WatchedView":
        """Return what is wanted instead; only where another display is all that changes, the work goes on."""
        if self.settings == settings and _is_same_view(self.camera, camera):
            return replace(self, camera=camera, display=display, is_shown=False)
        self.leave()
        return WatchedView(camera, settings, display)

    def leave(self) -> None:
        """End what goes on beside it."""
        if self.denoised is not None:
            self.denoised.cancel()

    def has_begun(self, revision: int) -> bool:
        """Whether it works on this state of the scene."""
        return self.work is not None and self.revision == revision

    @property
    def is_done(self) -> bool:
        """Whether there is nothing left to compute nor to show."""
        return self.is_shown and self._is_complete

    @property
    def _is_complete(self) -> bool:
        return self.work.is_complete and not (
            self._shows_denoised and self.denoised.is_wanted(self.work)
        )

    @property
    def _shows_denoised(self) -> bool:
        """Whether a copy without noise may be shown: of pictures only, never of what is read as a number."""
        return self.denoised is not None and self.display.mode.is_looked_at

    def begin(self, compiled, scene: Scene, revision: int, kept) -> None:
        """Begin anew with a state of the scene. ``kept``: cells of the session, a `KeptCells`."""
        from .transport.paths.grouped_view import GroupedView
        from .transport.pictures.cell_view import CellView

        self.leave()
        self.revision, self.work, self.is_shown, self.denoised = revision, None, False, None
        self.shown_changes = -1
        shares = share_out(scene, self.settings.groups) if self.settings.groups else []
        if shares:
            self.work = GroupedView(compiled, shares, self.camera, self.settings)
            return
        compiled.shine()
        kept.begin()
        self.work = CellView(compiled, self.camera, self.settings, kept)
        if self.settings.denoise:
            self.denoised = DenoisedView(compiled, self.camera)

    def refine(self) -> bool:
        """Work for a moment; tell whether a better frame is worth its time."""
        has_copy = self._shows_denoised and self.denoised.refine(self.work)
        was_complete = self.work.is_complete
        is_pass_done = not was_complete and self.work.refine()
        waits = max(FRAME_INTERVAL, self.frame_seconds / FRAME_SHARE)
        is_due = not was_complete and time.perf_counter() - self.shown_at > waits
        is_due &= is_pass_done or self.work.factor == 1
        is_due &= self.work.changes != self.shown_changes
        is_last = self.work.is_complete and not was_complete
        return has_copy or is_last or is_due or not self.is_shown

    def frame(self, commit: Commit) -> Frame:
        """Make the frame of what there is."""
        from .analysis.display import show
        from .formats.luminance_picture import view_of_camera
        from .transport.paths.grouped_view import GroupedView

        start = time.perf_counter()
        if isinstance(self.work, GroupedView):
            image, error = self.work.mixed(self.display.mix)
        else:
            image, error = self.work.image(), self.work.error
        denoised = self.denoised if self._shows_denoised else None
        colour = None if denoised is None else denoised.colour
        words = (self.work.words, "" if denoised is None else denoised.words)
        frame = Frame(
            **show(
                image,
                self.display,
                colour,
                view_of_camera(self.camera),
                error,
                (self.camera.width, self.camera.height),
            ),
            revision=self.revision,
            samples=self.work.samples,
            relative_error=error,
            is_final=self._is_complete,
            commit=commit,
            words=", ".join(filter(None, words)),
        )
        self.is_shown, self.shown_at = True, time.perf_counter()
        self.shown_changes = self.work.changes
        self.frame_seconds = self.shown_at - start
        return frame


def _is_same_view(a: Camera, b: Camera) -> bool:
    return all(
        np.array_equal(getattr(a, entry.name), getattr(b, entry.name)) for entry in fields(Camera)
    )
