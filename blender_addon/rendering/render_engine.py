"""The render engine that Blender calls: F12, animation and the command line."""

import sys
import weakref
from pathlib import Path

import bpy
import gpu
import numpy as np
from bpy.app.handlers import persistent

from ...engine.accuracy.stopping import StopRule, format_seconds
from ...engine.analysis.noise_filter import smooth
from ...engine.errors import Cancelled, LumenrayError
from ...engine.photometry.colour import automatic_white, scene_linear
from ...engine.session import ViewSettings
from .. import assumptions, readout
from ..feedback import show_render, show_report
from ..foundation import engine_process
from ..foundation.exposure import white_luminance
from ..foundation.report import ConversionReport
from ..sync.camera import region
from . import view_drawing
from .feed import SceneFeed
from .viewport import Viewport

PASSES = (
    ("Combined", "RGBA", "COLOR"),
    ("Depth", "Z", "VALUE"),
    ("Normal", "XYZ", "VECTOR"),
    ("IndexOB", "X", "VALUE"),
    ("IndexMA", "X", "VALUE"),
    ("Luminance", "X", "VALUE"),
    ("Illuminance", "X", "VALUE"),
)
"""Name, channels and kind of every pass that we can deliver."""


PREVIEW_INTERVAL = 1.0
"""Shortest time between two previews; each copies the whole picture. [s]"""

OWN_PASSES = ("Luminance", "Illuminance")
"""Passes that Blender does not know by itself; they are added to every result."""


def view_settings(scene, spectral_file: str | None = None) -> ViewSettings:
    """Read what a scene's settings ask of a picture. ``spectral_file``: where its bands are written."""
    settings = scene.lumenray
    return ViewSettings(
        rule=stop_rule(settings.stop, settings.samples, settings.error, settings.time),
        seed=settings.seed,
        illuminance=settings.use_pass_illuminance,
        bands=settings.spectral_bands if settings.use_spectral_file else 0,
        transport=settings.transport.lower(),
        spectral_file=spectral_file,
        transparent=scene.render.film_transparent,
    )


def stop_rule(kind: str, samples: int, error: float, seconds: float) -> StopRule:
    """Rule from an enum and the three values it chooses from."""
    if kind == "ERROR":
        return StopRule(error=error)
    if kind == "TIME":
        return StopRule(seconds=seconds)
    return StopRule(samples=samples)


def wanted_passes(scene, view_layer) -> set[str]:
    """Names of the passes that the user asked for."""
    chosen = {
        "Combined": True,
        "Depth": view_layer.use_pass_z,
        "Normal": view_layer.use_pass_normal,
        "IndexOB": view_layer.use_pass_object_index,
        "IndexMA": view_layer.use_pass_material_index,
        "Luminance": scene.lumenray.use_pass_luminance,
        "Illuminance": scene.lumenray.use_pass_illuminance,
    }
    return {name for name, wanted in chosen.items() if wanted}


def shown_light(picture) -> np.ndarray:
    """Return X, Y, Z of what a picture shows: without surroundings where its film is transparent. (h, w, 3) [cd/m2]"""
    if picture.backdrop is None:
        return picture.tristimulus
    return np.maximum(picture.tristimulus - picture.backdrop, 0.0)


def picture_layers(picture, white: float | None, smoothed: bool = False) -> dict[str, np.ndarray]:
    """Name the layers of a `Picture` as passes, (h, w, c) float32. ``white`` None: found from the picture."""
    if white is None:
        white = automatic_white(picture.tristimulus[..., 1])
    combined = np.ones((*picture.depth.shape, 4), dtype=np.float32)
    combined[..., :3] = scene_linear(shown_light(picture), white)
    if picture.coverage is not None:
        combined[..., 3] = picture.coverage
    if smoothed:
        error = picture.luminance_error / white
        combined[..., :3] = smooth(
            combined[..., :3], error, picture.normal, picture.depth, picture.albedo
        )
    layers = {
        "Combined": combined,
        "Depth": picture.depth[..., None],
        "Normal": picture.normal,
        "IndexOB": picture.object_index[..., None],
        "IndexMA": picture.material_index[..., None],
        "Luminance": picture.tristimulus[..., 1:2],
    }
    if picture.illuminance is not None:
        layers["Illuminance"] = picture.illuminance[..., None]
    return layers


