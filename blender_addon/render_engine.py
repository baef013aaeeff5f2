"""The render engine that Blender calls: F12, animation and the command line."""

import time
from pathlib import Path

import bpy
import numpy as np

from ..engine.accuracy.stopping import StopRule
from ..engine.analysis.noise_filter import smooth
from ..engine.errors import Cancelled, LumenrayError
from ..engine.photometry.colour import automatic_white, scene_linear
from ..engine.session import Session, ViewSettings
from .properties import white_luminance
from .report import ConversionReport
from .sync.camera import region
from .sync.scene import convert_scene

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


def view_settings(settings) -> ViewSettings:
    """Read what the scene's settings ask of a picture."""
    return ViewSettings(
        rule=stop_rule(settings.stop, settings.samples, settings.error, settings.time),
        seed=settings.seed,
        illuminance=settings.use_pass_illuminance,
        bands=settings.spectral_bands if settings.use_spectral_file else 0,
        transport=settings.transport.lower(),
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


def picture_layers(picture, white: float | None, smoothed: bool = False) -> dict[str, np.ndarray]:
    """Name the layers of a `Picture` as passes, (h, w, c) float32. ``white`` None: found from the picture."""
    if white is None:
        white = automatic_white(picture.tristimulus[..., 1])
    combined = np.ones((*picture.depth.shape, 4), dtype=np.float32)
    combined[..., :3] = scene_linear(picture.tristimulus, white)
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
    """Renders one frame at a time; lives as long as Blender keeps it, on the thread that Blender chooses."""

    bl_idname = "LUMENRAY"
    bl_label = "Lumenray"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True

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

    def _render(self, depsgraph):
        scene = depsgraph.scene
        report = ConversionReport()
        self.update_stats("", "Converting the scene")
        converted = convert_scene(depsgraph, report)
        _show(report)
        if converted.camera is None:
            self.error_set("The scene has no camera: add one and make it active")
            return
        session = Session()
        session.apply(converted.delta)
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
        finished = False
        try:
            picture = session.render(
                converted.camera,
                view_settings(scene.lumenray),
                self._follow(session, result, white),
            )
            finished = True
        finally:
            # An abandoned result must be handed back too, else Blender waits for it.
            self.end_result(result, cancel=not finished)
        layers = picture_layers(picture, white, scene.lumenray.use_smoothing)
        self._deliver(place, depsgraph.view_layer_eval.name, layers, wanted)
        self._write_beside(scene, picture, report)
        left_over = f"error {100.0 * picture.relative_error:.2f} %"
        self.update_stats("", f"{picture.provenance.samples} samples, {left_over}")

    def _follow(self, session, result, white):
        """Return the function that follows the engine's progress."""
        shown_at = [0.0]

        def follow(progress, preview):
            if self.test_break():
                session.cancel()
            self.update_progress(progress.done)
            self.update_stats("", progress.text())
            now = time.monotonic()
            if preview is not None and progress.done < 1.0 and now - shown_at[0] > PREVIEW_INTERVAL:
                shown_at[0] = now
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

    def _write_beside(self, scene, picture, report):
        """Write what the picture file itself cannot hold: spectral bands and the conversion report."""
        path = Path(scene.render.frame_path(frame=scene.frame_current)).with_suffix("")
        to_disk = bpy.app.background or self.is_animation
        if picture.bands is not None:
            write_spectral(path.with_name(path.name + "_spectral.exr"), picture)
        if to_disk and report.rows:
            from ..engine.formats.report import compose, write_json

            content = compose(
                bpy.data.filepath,
                picture.provenance,
                picture.provenance.seconds,
                [],
                report.to_dicts(),
            )
            write_json(path.with_name(path.name + "_report.json"), content)


def write_spectral(path, picture):
    """Write a picture's bands as a spectral OpenEXR with a preview in R, G, B."""
    from ..engine.formats import exr

    channels = exr.spectral_channels(picture.bands, picture.band_edges)
    preview = scene_linear(picture.tristimulus, 1.0)
    channels |= {name: preview[..., i] for i, name in enumerate("RGB")}
    return exr.write_channels(path, channels, exr.SPECTRAL_ATTRIBUTES)


def _fill(render_pass, values):
    render_pass.rect.foreach_set(np.ascontiguousarray(values, dtype=np.float32).reshape(-1))


def _show(report):
    """Put the report where the panel finds it; a render without a window has none."""
    from .feedback import show_report

    def show():
        for manager in bpy.data.window_managers:
            show_report(manager, report)

    if bpy.app.background:
        show()
    else:
        # Blender renders on a thread of its own; the window's data belong to the main thread.
        bpy.app.timers.register(show)


CLASSES = (LumenrayRenderEngine,)
