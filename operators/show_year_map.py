"""Show a map of a year in false colours on the objects that it lies on."""

import bpy
from bpy.props import EnumProperty

from ..blender_addon.bake.results import unchanged
from ..blender_addon.readout import title_case
from ..engine.baking.year_figures import KINDS
from ..engine.errors import LumenrayError
from ..imports import loaded_when_used
from .show_baked import show_materials, tell

with loaded_when_used():
    from ..blender_addon.bake import look as baked_look
    from ..blender_addon.bake import year_images

FIGURES = [
    (kind.name, title_case(kind.title), kind.title, number) for number, kind in enumerate(KINDS)
]
"""What can be shown."""


class LUMENRAY_OT_show_year_map(bpy.types.Operator):
    """Let the materials of objects with maps of a year show one in false colours, in EEVEE and in material preview"""

    bl_idname = "lumenray.show_year_map"
    bl_label = "Show Map"
    bl_options = {"REGISTER", "UNDO"}

    figure: EnumProperty(
        name="Figure",
        description="Which figure is shown. Default Daylight Autonomy: what most rooms are judged by",
        items=FIGURES,
    )

    @classmethod
    def poll(cls, context):
        if year_images.find_image(KINDS[0].name) is None:
            cls.poll_message_set("Compute a year with maps first")
            return False
        return True

    def execute(self, context):
        """Show it in the place of what was shown."""
        look = context.scene.lumenray.look
        try:
            with unchanged(context.scene):
                facts = year_images.facts_of(self.figure)
                baked_look.choose_figure(look, self.figure, facts["unit"], facts["high"])
                report = baked_look.show(context.scene)
        except LumenrayError as error:
            baked_look.choose_light(look)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        tell(self, report)
        show_materials(context)
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_show_year_map,)
"""For registration."""
