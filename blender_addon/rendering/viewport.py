"""The rendered view of the 3D viewport: what is sent to the engine, and which of its frames are shown.

Everything here runs on Blender's main thread. The engine works in its own process; a timer looks for its frames.
"""

import itertools
import time
from dataclasses import dataclass

import bpy

from ...engine.errors import LumenrayError
from ...imports import loaded_when_used
from ..foundation import engine_process
from ..foundation.exposure import white_luminance
from ..foundation.redraw import areas
from . import light_mix
from .feed import SceneFeed

with loaded_when_used():
    from ...engine import kernel_cache
    from ...engine import views as engine_views
    from . import view_camera as view_cameras

POLL_INTERVAL = 0.02
"""How often the timer looks for frames. [s]"""

KEPT_FEEDS = 1
"""Feeds of views that were left which are kept, so that coming back costs only what changed since."""

_numbers = itertools.count(1)
_views: dict[int, "Viewport"] = {}
_idle: list[tuple[str, SceneFeed]] = []
"""Feeds that no view uses, by the name of what they show."""


@dataclass
class Status:
    """What a view tells about itself, for the panel."""

    message: str = ""
    is_error: bool = False
    changed: str = ""
    sent: int = 0
    walk: float = 0.0
    transfer: float = 0.0
    commit: float = 0.0
    first_sample: float = 0.0
    action: str = ""
    samples: int = 0
    error: float = float("inf")


def newest_status() -> Status | None:
    """Return the status of the view that was updated last, None without a view."""
    views = sorted(_views.values(), key=lambda view: view.touched)
    return views[-1].status if views else None


def view_at(region) -> "Viewport | None":
    """Return the view that is drawn in a region."""
    pointer = region.as_pointer()
    return next((view for view in _views.values() if view.region == pointer), None)


class Viewport:
    """One 3D view in rendered shading.

    A lost engine is started again by the next edit or the next turn of the view, not by itself: a scene that ends the
    engine would end it again and again.
    """

    def __init__(self):
        self.number = next(_numbers)
        self.region = 0
        self.touched = 0.0
        self.status = Status()
        self.size = (1, 1)
        self.frame: engine_views.Frame | None = None
        self.frame_number = 0
        self._feed: SceneFeed | None = None
        self._scene_key = None
        self._asked = None
        self._groups = ("NONE", ())
        self._kernels = kernel_cache.NewKernels()
        _views[self.number] = self
        _start_timer()

    def close(self) -> None:
        """Leave the view; its scene stays with the engine for a while."""
        _views.pop(self.number, None)
        self._release()

    def update(self, context, depsgraph) -> None:
        """Send what changed in the scene."""
        self.touched = time.perf_counter()
        try:
            feed = self._current_feed(context, depsgraph)
            edit = feed.update(depsgraph, _visible(context.space_data))
            self._find_groups(context.scene)
        except LumenrayError as error:
            self._fail(str(error))
            return
        if edit is not None:
            status = self.status
            status.message, status.is_error = "", False
            status.changed = edit.stats.changed
            status.sent = sum(edit.stats.sent.values()) + edit.stats.removed
            status.walk = edit.stats.walk_seconds
            status.transfer = edit.transfer_seconds
            _show_report(feed.report)

    def aim(self, context, depsgraph) -> None:
        """Ask the engine for the view as it is drawn now; nothing is sent when it is the same as before."""
        self.region = context.region.as_pointer()
        scene = context.scene
        if self._groups[0] != scene.lumenray.light_mix.groups:
            self._find_groups(scene)
        settings = live_settings(scene, self._groups[1])
        wanted = (
            view_cameras.view_camera(context, depsgraph),
            settings,
            display_of(scene),
        )
        if self._feed is not None and not self._feed.session.is_lost and wanted == self._asked:
            return
        if self._feed is None or self._feed.session.is_lost:
            if wanted == self._asked:
                return
            # The engine is gone or was never there: a turn of the view is an action that starts it.
            self._asked = wanted
            self.update(context, depsgraph)
            if self.status.is_error:
                return
        self._asked = wanted
        frame, settings, display = wanted
        self.touched = time.perf_counter()
        try:
            self._feed.session.watch(frame.camera, settings, display)
        except LumenrayError as error:
            self._fail(str(error))

    def _find_groups(self, scene) -> None:
        """Find the light groups that are to be kept apart, and have those listed that are new."""
        mode = scene.lumenray.light_mix.groups
        self._groups = (mode, ())
        if self._feed is None or mode == "NONE":
            return
        luminous = self._feed.sync.luminous
        try:
            groups = light_mix.groups_of(scene, luminous)
        except LumenrayError as error:
            self._fail(str(error))
            return
        self._groups = (mode, groups)
        names = light_mix.names_of(groups, luminous)
        if not light_mix.is_listed(scene, names):
            # Nothing may be written while Blender draws.
            uid = scene.session_uid
            bpy.app.timers.register(lambda: _list_rows(uid, names))

    def text(self) -> str:
        """One line for the corner of the view."""
        status = self.status
        if status.message:
            return status.message
        if self.frame is None:
            return f"Preparing, {self._kernels.words}…" if self._kernels.count else "Preparing…"
        parts = [f"{status.samples} samples" if status.samples else "coarse"]
        if status.error < 1e6:
            parts.append(f"error {100.0 * status.error:.1f} %")
        if self.frame.words:
            parts.append(self.frame.words)
        if self.frame.is_final:
            parts.append("done")
        return ", ".join(parts)

    def poll(self) -> bool:
        """Take over the engine's newest frame or complaint; true when there is something new to draw."""
        feed = self._feed
        if feed is None:
            return False
        complaint = feed.session.view_error()
        if complaint is not None and complaint != self.status.message:
            self._fail(complaint)
            return True
        frame = feed.session.frame()
        if frame is None:
            return self.frame is None and self._kernels.look()
        self.frame = frame
        self.frame_number += 1
        status = self.status
        if complaint is None:
            status.message, status.is_error = "", False
        status.samples, status.error = frame.samples, frame.relative_error
        status.commit, status.first_sample = (
            frame.commit.seconds,
            frame.commit.first_sample_seconds,
        )
        status.action = frame.commit.action
        return True

    def _current_feed(self, context, depsgraph) -> SceneFeed:
        """Return a feed for the scene that is shown, with the engine running."""
        key = _scene_key(context, depsgraph)
        if self._feed is not None and (self._feed.session.is_lost or key != self._scene_key):
            # Looked for first: what is released now may take the place of what is wanted.
            wanted = _take_idle(key)
            self._release()
            self._feed = wanted
            self._asked = None
        if self._feed is None:
            self._feed = _take_idle(key) or SceneFeed(
                engine_process.open_session(f"view {self.number} {key}")
            )
            self._asked = None
        self._scene_key = key
        return self._feed

    def _release(self) -> None:
        feed, self._feed = self._feed, None
        if feed is None or feed.session.is_lost:
            return
        feed.session.unwatch()
        feed.session.frame()
        _idle.append((self._scene_key, feed))
        while len(_idle) > KEPT_FEEDS:
            _idle.pop(0)[1].session.close()

    def _fail(self, message: str) -> None:
        self.status.message, self.status.is_error = message, True


