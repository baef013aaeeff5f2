"""Tab 'Lumenray' in the sidebar of the 3D view: state of the engine, rendered view, active light, report."""

import bpy

from ..blender_addon import first_steps, readout
from ..blender_addon.file_assets.settings import settings_used
from ..blender_addon.foundation import engine_process
from ..blender_addon.luminaires.files import photometric_files
from ..blender_addon.luminaires.preview import pictures
from ..blender_addon.luminaires.settings import settings_of
from ..blender_addon.raysets.files import ray_files
from ..blender_addon.raysets.settings import rays_of
from ..blender_addon.rendering import viewport
from ..blender_addon.sensors.settings import is_sensor
from ..imports import loaded_when_used
from .compatibility import ENGINE
from .file_parts import LABELS, draw_picture
from .light import draw_amount, draw_shape
from .luminaire import draw_flux, draw_luminaire_file, draw_mounting
from .parts import draw_choice, draw_description, draw_lines, draw_text, draw_wide
from .rayset import draw_state

with loaded_when_used():
    from ..blender_addon.luminaires import readout as luminaire_readout
    from ..blender_addon.sync.lights import portals
    from ..engine.analysis import denoiser

UNITS = {"FALSE_LUMINANCE": "cd/m²", "FALSE_ILLUMINANCE": "lx"}
"""Unit of the scale of false colours, by what the rendered view shows."""

ICONS = {"ERROR": "CANCEL", "WARNING": "ERROR", "INFO": "INFO"}
"""Icon of every severity."""


class SidebarPanel:
    """Panel of our tab."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Lumenray"


def draw_engine(layout, context) -> None:
    """Draw whether the engine can run, and what to do if not."""
    engine = context.window_manager.lumenray.engine
    if not engine.checked:
        layout.label(text="Looking for the engine…", icon="TIME")
    elif engine.usable and engine_process.why_lost():
        layout.label(text="Engine ended; the next action starts it", icon="INFO")
    elif engine.usable:
        layout.label(text="Engine ready", icon="CHECKMARK")
    else:
        box = layout.box()
        box.label(text="The engine cannot run", icon="ERROR")
        draw_text(box, context, f"Cause: {engine.cause}")
        draw_text(box, context, f"Remedy: {engine.remedy}")
        layout.operator("lumenray.check_engine", text="Check Again", icon="FILE_REFRESH")


class LUMENRAY_PT_engine(SidebarPanel, bpy.types.Panel):
    """State of the engine, while the first steps do not show it."""

    bl_label = "Engine"

    @classmethod
    def poll(cls, context):
        return not first_steps.are_shown(context.scene)

    def draw(self, context):
        layout = self.layout
        draw_engine(layout, context)
        if context.engine != ENGINE:
            draw_text(layout, context, "This scene is rendered by another engine", "INFO")
            draw_choice(layout, context.scene.render, "engine", ENGINE, "Render with Lumenray")


class LUMENRAY_PT_view(SidebarPanel, bpy.types.Panel):
    """What the view in rendered shading shows, and what the last edit took."""

    bl_label = "Rendered View"

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.lumenray.viewport
        column = layout.column()
        column.prop(settings, "display", text="Show")
        unit = UNITS.get(settings.display)
        if unit is not None:
            column.prop(settings, "automatic")
            if not settings.automatic:
                column.prop(settings, "low", text=f"From [{unit}]")
                column.prop(settings, "high", text=f"To [{unit}]")
            column.prop(settings, "logarithmic")
            column.prop(settings, "isolux_lines")
            column.prop(settings, "use_values")
        column.prop(settings, "samples", text="Samples")
        column.prop(settings, "method", text="Method")
        if settings.display in {"PICTURE", "PHOTOGRAPHIC", "VISUAL"}:
            row = column.row()
            row.active = denoiser.find_denoiser() is not None
            row.prop(settings, "use_denoising")
        if context.space_data.shading.type != "RENDERED":
            draw_choice(layout, context.space_data.shading, "type", "RENDERED", "Show Rendered")
            return
        self._draw_status(layout, context)

    def _draw_status(self, layout, context):
        status = viewport.newest_status()
        if status is None:
            return
        box = layout.box()
        if status.is_error:
            draw_text(box, context, status.message, "ERROR")
            box.operator("lumenray.restart_engine", icon="FILE_REFRESH")
            return
        draw_lines(box, readout.describe_edit(status))
        if context.preferences.view.show_developer_ui:
            draw_lines(box, readout.describe_timing(status))


class LUMENRAY_PT_active_light(SidebarPanel, bpy.types.Panel):
    """Quick settings of the active light that has no photometric file."""

    bl_label = "Active Light"

    @classmethod
    def poll(cls, context):
        source = context.object
        if source is None or source.type != "LIGHT":
            return False
        if settings_used(source.data, "rayset") is not None:
            return False
        return settings_used(source.data, "luminaire") is None

    def draw(self, context):
        layout = self.layout
        source = context.object
        light = source.data
        layout.label(text=source.name, icon=f"LIGHT_{light.type}")
        if portals.is_portal(light):
            layout.label(text="A portal: gives no light itself", icon="INFO")
            return
        layout.prop(light.lumenray, "use_physical")
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        draw_amount(column, light)
        draw_shape(column, light)
        box = layout.box()
        box.use_property_split = False
        draw_description(box, context, readout.describe_lamp(source, context.scene))


class LUMENRAY_PT_active_luminaire(SidebarPanel, bpy.types.Panel):
    """Photometric file of the active light or empty."""

    bl_label = "Luminaire"

    @classmethod
    def poll(cls, context):
        return settings_of(context.object) is not None and not is_sensor(context.object)

    def draw_header(self, context):
        self.layout.prop(settings_of(context.object), "use_file", text="")

    def draw(self, context):
        layout = self.layout
        source = context.object
        settings = settings_of(source)
        state = photometric_files.state_of(settings)
        layout.active = settings.use_file or not state.name
        layout.label(text=source.name, icon=f"{source.type}_DATA")
        draw_luminaire_file(layout, context, settings, state)
        if state.reading is None:
            return
        draw_picture(layout, context, pictures, state.reading)
        draw_lines(layout, luminaire_readout.describe_briefly(state.reading), LABELS)
        layout.use_property_split = True
        layout.use_property_decorate = False
        draw_flux(layout, settings)
        draw_mounting(layout, settings, state.reading.file)
        if source.type == "LIGHT":
            draw_shape(layout.column(), source.data)
        output = luminaire_readout.describe_output(settings, state.reading, source)
        draw_description(layout.box(), context, output)


class LUMENRAY_PT_active_rayset(SidebarPanel, bpy.types.Panel):
    """Ray file of the active light, where it has one."""

    bl_label = "Ray Set"

    @classmethod
    def poll(cls, context):
        source = context.object
        if source is None or source.type != "LIGHT":
            return False
        return settings_used(source.data, "rayset") is not None

    def draw(self, context):
        layout = self.layout
        source = context.object
        settings = rays_of(source)
        layout.label(text=source.name, icon=f"LIGHT_{source.data.type}")
        row = layout.row(align=True)
        row.operator("lumenray.load_rayset", text="", icon="FILEBROWSER")
        row.prop(settings, "filepath", text="")
        draw_state(layout, context, settings, ray_files.state_of(settings))
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(settings, "amount")
        if settings.amount == "LUMENS":
            draw_wide(layout, settings, "luminous_flux", "Luminous Flux [lm]")
        layout.prop(settings, "dimming")
        layout.prop(settings, "show_rays")


class LUMENRAY_UL_report(bpy.types.UIList):
    """Rows of the conversion report."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        split = layout.split(factor=0.4)
        split.label(text=item.datablock, icon=ICONS[item.severity])
        count = f" (×{item.count})" if item.count > 1 else ""
        split.label(text=item.message + count)

    def filter_items(self, context, data, property_name):
        """Filter by the texts of a row; Blender would look for a name, which rows do not have."""
        rows = getattr(data, property_name)
        wanted = self.filter_name.casefold()
        if not wanted:
            return [], []
        return [
            self.bitflag_filter_item
            if wanted in f"{row.datablock} {row.node} {row.message}".casefold()
            else 0
            for row in rows
        ], []


