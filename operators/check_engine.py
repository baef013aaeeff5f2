"""Check the engine: look again for what it needs."""

import bpy

from ..blender_addon import feedback


class LUMENRAY_OT_check_engine(bpy.types.Operator):
    """Look for Mitsuba and LLVM, which the engine needs, and say what is missing"""

    bl_idname = "lumenray.check_engine"
    bl_label = "Check Engine"
    # Not REGISTER: Blender would repeat it while the window waits.
    bl_options = set()

    def invoke(self, context, event):
        """Look in the background: the panels tell what is found."""
        if bpy.app.background:
            return self.execute(context)
        feedback.check_again()
        return {"FINISHED"}

    def execute(self, context):
        """Look and return when it is known; for scripts."""
        manager = context.window_manager
        if feedback.check_engine(manager):
            self.report({"INFO"}, "The engine is ready")
            return {"FINISHED"}
        engine = manager.lumenray.engine
        self.report({"WARNING"}, f"{engine.cause}; {engine.remedy}")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_check_engine,)
