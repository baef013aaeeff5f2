"""Restart the engine: end its process, whatever it is doing."""

import bpy

from ..blender_addon.foundation import engine_process
from ..blender_addon.foundation.redraw import redraw


class LUMENRAY_OT_restart_engine(bpy.types.Operator):
    """End the engine's process with all its work; the next render, bake or view starts another and sends the scene anew"""

    bl_idname = "lumenray.restart_engine"
    bl_label = "Restart Engine"
    bl_options = {"REGISTER"}

    def execute(self, context):
        engine_process.close()
        redraw("VIEW_3D")
        self.report({"INFO"}, "The engine was ended; the next action starts it again")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_restart_engine,)