class LUMENRAY_PT_report(SidebarPanel, bpy.types.Panel):
    """What of the scene could not be taken over as it is."""

    bl_label = "Conversion Report"
    # Below the panels of the bake, which are registered later.
    bl_order = 1

    def draw(self, context):
        layout = self.layout
        feedback = context.window_manager.lumenray
        if not feedback.reported:
            draw_text(layout, context, "Filled when the scene is rendered or baked", "INFO")
            return
        if not feedback.rows:
            layout.label(text="All of it was taken over", icon="CHECKMARK")
            return
        line = layout.row()
        line.label(text=readout.describe_counts(row.severity for row in feedback.rows))
        line.operator("lumenray.copy_report", text="", icon="COPYDOWN")
        layout.template_list(
            "LUMENRAY_UL_report", "", feedback, "rows", feedback, "row_index", rows=4
        )
        if feedback.row_index < len(feedback.rows):
            self._draw_row(layout.box(), context, feedback.rows[feedback.row_index])

    def _draw_row(self, layout, context, row):
        where = f"{row.datablock} / {row.node}" if row.node else row.datablock
        draw_text(layout, context, where, ICONS[row.severity])
        draw_text(layout, context, row.message)
        draw_text(layout, context, f"Instead: {row.remedy}")


CLASSES = (
    LUMENRAY_UL_report,
    LUMENRAY_PT_engine,
    LUMENRAY_PT_view,
    LUMENRAY_PT_active_light,
    LUMENRAY_PT_active_luminaire,
    LUMENRAY_PT_active_rayset,
    LUMENRAY_PT_report,
)
