"""The Sun light that follows place and time, added."""

import bpy

from ..blender_addon.daylight import following


class LUMENRAY_OT_add_sun(bpy.types.Operator):
    """Let the selected Sun light, or a new one, stand where the sun stands at the world's place and time, with its light"""

    bl_idname = "lumenray.add_sun"
    bl_label = "Sun from Place and Time"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.scene.world is None:
            cls.poll_message_set("The scene has no world")
            return False
        if context.scene.world.library is not None:
            cls.poll_message_set("The world is linked from another file")
            return False
        return True

    def execute(self, context):
        chosen = next(
            (thing for thing in context.selected_objects if following.is_sun(thing)), None
        )
        lamp = following.add_lamp(context.scene, chosen)
        self.report({"INFO"}, f"'{lamp.name}' follows place and time")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_add_sun,)
