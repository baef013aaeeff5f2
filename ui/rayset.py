"""Ray sets: the ray file of a light, what was found out about it, how much of it shines, and how new rays are made."""

import bpy

from ..blender_addon.luminaires.settings import is_luminaire
from ..blender_addon.raysets import readout
from ..blender_addon.raysets.settings import active_rays
from .parts import PropertiesPanel, draw_lines, draw_spectrum, draw_text, draw_wide

LABELS = 0.42
"""Share of the width that labels take."""

FEW_REMARKS = 2
"""Up to so many remarks are shown unfolded."""


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
        return super().poll(context) and readout.settings_used(context.light) is not None

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
        if not settings.filepath:
            row = layout.row()
            row.scale_y = 1.4
            row.operator("lumenray.load_rayset", text="Open Ray File")
            return
        row = layout.row(align=True)
        row.operator("lumenray.load_rayset", text="", icon="FILEBROWSER")
        row.prop(settings, "filepath", text="")
        row.operator("lumenray.reload_rayset", text="", icon="FILE_REFRESH")
        layout.active = settings.use_file
        if not settings.use_file:
            return
        draw_state(layout, context, settings, readout.state_of(settings))


def draw_state(layout, context, settings, state) -> None:
    """Draw how far the preparation is, what is wrong, or what was found out."""
    if state.problem:
        box = layout.box()
        box.alert = True
        draw_text(box, context, state.problem, "ERROR")
        draw_text(box, context, readout.REMEDY)
    elif state.light is None:
        text = f"Preparing rays, {100.0 * state.share:.0f} %"
        if hasattr(layout, "progress"):
            layout.progress(factor=state.share, text=text)
        else:
            layout.label(text=text, icon="TIME")
    else:
        draw_lines(layout, readout.describe(settings, state.light), LABELS)
        _draw_remarks(layout, context, state.light.remarks)


def _draw_remarks(layout, context, remarks) -> None:
    if not remarks:
        return
    text = "1 warning" if len(remarks) == 1 else f"{len(remarks)} warnings"
    header, body = layout.panel(
        "lumenray_rayset_remarks", default_closed=len(remarks) > FEW_REMARKS
    )
    header.label(text=f"{text} about the file", icon="ERROR")
    if body:
        for remark in remarks:
            draw_text(body, context, str(remark), "DOT")


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
        state = readout.state_of(settings)
        has_own = state.light is not None and state.light.spectrum is not None
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
