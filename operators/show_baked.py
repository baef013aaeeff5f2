"""Show baked light in EEVEE and material preview, and take it away again."""

import bpy
from bpy.props import EnumProperty

from ..blender_addon.bake import results as baked_results
from ..blender_addon.bake.settings import LumenrayLookSettings
from ..blender_addon.foundation.report import Severity
from ..engine.errors import LumenrayError
from ..imports import loaded_when_used

with loaded_when_used():
    from ..blender_addon.bake import images as baked_images
    from ..blender_addon.bake import look as baked_look

LOOKS = LumenrayLookSettings.__annotations__["kind"].keywords["items"]


MOST_NAMES = 4
"""Materials that are named in the status line."""


class LUMENRAY_OT_show_baked(bpy.types.Operator):
    """Let the materials of baked objects show the baked light in EEVEE and in material preview; renders do not change"""

    bl_idname = "lumenray.show_baked"
    bl_label = "Show in EEVEE"
    bl_options = {"REGISTER", "UNDO"}

    look: EnumProperty(
        name="Look",
        description="How baked light is shown. Default Light: as an eye would see it",
        items=LOOKS,
    )

    @classmethod
    def poll(cls, context):
        if not baked_images.has_atlas():
            cls.poll_message_set("Bake objects of this scene first")
            return False
        return True

    def invoke(self, context, event):
        # A button may ask for one of the looks.
        if not self.properties.is_property_set("look"):
            self.look = context.scene.lumenray.look.kind
        return self.execute(context)

    def execute(self, context):
        look = context.scene.lumenray.look
        baked_look.choose_light(look)
        look.kind = self.look
        try:
            with baked_results.unchanged(context.scene):
                report = baked_look.show(context.scene)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        tell(self, report)
        show_materials(context)
        return {"FINISHED"}


def show_materials(context) -> None:
    """Let the 3D view that a button stands in show materials."""
    space = context.space_data
    if space is not None and space.type == "VIEW_3D":
        space.shading.type = "MATERIAL"
        # Else glass mirrors Blender's own studio.
        space.shading.use_scene_lights = space.shading.use_scene_world = True


def tell(operator, report) -> None:
    """Say which materials do not show what was asked for."""
    if not report.rows:
        return
    names = ", ".join(row.datablock for row, _ in report.rows[:MOST_NAMES])
    more = " and others" if len(report.rows) > MOST_NAMES else ""
    is_grave = any(row.severity is not Severity.INFO for row, _ in report.rows)
    operator.report(
        {"WARNING" if is_grave else "INFO"}, f"{names}{more}: {report.rows[0][0].remedy}"
    )


class LUMENRAY_OT_hide_baked(bpy.types.Operator):
    """Let materials look as they did before baked light was shown"""

    bl_idname = "lumenray.hide_baked"
    bl_label = "Back"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if not context.scene.lumenray.look.is_shown:
            cls.poll_message_set("No baked light is shown")
            return False
        return True

    def execute(self, context):
        with baked_results.unchanged(context.scene):
            baked_look.hide()
            baked_look.choose_light(context.scene.lumenray.look)
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_show_baked, LUMENRAY_OT_hide_baked)
