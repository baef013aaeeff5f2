"""Ray sets: the ray file of a light, what was found out about it, how much of it shines, and how new rays are made."""

import bpy

from ..blender_addon.file_assets.settings import settings_used
from ..blender_addon.luminaires.settings import is_luminaire
from ..blender_addon.raysets.files import ray_files
from ..blender_addon.raysets.settings import active_rays
from ..imports import loaded_when_used
from .file_parts import LABELS, draw_file_row, draw_problem, draw_remarks
from .parts import PropertiesPanel, draw_lines, draw_spectrum, draw_text, draw_wide

with loaded_when_used():
    from ..blender_addon.raysets import readout


class RaysetPanel(PropertiesPanel):
    """Panel of the data tab of a light."""

    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return (
            getattr(context, "light", None) is not None
            and active_rays(context) is not None
            and super().poll(context)
        )


class RaysetChild(RaysetPanel):
    """Panel of a light whose ray file is used."""

    bl_parent_id = "LUMENRAY_PT_rayset"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and settings_used(context.light, "rayset") is not None

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        self.draw_part(layout, context, active_rays(context))


class LUMENRAY_PT_rayset(RaysetPanel, bpy.types.Panel):
    """File and figures."""

    bl_label = "Ray Set"

    def draw_header(self, context):
        self.layout.prop(active_rays(context), "use_file", text="")

    def draw(self, context):
        layout = self.layout
        settings = active_rays(context)
        if not settings.use_file and is_luminaire(context.object):
            draw_text(layout, context, "Off: the photometric file gives the light", "INFO")
        if not draw_file_row(layout, settings, "rayset", "Open Ray File"):
            return
        layout.active = settings.use_file
        if not settings.use_file:
            return
        draw_state(layout, context, settings, ray_files.state_of(settings))


def draw_state(layout, context, settings, state) -> None:
    """Draw how far the preparation is, what is wrong, or what was found out."""
    if state.problem:
        draw_problem(layout, context, state.problem, readout.REMEDY)
    elif state.reading is None:
        text = f"Preparing rays, {100.0 * state.share:.0f} %"
        if hasattr(layout, "progress"):
            layout.progress(factor=state.share, text=text)
        else:
            layout.label(text=text, icon="TIME")
    else:
        draw_lines(layout, readout.describe(settings, state.reading), LABELS)
        draw_remarks(layout, context, state.reading.remarks, "rayset")


class LUMENRAY_PT_rayset_amount(RaysetChild, bpy.types.Panel):
    """Flux and spectrum."""

    bl_label = "Amount of Light"

    def draw_part(self, layout, context, settings):
        """Draw what sets flux and spectrum."""
        layout.prop(settings, "amount")
        if settings.amount == "LUMENS":
            draw_wide(layout, settings, "luminous_flux", "Luminous Flux [lm]")
        layout.prop(settings, "dimming")
        layout.prop(settings, "spectrum_source", text="Spectrum Of")
        light = ray_files.state_of(settings).reading
        has_own = light is not None and light.spectrum is not None
        if settings.spectrum_source == "LIGHT" or not has_own:
            lamp = context.light.lumenray
            layout.prop(lamp, "use_physical", text="Physical")
            if lamp.use_physical:
                draw_spectrum(layout, lamp, context.light)
            else:
                layout.prop(context.light, "color")


class LUMENRAY_PT_rayset_rays(RaysetChild, bpy.types.Panel):
    """How new rays are made of the file's."""

    bl_label = "Rays"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_part(self, layout, context, settings):
        """Draw symmetry, fluctuation and units."""
        layout.prop(settings, "symmetry")
        layout.prop(settings, "use_widths", text="Own Spread")
        if settings.use_widths:
            column = layout.column()
            column.prop(settings, "position_spread")
            column.prop(settings, "width_direction")
        column = layout.column(heading="Text Files")
        column.prop(settings, "unit")
        column.prop(settings, "is_luminous")
        layout.prop(settings, "keep_index", text="Keep Prepared")
        layout.prop(settings, "show_rays")
        layout.operator("lumenray.parent_rayset_body", icon="CON_CHILDOF")


CLASSES = (LUMENRAY_PT_rayset, LUMENRAY_PT_rayset_amount, LUMENRAY_PT_rayset_rays)
