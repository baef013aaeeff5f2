"""The daylight of a year: what is asked, and what came out."""

import bpy

from ..blender_addon.daylight_year import running
from ..blender_addon.daylight_year.settings import IRRADIANCES
from ..imports import loaded_when_used
from .parts import draw_lines
from .world import WorldPanel

with loaded_when_used():
    from ..blender_addon.daylight_year import results


class LUMENRAY_PT_daylight_year(WorldPanel, bpy.types.Panel):
    """Settings and button of a year, and its figures."""

    bl_label = "Daylight of a Year"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        settings = context.scene.lumenray.year
        column = layout.column()
        column.prop(settings, "weather_file", text="Weather")
        column.prop(settings, "floor")
        column.prop(settings, "spacing", text="Spacing [m]")
        column.prop(settings, "height", text="Height [m]")
        column.prop(settings, "blinds")
        if settings.blinds is not None:
            _draw_rule(column, settings)
        column.prop(settings, "maps")
        if settings.maps is not None:
            column.prop(settings, "map_density")
        column.prop(settings, "target", text="Target [lx]")
        column.prop(settings, "samples")
        row = layout.row()
        row.scale_y = 1.4
        if running.is_running():
            row.label(text="Computing; Esc cancels", icon="TIME")
        else:
            row.operator("lumenray.daylight_year", icon="LIGHT_SUN")
        text = bpy.data.texts.get(results.TEXT)
        if text is None:
            return
        draw_lines(layout.box(), results.read_figures(text))
        if results.has_maps():
            row = layout.row(align=True)
            row.operator_menu_enum("lumenray.show_year_map", "figure", icon="SHADING_TEXTURE")
            row.operator("lumenray.hide_baked", text="", icon="LOOP_BACK")
        for image in results.find_images():
            layout.label(text=image.name, icon="IMAGE_DATA")


def _draw_rule(column, settings) -> None:
    """Draw when blinds are closed."""
    rule = settings.blinds_rule
    column.prop(settings, "blinds_rule")
    if rule == "TIMES":
        column.prop(settings, "blinds_first_month")
        column.prop(settings, "blinds_last_month")
        column.prop(settings, "blinds_start", text="Start [h]")
        column.prop(settings, "blinds_end", text="End [h]")
        column.prop(settings, "blinds_workdays")
    elif rule == "TABLE":
        column.prop(settings, "blinds_file")
    elif rule == "SENSORS":
        column.prop(settings, "blinds_illuminance", text="Above [lx]")
    elif rule in IRRADIANCES:
        column.prop(settings, "blinds_irradiance", text="Above [W/m²]")
    if rule == "FACADE":
        column.prop(settings, "blinds_azimuth")


CLASSES = (LUMENRAY_PT_daylight_year,)
"""For registration."""
