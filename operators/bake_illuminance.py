"""Bake illuminance: selected objects to lux maps, without blocking the window."""

import logging
import threading
from pathlib import Path

import bpy
from bpy.props import FloatProperty, IntProperty, StringProperty

from ..blender_addon import bake, engine_process, feedback
from ..blender_addon.render_engine import stop_rule
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
    time: FloatProperty(
        name="Seconds", description="0 takes the scene's rule", default=0.0, min=0.0
    )
    folder: StringProperty(name="Folder", description="Empty takes the scene's", subtype="DIR_PATH")

    @classmethod
    def poll(cls, context):
        if context.window_manager.lumenray.job.running:
            cls.poll_message_set("A bake is running already; press Esc to end it")
            return False
        return True

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
        self._thread = threading.Thread(target=self._work, name="lumenray bake", daemon=True)
        self._thread.start()
        manager = context.window_manager
        manager.lumenray.job.running = True
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
            level = "WARNING" if isinstance(self._error, Cancelled) else "ERROR"
            self.report({level}, "Bake cancelled" if level == "WARNING" else str(self._error))
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
        densities = {s.name_full: s.lumenray.density for s in chosen if s.lumenray.density > 0.0}
        folder = bpy.path.abspath(self.folder or settings.bake_folder)
        if folder.startswith("//"):
            # An unsaved file has no place of its own.
            folder = str(Path(bpy.app.tempdir) / folder[2:])
        made = bake.BakeSettings(
            density=self.density or settings.bake_density,
            largest=settings.bake_size,
            margin=settings.bake_margin,
            rule=self._rule(settings),
            seed=settings.seed,
            transport=settings.transport.lower(),
            folder=Path(folder),
            densities={} if self.density else densities,
        )
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
        if self.samples or self.error or self.time:
            return StopRule(self.samples or None, self.error or None, self.time or None)
        return stop_rule(
            settings.bake_stop, settings.bake_samples, settings.bake_error, settings.bake_time
        )

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
        job = context.window_manager.lumenray.job
        # Rounded down: a job that shows 100 % is done.
        job.progress = int(progress.done * 1000) / 1000
        job.text = progress.text()
        context.window_manager.progress_update(int(progress.done * 1000))
        for area in context.screen.areas:
            if area.type in {"VIEW_3D", "PROPERTIES"}:
                area.tag_redraw()

    def _clean(self, context):
        manager = context.window_manager
        manager.event_timer_remove(self._timer)
        manager.progress_end()
        manager.lumenray.job.running = False

    def _finish(self, context, job):
        images = bake.store(job)
        feedback.show_report(context.window_manager, job.report)
        feedback.show_results(context.window_manager, job.maps)
        self.report({"INFO"}, f"{len(images)} lux maps, written to {job.settings.folder}")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_bake_illuminance,)
