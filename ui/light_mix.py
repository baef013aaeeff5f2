"""Light mix: light groups of pictures and rendered views, dimmed, coloured and switched without new samples."""

import bpy

from ..blender_addon.rendering import light_mix
from .compatibility import ENGINE
from .parts import PropertiesPanel, draw_lines, draw_text
from .sidebar import SidebarPanel

NO_ROWS = "No groups yet: they are listed by a render, by the rendered view, or here"

NO_LUX = "Lux by group: switch the pass Illuminance on and render"


class LUMENRAY_UL_light_mix(bpy.types.UIList):
    """Light groups: whether it is on, name, factor, colour."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        split = layout.split(factor=0.45)
        name = split.row(align=True)
        name.prop(
            item,
            "is_on",
            text="",
            icon="OUTLINER_OB_LIGHT" if item.is_on else "LIGHT",
            emboss=False,
        )
        name.label(text=light_mix.label_of(item.name))
        row = split.row(align=True)
        row.active = item.is_on
        row.prop(item, "factor", text="", slider=True)
        colour = row.row(align=True)
        colour.scale_x = 0.5
        colour.prop(item, "colour", text="")


class LightMixPanel:
    """Panel with the levels of all light groups."""

    bl_label = "Light Mix"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, scene = self.layout, context.scene
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = scene.lumenray.light_mix
        layout.prop(settings, "groups")
        if settings.groups == "NONE":
            return
        if not settings.rows:
            draw_text(layout, context, NO_ROWS, "INFO")
        else:
            layout.template_list(
                "LUMENRAY_UL_light_mix", "", settings, "rows", settings, "row_index", rows=4
            )
            if settings.row_index < len(settings.rows):
                row = settings.rows[settings.row_index]
                draw_lines(layout, light_mix.describe(scene, row))
            if not scene.lumenray.render.use_pass_illuminance:
                draw_text(layout, context, NO_LUX, "INFO")
        column = layout.column(align=True)
        column.operator("lumenray.mix_picture", icon="IMAGE_DATA")
        row = column.row(align=True)
        row.operator("lumenray.list_light_groups", text="List Groups", icon="FILE_REFRESH")
        row.operator("lumenray.reset_light_mix", text="Reset", icon="LOOP_BACK")


class LUMENRAY_PT_light_mix(LightMixPanel, PropertiesPanel, bpy.types.Panel):
    """Light mix beside the passes of the view layer, where Blender keeps its light groups."""

    bl_context = "view_layer"


class LUMENRAY_PT_light_mix_sidebar(LightMixPanel, SidebarPanel, bpy.types.Panel):
    """Light mix beside the rendered view."""

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE


CLASSES = (LUMENRAY_UL_light_mix, LUMENRAY_PT_light_mix, LUMENRAY_PT_light_mix_sidebar)
