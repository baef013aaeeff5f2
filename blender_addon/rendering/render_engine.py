"""The render engine that Blender calls: F12, animation and the command line."""

import sys
import weakref
from pathlib import Path

import bpy
import gpu
from bpy.app.handlers import persistent

from ...engine.errors import Cancelled, LumenrayError
from ...engine.requirements.budget import tell_parts
from ...imports import loaded_when_used
from .. import assumptions, readout
from ..feedback import show_render, show_report
from ..foundation import engine_process
from ..foundation.exposure import white_luminance
from ..foundation.handlers import leave, listen
from ..foundation.report import ConversionReport
from . import light_mix, preview, view_drawing
from .animation import Frames
from .feed import SceneFeed
from .viewport import Viewport

with loaded_when_used():
    import numpy as np

    from ...engine import views
    from ...engine.accuracy import stopping
    from ...engine.analysis import denoiser, looking
    from ...engine.photometry import colour
    from ..sync import camera as sync_camera
    from . import shutter as shutters

PASSES = (
    ("Combined", "RGBA", "COLOR"),
    ("Depth", "Z", "VALUE"),
    ("Normal", "XYZ", "VECTOR"),
    ("IndexOB", "X", "VALUE"),
    ("IndexMA", "X", "VALUE"),
    ("Luminance", "X", "VALUE"),
    ("Illuminance", "X", "VALUE"),
    ("Denoising Albedo", "RGB", "COLOR"),
    ("Denoising Normal", "XYZ", "VECTOR"),
    ("Denoising Depth", "Z", "VALUE"),
)
"""Name, channels and kind of every pass that we can deliver."""

GUIDES = ("Denoising Albedo", "Denoising Normal", "Denoising Depth")
"""Passes that guide filters of noise, as Cycles calls them."""

OWN_PASSES = ("Luminance", "Illuminance", *GUIDES)
"""Passes that Blender does not know by itself; they are added to every result."""


def view_settings(scene, spectral_file: str | None = None, luminous=()) -> "views.ViewSettings":
    """Read what a scene's settings ask of a picture.

    ``spectral_file``: where its bands are written; ``luminous``: as of `SceneSync.luminous`, what may be kept apart.
    """
    settings, own = scene.lumenray, scene.lumenray.render
    return views.ViewSettings(
        rule=stop_rule(own.stop, own.samples, own.error, own.time),
        seed=settings.seed,
        illuminance=own.use_pass_illuminance,
        bands=own.spectral_bands if own.use_spectral_file else 0,
        transport=settings.transport.lower(),
        spectral_file=spectral_file,
        transparent=scene.render.film_transparent,
        groups=light_mix.groups_of(scene, luminous),
        preview=light_mix.levels_of(scene),
        method=own.method.lower(),
        unbiased=own.use_unbiased,
        guides=own.use_pass_denoising
        or (own.use_denoising and denoiser.find_denoiser() is not None),
    )


def stop_rule(kind: str, samples: int, error: float, seconds: float) -> "stopping.StopRule":
    """Rule from an enum and the three values it chooses from."""
    if kind == "ERROR":
        return stopping.StopRule(error=error)
    if kind == "TIME":
        return stopping.StopRule(seconds=seconds)
    return stopping.StopRule(samples=samples)


def wanted_passes(scene, view_layer) -> set[str]:
    """Names of the passes that the user asked for."""
    chosen = {
        "Combined": True,
        "Depth": view_layer.use_pass_z,
        "Normal": view_layer.use_pass_normal,
        "IndexOB": view_layer.use_pass_object_index,
        "IndexMA": view_layer.use_pass_material_index,
        "Luminance": scene.lumenray.render.use_pass_luminance,
        "Illuminance": scene.lumenray.render.use_pass_illuminance,
        **dict.fromkeys(GUIDES, scene.lumenray.render.use_pass_denoising),
    }
    return {name for name, wanted in chosen.items() if wanted}


def shown_light(picture) -> "np.ndarray":
    """Return X, Y, Z of what a picture shows: without surroundings where its film is transparent. (h, w, 3) [cd/m2]"""
    if picture.backdrop is None:
        return picture.tristimulus
    return np.maximum(picture.tristimulus - picture.backdrop, 0.0)


def picture_layers(picture, white: float) -> "dict[str, np.ndarray]":
    """Name the layers of a `Picture` as passes, (h, w, c) float32. ``white``: luminance that becomes 1. [cd/m2]"""
    combined = np.ones((*picture.depth.shape, 4), dtype=np.float32)
    combined[..., :3] = colour.scene_linear(shown_light(picture), white)
    if picture.coverage is not None:
        combined[..., 3] = picture.coverage
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
    if picture.denoising_albedo is not None:
        depth = picture.denoising_depth[..., None]
        guides = picture.denoising_albedo, picture.denoising_normal, depth
        layers |= zip(GUIDES, guides, strict=True)
    return layers