class LumenrayRenderEngine(bpy.types.RenderEngine):
    """Renders frames, on the thread that Blender chooses, and draws 3D views in rendered shading, on the main one.

    Blender makes one for every render and for every such view.
    """

    bl_idname = "LUMENRAY"
    bl_label = "Lumenray"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True  # of material preview

    _view = None

    def update_render_passes(self, scene, view_layer):
        """Tell Blender which passes there will be, for the compositor."""
        wanted = wanted_passes(scene, view_layer)
        for name, channels, kind in PASSES:
            if name in wanted:
                self.register_pass(scene, view_layer, name, len(channels), channels, kind)

    def render(self, depsgraph):
        """Render the current frame; faults become one sentence in Blender's report."""
        try:
            self._render(depsgraph)
        except Cancelled:
            self.update_stats("", "Cancelled")
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            self.error_set(str(error))
        finally:
            if not self.is_animation:
                close_final_feed()

    def _render(self, depsgraph):
        scene = depsgraph.scene
        self.update_stats("", "Converting the scene")
        feed = _final_feed()
        feed.update(depsgraph)
        report = ConversionReport()
        report.include(feed.report)
        camera = feed.sync.camera(depsgraph, report)
        _on_main_thread(lambda manager: show_report(manager, report))
        if bpy.app.background:
            assumptions.tell(report, stream=sys.stdout)
        if camera is None:
            self.error_set("The scene has no camera: add one and make it active")
            return
        session = feed.session
        self.update_stats("", "Preparing")
        white = white_luminance(scene.lumenray)
        wanted = wanted_passes(scene, depsgraph.view_layer_eval)
        left, low, width, height = region(scene.render)
        crop = scene.render.use_border and scene.render.use_crop_to_border
        place = (0, 0, width, height) if crop else (left, low, width, height)
        for name, channels, _ in PASSES:
            if name in wanted and name in OWN_PASSES:
                self.add_pass(name, len(channels), channels, layer=depsgraph.view_layer_eval.name)
        result = self.begin_result(*place, layer=depsgraph.view_layer_eval.name)
        asked = view_settings(scene, _spectral_path(scene))
        finished = False
        try:
            picture = session.render(
                camera,
                asked,
                self._follow(session, result, white),
                preview_interval=PREVIEW_INTERVAL,
                idle=lambda: self.test_break() and session.cancel(),
            )
            finished = True
        finally:
            # An abandoned result must be handed back too, else Blender waits for it.
            self.end_result(result, cancel=not finished)
        layers = picture_layers(picture, white, scene.lumenray.use_smoothing)
        self._deliver(place, depsgraph.view_layer_eval.name, layers, wanted)
        text = describe_picture(picture, report)
        # Into the file's metadata, beside the pixels.
        self.get_result().stamp_data_add_field("Lumenray", text)
        shortfall = asked.rule.shortfall(picture.relative_error)
        self._write_beside(scene, picture, report, shortfall)
        if bpy.app.background:
            notes = picture.provenance.notes
            assumptions.tell(ConversionReport(), notes, shortfall, stream=sys.stdout)
        self.update_stats("", text)
        _on_main_thread(lambda manager: show_render(manager, text))

    def _follow(self, session, result, white):
        """Return the function that follows the engine's progress."""

        def follow(progress, preview):
            if self.test_break():
                session.cancel()
            self.update_progress(progress.done)
            self.update_stats("", progress.text())
            if preview is not None and progress.done < 1.0:
                tristimulus = preview()
                shown = np.ones((*tristimulus.shape[:2], 4), dtype=np.float32)
                shown[..., :3] = scene_linear(
                    tristimulus, white or automatic_white(tristimulus[..., 1])
                )
                _fill(result.layers[0].passes["Combined"], shown)
                self.update_result(result)

        return follow

    def _deliver(self, place, layer_name, layers, wanted):
        result = self.begin_result(*place, layer=layer_name)
        passes = result.layers[0].passes
        for name, _, _ in PASSES:
            if name in wanted and name in layers:
                target = passes.get(name)
                if target is None:
                    self.report({"WARNING"}, f"Blender offers no pass named {name}")
                    continue
                _fill(target, layers[name])
        self.end_result(result)

    def _write_beside(self, scene, picture, report, shortfall):
        """Write the conversion report and a missed goal, which the picture file itself cannot hold."""
        path = Path(scene.render.frame_path(frame=scene.frame_current)).with_suffix("")
        to_disk = bpy.app.background or self.is_animation
        if to_disk and (report.rows or shortfall):
            from ...engine.formats.report import compose, write_json

            content = compose(
                bpy.data.filepath,
                picture.provenance,
                picture.provenance.seconds,
                [],
                report.to_dicts(),
                shortfall,
            )
            write_json(path.with_name(path.name + "_report.json"), content)

    # ---- 3D view ----

    def view_update(self, context, depsgraph):
        """Send what changed; Blender calls it after every evaluation that concerns the view."""
        self._viewport().update(context, depsgraph)

    def view_draw(self, context, depsgraph):
        """Draw the newest frame, and ask for others if the view has turned."""
        view = self._viewport()
        view.aim(context, depsgraph)
        view.size = (context.region.width, context.region.height)
        scene = depsgraph.scene
        gpu.state.blend_set("ALPHA_PREMULT")
        self.bind_display_space_shader(scene)
        view_drawing.draw_frame(view)
        self.unbind_display_space_shader()
        gpu.state.blend_set("NONE")
        self.update_stats("Lumenray", view.text())

    def _viewport(self):
        if self._view is None:
            self._view = Viewport()
            # Blender drops the engine when shading or file change; it cannot be asked for anything then.
            weakref.finalize(self, _leave, self._view).atexit = False
        return self._view


