"""The light mix: list the groups, add the last picture's groups up anew, and let all shine as in the scene again."""

import bpy

from ..blender_addon.rendering import light_mix
from ..engine.errors import LumenrayError
from ..imports import loaded_when_used

with loaded_when_used():
    from ..blender_addon.sync import scene as sync_scene


class LUMENRAY_OT_list_light_groups(bpy.types.Operator):
    """Find the light groups of the scene and make a row of settings for each of them"""

    bl_idname = "lumenray.list_light_groups"
    bl_label = "List Light Groups"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.scene.lumenray.light_mix.groups != "NONE"

    def execute(self, context):
        scene = context.scene
        try:
            luminous = sync_scene.convert_scene(context.evaluated_depsgraph_get()).luminous
            groups = light_mix.groups_of(scene, luminous)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        names = light_mix.names_of(groups, luminous)
        light_mix.list_rows(scene, names)
        self.report({"INFO"}, f"{len(names)} light group{'' if len(names) == 1 else 's'} found")
        return {"FINISHED"}


class LUMENRAY_OT_mix_picture(bpy.types.Operator):
    """Add the light groups of the last render up at their levels, in the image Lumenray Mix"""

    bl_idname = "lumenray.mix_picture"
    bl_label = "Mix Last Render"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        if light_mix.has_kept(context.scene):
            return True
        cls.poll_message_set("Render first, with light groups kept apart")
        return False

    def execute(self, context):
        image = light_mix.show_mix(context.scene)
        self.report({"INFO"}, f"The mix is in the image '{image.name}'")
        return {"FINISHED"}


class LUMENRAY_OT_reset_light_mix(bpy.types.Operator):
    """Let all light groups shine as in the scene: on, with their own flux and colour"""

    bl_idname = "lumenray.reset_light_mix"
    bl_label = "Reset Light Mix"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        for row in context.scene.lumenray.light_mix.rows:
            for name in ("is_on", "factor", "colour"):
                row.property_unset(name)
        light_mix.mix_soon(context.scene)
        return {"FINISHED"}


CLASSES = (
    LUMENRAY_OT_list_light_groups,
    LUMENRAY_OT_mix_picture,
    LUMENRAY_OT_reset_light_mix,
)
