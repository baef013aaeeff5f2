"""What of the scene will be computed: decided by the engine without blocking the window, and kept for the panel."""

import bpy

from ..blender_addon import feedback
from ..blender_addon.bake.results import Watch
from ..blender_addon.foundation import background_job
from ..blender_addon.foundation.redraw import redraw
from ..blender_addon.modelling import asked, job, results
from ..blender_addon.modelling.wishes import read_wishes
from .background_operator import BackgroundOperator


class LUMENRAY_OT_explain_modelling(BackgroundOperator, bpy.types.Operator):
    """Look at the scene and decide what of it has to be modelled for the asked error; nothing is rendered"""

    bl_idname = "lumenray.explain_modelling"
    bl_label = "Find Out"
    bl_options = set()
    job_name, what = job.NAME, "Looking at the scene"

    @classmethod
    def poll(cls, context):
        if background_job.is_running(job.NAME):
            cls.poll_message_set("The scene is being looked at already; Esc cancels it")
            return False
        return True

    def _prepare(self, context) -> None:
        scene = context.scene
        # The engine takes its time, in which the scene or a switch may change.
        self._key, self._watch = results.key_of(scene), Watch()
        self._wishes = read_wishes(scene.lumenray.modelling)
        self._question = asked.find_question(scene, context.selected_objects)
        depsgraph = context.evaluated_depsgraph_get()
        self._job, self._report = job.prepare(depsgraph, self._question)

    def _finish(self, context):
        plan = self._job.answer.plan
        answer = results.Answer(plan, self._question, self._wishes, self._watch)
        results.store(self._key, answer)
        feedback.show_report(context.window_manager, self._report)
        self.report({"INFO"}, plan.budget_text.capitalize())
        redraw("PROPERTIES")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_explain_modelling,)
"""For registration."""