def _leave(view) -> None:
    view_drawing.forget(view)
    view.close()


_final: SceneFeed | None = None


def _final_feed() -> SceneFeed:
    """Return the feed of renders; frames of an animation share one, so that each sends only what moves."""
    global _final  # noqa: PLW0603 - one render runs at a time
    if _final is None or _final.session.is_lost:
        _final = SceneFeed(engine_process.open_session("render"), final=True)
    return _final


def close_final_feed(*_) -> None:
    """Let the engine forget the scene of renders."""
    global _final
    feed, _final = _final, None
    if feed is not None:
        feed.session.close()


def _spectral_path(scene) -> str | None:
    """Where the bands of a picture go, None when none are wanted."""
    if not scene.lumenray.use_spectral_file:
        return None
    path = Path(scene.render.frame_path(frame=scene.frame_current)).with_suffix("")
    return str(path.with_name(path.name + "_spectral.exr"))


def _fill(render_pass, values):
    render_pass.rect.foreach_set(np.ascontiguousarray(values, dtype=np.float32).reshape(-1))


def describe_picture(picture, report: ConversionReport) -> str:
    """Say how well a picture is known, and how much of its scene is not as Blender has it."""
    made = picture.provenance
    parts = [
        f"{made.samples} samples",
        f"error {readout.format_error(picture.relative_error)}",
        format_seconds(made.seconds),
    ]
    counts = readout.describe_counts(row.severity.name for row, _ in report.rows)
    return ", ".join([*parts, counts] if counts else parts)


def _on_main_thread(tell) -> None:
    """Call a function with every window manager, which panels read; a render without a window has no thread of its own."""

    def call():
        for manager in bpy.data.window_managers:
            tell(manager)

    if bpy.app.background:
        call()
    else:
        # Blender renders on a thread of its own; the window's data belong to the main thread.
        bpy.app.timers.register(call)


@persistent
def _rendered(*_):
    close_final_feed()


def attach():
    """Listen for the ends of animations."""
    for handlers in (bpy.app.handlers.render_complete, bpy.app.handlers.render_cancel):
        if _rendered not in handlers:
            handlers.append(_rendered)


def detach():
    """Listen no longer."""
    for handlers in (bpy.app.handlers.render_complete, bpy.app.handlers.render_cancel):
        if _rendered in handlers:
            handlers.remove(_rendered)
    close_final_feed()


CLASSES = (LumenrayRenderEngine,)