def live_settings(scene, groups=()) -> "engine_views.LiveSettings":
    """Read what the scene's settings ask of a live view. ``groups``: light groups that are kept apart."""
    settings = scene.lumenray
    return engine_views.LiveSettings(
        samples=settings.viewport.samples,
        seed=settings.seed,
        transport=settings.transport.lower(),
        groups=groups,
        denoise=settings.viewport.use_denoising,
        method=settings.viewport.method.lower(),
    )


def display_of(scene) -> "engine_views.Display":
    """Read how the live view is shown."""
    view = scene.lumenray.viewport
    return engine_views.Display(
        mode=engine_views.DisplayMode[view.display],
        white=white_luminance(scene.lumenray),
        low=view.low,
        high=0.0 if view.automatic else view.high,
        logarithmic=view.logarithmic,
        mix=light_mix.levels_of(scene),
        lines=view.isolux_lines,
        values=view.use_values,
    )


def close_all() -> None:
    """Leave all views, for good."""
    for view in list(_views.values()):
        view.close()
    while _idle:
        _idle.pop()[1].session.close()
    if bpy.app.timers.is_registered(_pump):
        bpy.app.timers.unregister(_pump)


def _scene_key(context, depsgraph) -> str:
    """Name of what a view shows: views of the same scene and layer can hand their feed on to each other."""
    space = context.space_data
    is_own = space.local_view is not None or space.use_local_collections
    own = f" {space.as_pointer():x}" if is_own else ""
    scene, layer = depsgraph.scene.original, depsgraph.view_layer
    return f"{scene.session_uid} {layer.name}{own}"


def _visible(space):
    """Return the test for objects of a view with its own visibility, None where all see the same."""
    if space.local_view is None and not space.use_local_collections:
        return None

    def visible(instance) -> bool:
        source = instance.parent if instance.is_instance else instance.object
        # The evaluated object: Blender does not tell the original in which local views it is.
        return source is None or source.visible_in_viewport_get(space)

    return visible


def _take_idle(key: str) -> SceneFeed | None:
    _idle[:] = [entry for entry in _idle if not entry[1].session.is_lost]
    for entry in _idle:
        if entry[0] == key:
            _idle.remove(entry)
            return entry[1]
    return None


def _show_report(report) -> None:
    from ..feedback import show_report

    for manager in bpy.data.window_managers:
        show_report(manager, report)


def _list_rows(uid: int, names) -> None:
    for scene in bpy.data.scenes:
        if scene.session_uid == uid:
            light_mix.list_rows(scene, names)


# ---- timer ----


def _start_timer() -> None:
    if not bpy.app.timers.is_registered(_pump):
        bpy.app.timers.register(_pump, first_interval=POLL_INTERVAL, persistent=True)


def _pump():
    """Look for news of all views and draw those that have some."""
    if not _views:
        return None
    # A copy: views also leave when Python collects garbage, which may be while they are looked at.
    news = {view.region for view in list(_views.values()) if view.poll()}
    if news:
        for area in areas("VIEW_3D"):
            for region in area.regions:
                if region.as_pointer() in news or region.type == "UI":
                    region.tag_redraw()
    return POLL_INTERVAL


def detach():
    """Leave all views."""
    close_all()
