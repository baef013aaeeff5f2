"""Bake illuminance: selected objects to lux maps, without blocking the window."""

import logging
import threading
from dataclasses import replace

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, StringProperty

from ..blender_addon import bake, baked_look, engine_process, feedback, readout
from ..blender_addon.error_graphs import graph
from ..engine.accuracy.stopping import StopRule
from ..engine.errors import Cancelled, LumenrayError

log = logging.getLogger(__name__)


class LUMENRAY_OT_bake_illuminance(bpy.types.Operator):
    """Compute the illuminance of the selected objects as maps in lx, on UV maps of their own"""

    bl_idname = "lumenray.bake_illuminance"
    bl_label = "Bake Illuminance"
    bl_options = {"REGISTER", "UNDO"}

    objects: StringProperty(
        name="Objects",
        description="Names separated by commas; empty takes the selected objects",
    )
    density: FloatProperty(
        name="Lumels per metre", description="0 takes the scene's", default=0.0, min=0.0, max=1000.0
    )
    samples: IntProperty(name="Samples", description="0 takes the scene's rule", default=0, min=0)
    error: FloatProperty(
        name="Relative error", description="0 takes the scene's rule", default=0.0, min=0.0, max=1.0
    )
    absolute: FloatProperty(
        name="Absolute error",
        description="In lx; 0 takes the scene's rule",
        default=0.0,
        min=0.0,
    )
    time: FloatProperty(
        name="Seconds", description="0 takes the scene's rule", default=0.0, min=0.0
    )
    folder: StringProperty(name="Folder", description="Empty takes the scene's", subtype="DIR_PATH")
    gltf: StringProperty(
        name="glTF",
        description="Also write the baked objects with their light to this .glb or .gltf; empty does as the scene says",
        subtype="FILE_PATH",
    )
    resume: BoolProperty(
        name="Resume",
        description="Go on with the interrupted bake in the folder; all settings must be as they were",
        default=False,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context):
        if context.window_manager.lumenray.job.running:
            cls.poll_message_set("A bake is running already; press Esc to end it")
            return False
        return True

    @classmethod
    def description(cls, context, properties):
        """Say what the button does, which is one of two things."""
        return cls.bl_rna.properties["resume"].description if properties.resume else ""

    def execute(self, context):
        """Bake at once and return when done; for scripts."""
        try:
            job = self._prepare(context)
            session = engine_process.open_session("bake")
            try:
                job.run(session)
            finally:
                session.close()
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self._finish(context, job)

    def invoke(self, context, event):
        """Bake in the background while the window stays alive."""
        if bpy.app.background:
            return self.execute(context)
        try:
            self._job = self._prepare(context)
            self._session = engine_process.open_session("bake")
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._error = None
        self._progress = None
        graph.note(None)
        self._thread = threading.Thread(target=self._work, name="lumenray bake", daemon=True)
        self._thread.start()
        manager = context.window_manager
        feedback.begin_job(manager)
        manager.progress_begin(0, 1000)
        self._timer = manager.event_timer_add(0.1, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Show progress, hear Esc, end when the work has ended."""
        if event.type == "ESC" and event.value == "PRESS":
            self._job.cancel()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        self._show_progress(context)
        if self._thread.is_alive():
            return {"PASS_THROUGH"}
        self._clean(context)
        if self._error is not None:
            level, text = self._describe_end()
            self.report({level}, text)
            return {"CANCELLED"}
        return self._finish(context, self._job)

    def cancel(self, context):
        """Blender closes or loads a file: end the work before anything it refers to goes."""
        self._job.cancel()
        self._thread.join()
        self._clean(context)

    # ---- private ----

    def _prepare(self, context):
        settings = context.scene.lumenray
        chosen = self._objects(context)
        folder = bake.folder_of(settings, self.folder)
        made = bake.read_settings(settings, chosen, self._rule(settings), folder)
        if self.density:
            made = replace(made, density=self.density, densities={})
        if self.gltf:
            made = replace(made, gltf=bake.gltf_path(bpy.path.abspath(self.gltf)))
        if self.resume:
            made = replace(made, resume=True)
        # Objects without a material have one while baked light is shown.
        with baked_look.hidden(context.scene):
            return bake.prepare(context.evaluated_depsgraph_get(), chosen, made)

    def _objects(self, context) -> list:
        if not self.objects.strip():
            return list(context.selected_objects)
        names = [name.strip() for name in self.objects.split(",") if name.strip()]
        missing = [name for name in names if name not in context.scene.objects]
        if missing:
            raise LumenrayError(f"the scene has no object named {', '.join(missing)}")
        return [context.scene.objects[name] for name in names]

    def _rule(self, settings) -> StopRule:
        if self.samples or self.error or self.time or self.absolute:
            return StopRule(
                samples=self.samples or None,
                error=self.error or None,
                seconds=self.time or None,
                absolute=self.absolute or None,
            )
        return bake.rule_of(settings)

    def _work(self):
        try:
            self._job.run(self._session, self._note)
        except LumenrayError as error:
            self._error = error
        except Exception as error:
            # A fault of ours: the log tells where, the window that it happened.
            log.exception("the bake failed")
            self._error = error
        finally:
            self._session.close()

    def _note(self, progress):
        self._progress = progress

    def _show_progress(self, context):
        progress = self._progress
        if progress is None:
            return
        feedback.show_progress(context.window_manager, progress)
        if progress.history is not None:
            graph.note(progress.history)
        context.window_manager.progress_update(int(progress.done * 1000))
        for area in context.screen.areas:
            if area.type in {"VIEW_3D", "PROPERTIES"}:
                area.tag_redraw()

    def _describe_end(self) -> tuple[str, str]:
        """Say how a bake ended that did not come to its end."""
        if not isinstance(self._error, Cancelled):
            return "ERROR", str(self._error)
        if bake.checkpoint_path(self._job.settings.folder).is_file():
            return "WARNING", "Bake cancelled; what is done was kept, and Resume goes on with it"
        return "WARNING", "Bake cancelled"

    def _clean(self, context):
        manager = context.window_manager
        manager.event_timer_remove(self._timer)
        manager.progress_end()
        manager.lumenray.job.running = False

    def _finish(self, context, job):
        images = bake.store(job, context.scene)
        feedback.show_report(context.window_manager, job.report)
        feedback.show_results(context.window_manager, job.result)
        graph.note(job.result.history)
        error = readout.format_error(job.result.relative_standard_error)
        self.report(
            {"INFO"},
            f"{len(job.maps)} lux maps in {len(images)} images, error {error}, written to {job.settings.folder}",
        )
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_bake_illuminance,)
