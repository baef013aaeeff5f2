"""Lighting scenes: the sliders of the light mix kept under a name, brought back, changed and forgotten."""

import bpy
from bpy.props import IntProperty, StringProperty

from ..blender_addon.rendering import light_mix
from ..engine.errors import LumenrayError
from ..imports import loaded_when_used

with loaded_when_used():
    from ..blender_addon.rendering import lighting_scenes


def _rows(context):
    return context.scene.lumenray.light_mix.scenes


class _OnScene:
    """Operator on a lighting scene."""

    index: IntProperty(
        name="Index",
        description="Number of the lighting scene, from 0. Default -1: the active one",
        default=-1,
        min=-1,
        options={"HIDDEN"},
    )

    @classmethod
    def poll(cls, context):
        if _rows(context):
            return True
        cls.poll_message_set("There are no lighting scenes yet")
        return False

    def number(self, context) -> int:
        """Return the number of the lighting scene that it is about."""
        settings = context.scene.lumenray.light_mix
        wanted = settings.scene_index if self.index < 0 else self.index
        return min(wanted, len(settings.scenes) - 1)


class LUMENRAY_OT_add_lighting_scene(bpy.types.Operator):
    """Keep the sliders of the light mix as they stand as a lighting scene"""

    bl_idname = "lumenray.add_lighting_scene"
    bl_label = "Add Lighting Scene"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(
        name="Name",
        description="Of the lighting scene. Default empty: Day, Evening, Emergency, in this order",
        maxlen=63,
    )

    @classmethod
    def poll(cls, context):
        settings = context.scene.lumenray.light_mix
        if settings.groups != "NONE" and settings.rows:
            return True
        cls.poll_message_set("Keep light groups apart and list them first, in the panel Light Mix")
        return False

    def execute(self, context):
        try:
            row = lighting_scenes.add(context.scene, self.name)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"'{row.name}' keeps the light mix as it stands")
        return {"FINISHED"}


class LUMENRAY_OT_apply_lighting_scene(_OnScene, bpy.types.Operator):
    """Set the sliders of the light mix as the lighting scene says; readings, views and the last render follow at once"""

    bl_idname = "lumenray.apply_lighting_scene"
    bl_label = "Apply Lighting Scene"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        number = self.number(context)
        context.scene.lumenray.light_mix.scene_index = number
        unknown = lighting_scenes.apply(context.scene, _rows(context)[number])
        if unknown:
            names = ", ".join(light_mix.label_of(name) for name in unknown)
            self.report({"WARNING"}, f"It says nothing of {names}: they shine as in the scene")
        return {"FINISHED"}


class LUMENRAY_OT_store_lighting_scene(_OnScene, bpy.types.Operator):
    """Let the lighting scene have the levels at which the sliders stand now"""

    bl_idname = "lumenray.store_lighting_scene"
    bl_label = "Store in Lighting Scene"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        lighting_scenes.store(context.scene, _rows(context)[self.number(context)])
        return {"FINISHED"}


class LUMENRAY_OT_remove_lighting_scene(_OnScene, bpy.types.Operator):
    """Forget the lighting scene; the sliders stay as they are"""

    bl_idname = "lumenray.remove_lighting_scene"
    bl_label = "Remove Lighting Scene"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        lighting_scenes.remove(context.scene, self.number(context))
        return {"FINISHED"}


CLASSES = (
    LUMENRAY_OT_add_lighting_scene,
    LUMENRAY_OT_apply_lighting_scene,
    LUMENRAY_OT_store_lighting_scene,
    LUMENRAY_OT_remove_lighting_scene,
)
"""For registration."""
