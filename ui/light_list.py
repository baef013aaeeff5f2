"""Panel 'Lights' of the sidebar: the lights of the scene with what each gives, and their sum."""

import bpy

from ..blender_addon import shown_lights
from ..imports import loaded_when_used
from .compatibility import ENGINE
from .parts import draw_lines, draw_text
from .sidebar import SidebarPanel

with loaded_when_used():
    from ..blender_addon import light_list


class LUMENRAY_UL_lights(bpy.types.UIList):
    """Rows of the list of lights."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        split = layout.split(factor=0.62)
        split.label(text=item.name, icon=item.icon)
        split.label(text=item.amount)


class LUMENRAY_PT_lights(SidebarPanel, bpy.types.Panel):
    """Lights of the scene, the brightest first; choosing one selects it."""

    bl_label = "Lights"
    # What is folded costs nothing.
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE

    def draw(self, context):
        layout = self.layout
        scene, view_layer = context.scene, context.view_layer
        shown_lights.follow(scene, view_layer)
        held = shown_lights.held()
        if not shown_lights.is_of(scene, view_layer):
            # Another scene's list would pass for this one's.
            layout.operator("lumenray.list_lights", icon="FILE_REFRESH")
            return
        rows = context.window_manager.lumenray_lights
        layout.template_list("LUMENRAY_UL_lights", "", rows, "rows", rows, "row_index", rows=5)
        draw_lines(layout, light_list.describe(held))
        if problem := light_list.describe_problems(held):
            draw_text(layout, context, problem, "ERROR")
        draw_text(layout, context, light_list.NOT_LISTED, "INFO")
        if not shown_lights.is_current(scene, view_layer):
            draw_text(layout, context, "The scene has changed since this was found", "ERROR")
        layout.operator("lumenray.list_lights", text="Update", icon="FILE_REFRESH")


CLASSES = (LUMENRAY_UL_lights, LUMENRAY_PT_lights)
