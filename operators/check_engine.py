"""Check the engine: look again for what it needs."""

import bpy

from ..blender_addon import feedback


class LUMENRAY_OT_check_engine(bpy.types.Operator):
    """Look for Mitsuba and LLVM, which the engine needs, and say what is missing"""

    bl_idname = "lumenray.check_engine"
    bl_label = "Check Engine"
    bl_options = {"REGISTER"}

    def execute(self, context):
        manager = context.window_manager
        if feedback.check_engine(manager):
            self.report({"INFO"}, "The engine is ready")
            return {"FINISHED"}
        engine = manager.lumenray.engine
        self.report({"WARNING"}, f"{engine.cause}; {engine.remedy}")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_check_engine,)
