"""Copy the conversion report to the clipboard."""

import bpy

from ..blender_addon import feedback


class LUMENRAY_OT_copy_report(bpy.types.Operator):
    """Copy all rows of the conversion report as text to the clipboard"""

    bl_idname = "lumenray.copy_report"
    bl_label = "Copy Report"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        if not context.window_manager.lumenray.rows:
            cls.poll_message_set("The report is empty")
            return False
        return True

    def execute(self, context):
        manager = context.window_manager
        manager.clipboard = feedback.report_text(manager)
        self.report({"INFO"}, f"{len(manager.lumenray.rows)} rows copied")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_copy_report,)