class LumenrayRenderEngine(bpy.types.RenderEngine):
    """Renders frames, on the thread that Blender chooses, and draws 3D views in rendered shading, on the main one.

    Blender makes one for every render and for every such view.
    """

    bl_idname = "LUMENRAY"
    bl_label = "Lumenray"
    bl_use_preview = True
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
        for name in light_mix.pass_names(scene):
            self.register_pass(scene, view_layer, name, 4, "RGBA", "COLOR")

    def render(self, depsgraph):
        """Render the current frame; faults become one sentence in Blender's report."""
        try:
            if self.is_preview:
                preview.render_preview(self, depsgraph)
            else:
                self._render(depsgraph)
        except Cancelled:
            self.update_stats("", "Cancelled")
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            self.error_set(str(error))
        finally:
            if not self.is_animation and not self.is_preview:
                close_final_feed()

    def _render(self, depsgraph):
        scene = depsgraph.scene
        self.update_stats("", "Converting the scene")
        feed, shutter, camera, report = self._convert(depsgraph)
        _on_main_thread(lambda manager: show_report(manager, report))
        if bpy.app.background:
            assumptions.tell(report, stream=sys.stdout)
        if camera is None:
            self.error_set("The scene has no camera: add one and make it active")
            return
        self.update_stats("", "Preparing")
        white = white_luminance(scene.lumenray)
        wanted = wanted_passes(scene, depsgraph.view_layer_eval)
        # Where only a region is rendered Blender's result is that region, and Blender itself puts it into the frame.
        place = (0, 0, *sync_camera.region(scene.render)[2:])
        for name, channels, _ in PASSES:
            if name in wanted and name in OWN_PASSES:
                self.add_pass(name, len(channels), channels, layer=depsgraph.view_layer_eval.name)
        asked = view_settings(scene, _spectral_path(scene), feed.sync.luminous)
        result = self.begin_result(*place, layer=depsgraph.view_layer_eval.name)
        finished = False
        try:
            follow = self._follow(feed, scene, result, white)
            picture = self._take(depsgraph, feed, camera, asked, shutter, follow)
            finished = True
        finally:
            if shutter is not None:
                self.frame_set(*shutters.split_time(shutter.frame))
            # An abandoned result must be handed back too, else Blender waits for it.
            self.end_result(result, cancel=not finished)
        whole, (picture, told) = picture, light_mix.mix_picture(scene, picture)
        white = white or colour.automatic_white(picture.tristimulus[..., 1])
        layers = picture_layers(picture, white)
        of_groups = light_mix.group_layers(picture, white)
        for name in of_groups:
            self.add_pass(name, 4, "RGBA", layer=depsgraph.view_layer_eval.name)
        words = ""
        if scene.lumenray.render.use_denoising:
            words = self._filter(layers["Combined"], picture, camera)
        shown = {name: layers[name] for name in wanted if name in layers} | of_groups
        self._deliver(place, depsgraph.view_layer_eval.name, shown)
        text = describe_picture(picture, report, words, told)
        _stamp(self.get_result(), text, picture.provenance)
        shortfall = asked.rule.shortfall(whole.relative_error)
        self._write_beside(scene, picture, report, shortfall)
        if bpy.app.background:
            notes = picture.provenance.notes
            assumptions.tell(ConversionReport(), notes, shortfall, stream=sys.stdout)
        self.update_stats("", text)
        _on_main_thread(lambda manager: show_render(manager, text))
        _on_main_thread(lambda _, original=scene.original: light_mix.keep(original, whole))

    def _convert(self, depsgraph):
        """Give the scene to the engine; returns its feed, the shutter or None, the camera and the conversion report."""
        feed, report = _final_feed(depsgraph.scene), ConversionReport()
        shutter = shutters.shutter_of(depsgraph.scene, depsgraph.view_layer_eval)
        feed.sync.is_blurred = shutter is not None
        # What is not to be blurred stands as it does halfway, as in Cycles.
        is_apart = shutter is not None and shutter.middle != shutter.frame
        if is_apart:
            self.frame_set(*shutters.split_time(shutter.middle))
        try:
            feed.update(depsgraph)
            report.include(feed.report)
            camera = feed.sync.camera(depsgraph, report)
        finally:
            if is_apart:
                self.frame_set(*shutters.split_time(shutter.frame))
        return feed, shutter, camera, report

    def _take(self, depsgraph, feed, camera, asked, shutter, follow):
        """Render what the camera sees, or the mean over its open shutter."""
        session = feed.session

        def render(camera, settings, follow):
            def idle():
                return self.test_break() and session.cancel()

            return session.render(camera, settings, follow, idle=idle)

        if shutter is None:
            return render(camera, asked, follow)

        def go_to(time):
            if self.test_break():
                raise Cancelled("cancelled")
            self.frame_set(*shutters.split_time(time))
            return depsgraph

        return shutters.render_open_shutter(shutter, asked, feed, go_to, render, follow)

    def _follow(self, feed, scene, result, white):
        """Return the function that follows the engine's progress."""
        place = Frames.of(scene) if self.is_animation else None
        feed.frames.begin()

        def follow(progress, preview):
            if self.test_break():
                feed.session.cancel()
            self.update_progress(progress.done)
            text = progress.text() if place is None else feed.frames.describe(place, progress)
            self.update_stats("", text)
            if preview is not None and progress.done < 1.0:
                tristimulus = preview()
                shown = np.ones((*tristimulus.shape[:2], 4), dtype=np.float32)
                shown[..., :3] = colour.scene_linear(
                    tristimulus, white or colour.automatic_white(tristimulus[..., 1])
                )
                _fill(result.layers[0].passes["Combined"], shown)
                self.update_result(result)

        return follow

    def _filter(self, combined, picture, camera) -> str:
        """Filter the noise of what is shown, and say how."""
        self.update_stats("", "Denoising")
        made = looking.filter_noise(combined[..., :3], picture, camera.aperture_radius > 0.0)
        combined[..., :3] = made.colour
        if made.problem:
            self.report({"WARNING"}, made.problem)
        return made.words

    def _deliver(self, place, layer_name, layers):
        result = self.begin_result(*place, layer=layer_name)
        passes = result.layers[0].passes
        for name, values in layers.items():
            target = passes.get(name)
            if target is None:
                self.report({"WARNING"}, f"Blender offers no pass named {name}")
                continue
            _fill(target, values)
        self.end_result(result)

    def _write_beside(self, scene, picture, report, shortfall):
        """Write the conversion report and a missed goal, which the picture file itself cannot hold."""
        path = Path(scene.render.frame_path(frame=scene.frame_current)).with_suffix("")
        to_disk = bpy.app.background or self.is_animation
        if to_disk and (keeps_reports or report.rows or shortfall):
            from ...engine.formats.report import compose, quantity_of_picture, write_json

            content = compose(
                bpy.data.filepath,
                picture.provenance,
                picture.provenance.seconds,
                [quantity_of_picture(picture)],
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

keeps_reports = False
"""Whether every picture on disk has its report beside it, also where nothing is missing of it: farms make tables of them."""


def _final_feed(scene) -> SceneFeed:
    """Return the feed of renders; frames of an animation share one, so that each sends only what moves."""
    global _final  # noqa: PLW0603 - one render runs at a time
    session = engine_process.open_session("render", scene)
    if _final is None or _final.session is not session:
        _final = SceneFeed(session, final=True)
    return _final


def close_final_feed(*_) -> None:
    """Let the engine forget the scene of renders."""
    global _final
    feed, _final = _final, None
    if feed is not None:
        feed.session.close()


def _spectral_path(scene) -> str | None:
    """Where the bands of a picture go, None when none are wanted."""
    if not scene.lumenray.render.use_spectral_file:
        return None
    path = Path(scene.render.frame_path(frame=scene.frame_current)).with_suffix("")
    return str(path.with_name(path.name + "_spectral.exr"))


def _fill(render_pass, values):
    render_pass.rect.foreach_set(np.ascontiguousarray(values, dtype=np.float32).reshape(-1))


def describe_picture(picture, report: ConversionReport, *words: str) -> str:
    """Say how well a picture is known, how it was filtered and mixed, and how much of its scene is not as Blender has it."""
    made = picture.provenance
    shares = tell_parts(picture.relative_error, made.simplified)
    parts = [
        f"{made.samples} samples",
        f"error {readout.format_error(picture.relative_error)}"
        + (f" ({shares})" if shares else ""),
        stopping.format_seconds(made.seconds),
    ]
    counts = readout.describe_counts(row.severity.name for row, _ in report.rows)
    return ", ".join(part for part in (*parts, *words, counts) if part)


def _stamp(result, text: str, provenance) -> None:
    """Write into the file's metadata, beside the pixels, what is said of a picture."""
    result.stamp_data_add_field("Lumenray", text)
    result.stamp_data_add_field("Lumenray Decisions", "; ".join(provenance.decisions))
    result.stamp_data_add_field("Lumenray Notes", "; ".join(provenance.notes))


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


_HANDLERS = {"render_complete": _rendered, "render_cancel": _rendered}


def attach():
    """Listen for the ends of animations."""
    listen(_HANDLERS)


def detach():
    """Listen no longer."""
    leave(_HANDLERS)
    close_final_feed()
    preview.close()


CLASSES = (LumenrayRenderEngine,)
