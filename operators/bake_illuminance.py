"""Bake illuminance: selected objects to lux maps, without blocking the window."""

import sys
from dataclasses import replace

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, StringProperty

from ..blender_addon import assumptions, feedback, readout
from ..blender_addon.bake import results as baked_results
from ..blender_addon.bake import running as running_bake
from ..blender_addon.bake.error_graph import graph
from ..blender_addon.foundation import engine_process
from ..blender_addon.foundation.redraw import redraw
from ..engine.errors import Cancelled, LumenrayError
from ..imports import loaded_when_used

with loaded_when_used():
    from ..blender_addon.bake import folders as bake_folders
    from ..blender_addon.bake import job as bake
    from ..blender_addon.bake import look as baked_look
    from ..engine.accuracy import stopping

ONCE = {"SKIP_SAVE"}
"""Options of what a call is told: the next one is not to find it again unseen."""

RESUME = (
    "Go on with the interrupted bake in the folder; error, time and samples may be others, all other settings must be as "
    "they were"
)
"""What the button does that goes on with a bake."""


class LUMENRAY_OT_bake_illuminance(bpy.types.Operator):
    """Compute the illuminance of the selected objects as maps in lx, on UV maps of their own"""

    bl_idname = "lumenray.bake_illuminance"
    bl_label = "Bake Illuminance"
    # Not REGISTER: whatever is touched in the redo panel would bake again, in the way and over the files.
    bl_options = {"UNDO"}

    objects: StringProperty(
        name="Objects",
        description="Names of objects, separated by commas; empty takes the selected objects",
        options=ONCE,
    )
    density: FloatProperty(
        name="Lumels per Metre",
        description="Density of the maps in lumels per metre. Default 0: the scene's density counts",
        default=0.0,
        min=0.0,
        max=1000.0,
        options=ONCE,
    )
    samples: IntProperty(
        name="Samples",
        description="Number of samples per lumel after which it ends. Default 0: the scene's ends count",
        default=0,
        min=0,
        options=ONCE,
    )
    error: FloatProperty(
        name="Relative Error",
        description="Relative standard error at which it ends, as a share. Default 0: the scene's ends count",
        default=0.0,
        min=0.0,
        max=1.0,
        options=ONCE,
    )
    absolute: FloatProperty(
        name="Absolute Error",
        description="Standard error in lx at which it ends. Default 0: the scene's ends count",
        default=0.0,
        min=0.0,
        options=ONCE,
    )
    time: FloatProperty(
        name="Seconds",
        description="Time in seconds after which it ends. Default 0: the scene's ends count",
        default=0.0,
        min=0.0,
        options=ONCE,
    )
    folder: StringProperty(
        name="Folder",
        description="Where the maps are written; empty takes the scene's folder",
        subtype="DIR_PATH",
        options=ONCE,
    )
    gltf: StringProperty(
        name="glTF",
        description="Also write the baked objects with their light to this .glb or .gltf; empty does as the scene says",
        subtype="FILE_PATH",
        options=ONCE,
    )
    resume: BoolProperty(
        name="Resume",
        description=f"{RESUME}. Default off: a bake begins anew",
        default=False,
        options=ONCE,
    )

    @classmethod
    def poll(cls, context):
        if context.window_manager.lumenray.job.running:
            cls.poll_message_set("A bake is running already; stop or cancel it first")
            return False
        return True

    @classmethod
    def description(cls, context, properties):
        """Say what the button does, which is one of two things."""
        return RESUME if properties.resume else ""

    def execute(self, context):
        """Bake at once and return when done; for scripts."""
        try:
            job = self._prepare(context)
            session = engine_process.open_session("bake", context.scene)
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
        manager = context.window_manager
        try:
            job = self._prepare(context)
            session = engine_process.open_session("bake", context.scene)
            self._bake = running_bake.start(job, session, manager)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._bake.wake(manager, context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Show progress, hear Esc, end when the work has ended."""
        if event.type == "ESC" and event.value == "PRESS":
            running_bake.stop(context.window_manager)
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        bake_, manager = self._bake, context.window_manager
        bake_.show(manager)
        redraw("VIEW_3D", "PROPERTIES")
        if bake_.is_alive:
            return {"PASS_THROUGH"}
        bake_.end(manager)
        if bake_.error is not None:
            level, text = self._describe_end(bake_)
            self.report({level}, text)
            return {"CANCELLED"}
        return self._finish(context, bake_.job)

    def cancel(self, context):
        """Blender closes or loads a file: end the work before anything it refers to goes."""
        self._bake.end(context.window_manager)

    # ---- private ----

    def _prepare(self, context):
        scene = context.scene
        settings = scene.lumenray
        chosen = self._objects(context)
        folder = bake_folders.folder_of(settings.bake, self.folder)
        made = bake.read_settings(settings, chosen, self._rule(settings.bake), folder)
        if self.density:
            made = replace(made.ask(density=self.density), densities={})
        if self.gltf:
            made = replace(made, gltf=bake.gltf_path(bpy.path.abspath(self.gltf)))
        if self.resume:
            made = replace(made, resume=True)
        # Objects without a material have one while baked light is shown.
        with baked_results.unchanged(scene), baked_look.hidden(scene):
            job = bake.prepare(context.evaluated_depsgraph_get(), chosen, made)
        job.watch = baked_results.Watch()
        return job

    def _objects(self, context) -> list:
        if not self.objects.strip():
            return list(context.selected_objects)
        names = [name.strip() for name in self.objects.split(",") if name.strip()]
        missing = [name for name in names if name not in context.scene.objects]
        if missing:
            raise LumenrayError(f"the scene has no object named {', '.join(missing)}")
        return [context.scene.objects[name] for name in names]

    def _rule(self, settings) -> "stopping.StopRule":
        if self.samples or self.error or self.time or self.absolute:
            return stopping.StopRule(
                samples=self.samples or None,
                error=self.error or None,
                seconds=self.time or None,
                absolute=self.absolute or None,
            )
        return bake.rule_of(settings)

    def _describe_end(self, ended) -> tuple[str, str]:
        """Say how a bake ended that gave no result."""
        if not isinstance(ended.error, Cancelled):
            return "ERROR", str(ended.error)
        if bake_folders.checkpoint_path(ended.job.settings.folder).is_file():
            return "WARNING", "Bake cancelled; what is done was kept, and Resume goes on with it"
        return "WARNING", "Bake cancelled"

    def _finish(self, context, job):
        # The window may show another scene by now.
        scene = bpy.data.scenes.get(job.order.scene) or context.scene
        images = bake.store(job, scene)
        feedback.show_report(context.window_manager, job.report)
        graph.note(job.result.history)
        error = readout.format_error(job.result.relative_standard_error)
        folder = job.settings.folder
        text = (
            f"{len(job.maps)} lux maps in {len(images)} images, error {error}, written to {folder}"
        )
        if bpy.app.background:
            assumptions.tell(job.report, job.notes, job.shortfall, stream=sys.stdout)
        if job.result.shortfall:
            text = f"Bake {job.result.shortfall}. {text}"
        elif job.shortfall:
            text = f"{job.shortfall[0].upper()}{job.shortfall[1:]}. {text}"
        if bake_folders.is_temporary(folder):
            text += ", which goes when Blender ends: save the file to give its bakes a place"
        is_short = job.shortfall or bake_folders.is_temporary(folder)
        self.report({"WARNING" if is_short else "INFO"}, text)
        return {"FINISHED"}


class LUMENRAY_OT_stop_bake(bpy.types.Operator):
    """End the bake with the results so far and their error; Resume goes on with it later (Esc)"""

    bl_idname = "lumenray.stop_bake"
    bl_label = "Stop and Keep"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        if running_bake.current() is None:
            cls.poll_message_set("No bake is running")
            return False
        return True

    def execute(self, context):
        running_bake.stop(context.window_manager)
        return {"FINISHED"}


class LUMENRAY_OT_cancel_bake(bpy.types.Operator):
    """End the bake without a result; with Keep Progress on, Resume can go on with it"""

    bl_idname = "lumenray.cancel_bake"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        return LUMENRAY_OT_stop_bake.poll.__func__(cls, context)

    def execute(self, context):
        running_bake.cancel()
        return {"FINISHED"}


class LUMENRAY_OT_check_baked(bpy.types.Operator):
    """Compare the whole scene with the one that was baked, and take the mark off if they are the same"""

    bl_idname = "lumenray.check_baked"
    bl_label = "Check"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        if not context.scene.lumenray.baked.serial:
            cls.poll_message_set("Bake objects of this scene first")
            return False
        return True

    def execute(self, context):
        scene = context.scene
        with baked_results.unchanged(scene), baked_look.hidden(scene):
            is_same = baked_results.check_current(scene, context.evaluated_depsgraph_get())
        if is_same:
            self.report({"INFO"}, "The scene is the one that was baked")
        else:
            self.report({"WARNING"}, "The scene is not the one that was baked")
        return {"FINISHED"}


CLASSES = (
    LUMENRAY_OT_bake_illuminance,
    LUMENRAY_OT_stop_bake,
    LUMENRAY_OT_cancel_bake,
    LUMENRAY_OT_check_baked,
)
