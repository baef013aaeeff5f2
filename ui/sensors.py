"""Sensors: their settings, the button that measures them, and what they told."""

import bpy

from ..blender_addon.rendering.light_mix import levels_of
from ..blender_addon.sensors import results, running
from ..blender_addon.sensors.settings import find_sensors, is_sensor
from ..imports import loaded_when_used
from .parts import draw_lines, draw_text, draw_wide
from .sidebar import SidebarPanel

with loaded_when_used():
    from ..blender_addon.sensors import readings as sensor_readings
    from ..blender_addon.sensors import verdicts, words

HINT = "No sensors yet: Add > Sensors, or here"


class LUMENRAY_PT_sensors(SidebarPanel, bpy.types.Panel):
    """All sensors of the scene: measuring, and a line for each object."""

    bl_label = "Sensors"

    def draw(self, context):
        layout, scene = self.layout, context.scene
        empties = find_sensors(scene)
        if not empties:
            draw_text(layout, context, HINT, "INFO")
            layout.menu("LUMENRAY_MT_add_sensors", icon="ADD")
            return
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = scene.lumenray.sensors
        column = layout.column()
        column.prop(settings, "error_percent")
        column.prop(settings, "time")
        column.prop(settings, "refresh")
        row = layout.row()
        row.scale_y = 1.4
        if running.is_running():
            row.label(text="Measuring; Esc cancels", icon="TIME")
        else:
            row.operator("lumenray.measure_sensors", icon="OUTLINER_DATA_LIGHTPROBE")
        self._draw_list(layout, scene, empties)
        self._draw_verdict(layout, context, empties)
        column = layout.column()
        column.prop(settings, "logarithmic")
        column.prop(settings, "automatic")
        if not settings.automatic:
            column.prop(settings, "high", text="To [lx]")
        column = layout.column(align=True)
        column.operator("lumenray.show_sensor_plans", icon="IMAGE_DATA")
        column.operator("lumenray.forget_readings", icon="TRASH")

    def _draw_list(self, layout, scene, empties):
        levels, lines = levels_of(scene), []
        for empty in empties:
            readings = sensor_readings.readings_of(empty)
            if readings is None:
                lines.append((empty.name, "not measured"))
                continue
            text = words.brief(readings, levels)
            lines.append(
                (empty.name, f"{text}, out of date" if results.is_outdated(empty) else text)
            )
        draw_lines(layout.box(), lines)

    def _draw_verdict(self, layout, context, empties):
        settings = context.scene.lumenray.sensors
        column = layout.column()
        column.prop(settings, "requirement")
        column.prop(settings, "requirements_file")
        if not settings.requirement:
            return
        column.prop(settings, "maintenance")
        column.prop(settings, "modified")
        box = layout.box()
        for text in verdicts.texts_of(context.scene, empties):
            draw_text(box, context, text)


class LUMENRAY_PT_active_sensors(SidebarPanel, bpy.types.Panel):
    """The sensors of the active empty: where they stand, and what they told."""

    bl_label = "Active Sensors"

    @classmethod
    def poll(cls, context):
        thing = context.object
        return thing is not None and thing.type == "EMPTY"

    def draw_header(self, context):
        self.layout.prop(context.object.lumenray.sensor, "is_sensor", text="")

    def draw(self, context):
        layout, empty = self.layout, context.object
        if not is_sensor(empty):
            draw_text(layout, context, "This empty stands for no sensors", "INFO")
            return
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = empty.lumenray.sensor
        column = layout.column()
        column.prop(settings, "layout")
        column.prop(settings, "quantity")
        if settings.quantity == "LUMINANCE" and settings.layout != "CAMERA":
            column.prop(settings, "acceptance")
        if settings.quantity not in {"LUMINANCE", "GLARE", "INTENSITY"}:
            column.prop(settings, "area")
            column.prop(settings, "use_spectrum")
        if settings.quantity != "INTENSITY":
            column.prop(settings, "requirement")
            if context.scene.lumenray.light_mix.scenes:
                column.prop(settings, "lighting_scenes")
        self._draw_size(column, settings)
        if settings.layout not in {"POINT", "CAMERA", "SPHERE"}:
            column.prop(settings, "use_spacing")
            if settings.use_spacing:
                column.prop(settings, "spacing", text="Spacing [m]")
        column = layout.column(heading="Show")
        column.prop(settings, "show_values")
        if settings.layout not in {"POINT", "LINE", "SPHERE"}:
            column.prop(settings, "show_isolux")
        lines = words.describe(empty, levels_of(context.scene))
        if lines:
            draw_lines(layout.box(), lines)
        if settings.layout == "SPHERE":
            layout.operator("lumenray.write_photometric_file", icon="EXPORT")

    def _draw_size(self, layout, settings):
        kind = settings.layout
        if kind == "CAMERA":
            layout.prop(settings, "camera")
            layout.prop(settings, "columns")
            layout.prop(settings, "rows")
        if kind == "SPHERE":
            layout.prop(settings, "radius", text="Radius [m]")
            layout.prop(settings, "plane_step")
            layout.prop(settings, "polar_step")
            layout.prop(settings, "use_distance")
            if settings.use_distance:
                layout.prop(settings, "distance", text="Distance [m]")
        if kind in {"LINE", "GRID", "BAND"}:
            layout.prop(settings, "length", text="Length [m]")
        if kind in {"GRID", "BAND"}:
            layout.prop(settings, "width", text="Width [m]")
        if kind == "BAND":
            layout.prop(settings, "band", text="Band [m]")
        if kind in {"FACE", "FLOOR", "BAND"}:
            layout.prop(settings, "surface")
            layout.prop(settings, "border", text="Border [m]")
        if kind == "FLOOR":
            draw_wide(layout, settings, "height", "Height over Floor [m]")


CLASSES = (LUMENRAY_PT_sensors, LUMENRAY_PT_active_sensors)
"""For registration."""
