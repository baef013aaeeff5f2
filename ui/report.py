"""The report for a client: what it is called, what it has, and the button that writes it."""

import bpy

from ..blender_addon.foundation import background_job
from ..blender_addon.reporting import picture
from ..blender_addon.sensors import results
from ..blender_addon.sensors.settings import find_sensors
from ..imports import loaded_when_used
from .parts import draw_text
from .sidebar import SidebarPanel

with loaded_when_used():
    from ..blender_addon.sensors import readings

HINT = "A report tells what sensors say: add and measure some first"


class LUMENRAY_PT_client_report(SidebarPanel, bpy.types.Panel):
    """Report of the scene."""

    bl_label = "Report"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, scene = self.layout, context.scene
        empties = find_sensors(scene)
        measured = [empty for empty in empties if readings.readings_of(empty) is not None]
        if not measured:
            draw_text(layout, context, HINT, "INFO")
            return
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = scene.lumenray.report
        column = layout.column()
        for name in ("title", "client", "author", "filepath"):
            column.prop(settings, name)
        column = layout.column(heading="With")
        column.prop(settings, "use_picture")
        column.prop(settings, "use_pdf")
        old = [empty for empty in measured if results.is_outdated(empty)]
        if old:
            words = f"{len(old)} of {len(measured)} sensor objects are out of date, which the report says"
            draw_text(layout, context, words, "ERROR")
        if len(measured) < len(empties):
            words = f"{len(empties) - len(measured)} sensor objects are not measured and left out"
            draw_text(layout, context, words, "INFO")
        row = layout.row()
        row.scale_y = 1.4
        if background_job.is_running(picture.NAME):
            row.label(text="Rendering the picture; Esc cancels", icon="TIME")
        else:
            row.operator("lumenray.write_report", icon="TEXT")
        layout.operator("lumenray.open_report", icon="URL")


CLASSES = (LUMENRAY_PT_client_report,)
"""For registration."""
