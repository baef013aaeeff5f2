"""List the lights: find anew what each of them gives."""

import bpy

from ..blender_addon import shown_lights


class LUMENRAY_OT_list_lights(bpy.types.Operator):
    """Find out what each light of the scene gives, as renders get it"""

    bl_idname = "lumenray.list_lights"
    bl_label = "List Lights"
    bl_options = {"REGISTER"}

    def execute(self, context):
        count = shown_lights.refresh(context.scene, context.view_layer).count
        self.report({"INFO"}, f"{count} light{'' if count == 1 else 's'} found")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_list_lights,)
