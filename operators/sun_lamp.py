"""The Sun light that follows place and time: added, and let go again."""

import bpy

from ..blender_addon.daylight import following


class WorldOperator:
    """Operator on the scene's world."""

    @classmethod
    def poll(cls, context):
        if context.scene.world is None:
            cls.poll_message_set("The scene has no world")
            return False
        if context.scene.world.library is not None:
            cls.poll_message_set("The world is linked from another file")
            return False
        return True


class LUMENRAY_OT_add_sun(WorldOperator, bpy.types.Operator):
    """Let the selected Sun light, or a new one, stand where the sun stands at the world's place and time, with its light"""

    bl_idname = "lumenray.add_sun"
    bl_label = "Sun from Place and Time"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        chosen = next(
            (thing for thing in context.selected_objects if following.is_sun(thing)), None
        )
        lamp = following.add_lamp(context.scene, chosen)
        self.report({"INFO"}, f"'{lamp.name}' follows place and time")
        return {"FINISHED"}


class LUMENRAY_OT_release_sun(WorldOperator, bpy.types.Operator):
    """Let the Sun light stay as it is, and follow place and time no longer"""

    bl_idname = "lumenray.release_sun"
    bl_label = "Release Sun"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        context.scene.world.lumenray.sun.lamp = None
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_add_sun, LUMENRAY_OT_release_sun)
