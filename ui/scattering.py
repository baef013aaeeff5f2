"""Measured materials: the scattering file of a material, what it says, its pictures, its colour, and how it lies."""

import bpy

from ..blender_addon.luminaires.preview import has_dark_theme, side_of
from ..blender_addon.scattering import readout
from ..blender_addon.scattering.preview import pictures
from ..blender_addon.scattering.source import is_measured
from .luminaire import ICON_BORDER, ICON_UNIT, LABELS, MARGIN
from .material import MaterialPanel
from .parts import draw_lines, draw_text


def draw_file(layout, context, settings, state) -> None:
    """Draw which file it is, what can be done with it, and why it cannot be used."""
    if not state.name:
        row = layout.row()
        row.scale_y = 1.4
        row.operator("lumenray.load_scattering_file", text="Open Scattering File")
        return
    row = layout.row(align=True)
    row.operator("lumenray.load_scattering_file", text="", icon="FILEBROWSER")
    if settings.text is None:
        row.prop(settings, "filepath", text="")
        row.operator("lumenray.pack_scattering_file", text="", icon="UGLYPACKAGE")
    else:
        row.prop(settings, "text", text="")
        row.operator("lumenray.unpack_scattering_file", text="", icon="PACKAGE")
    row.operator("lumenray.reload_scattering_file", text="", icon="FILE_REFRESH")
    if state.problem:
        box = layout.box()
        box.alert = True
        draw_text(box, context, state.problem, "ERROR")
        draw_text(box, context, readout.REMEDY)
    else:
        draw_text(layout, context, state.notice, "INFO")
        if state.reading is None:
            layout.label(text="Reading the file…", icon="TIME")


def draw_remarks(layout, context, remarks) -> None:
    """Draw the warnings of the reader, folded if they are many."""
    if not remarks:
        return
    text = "1 warning" if len(remarks) == 1 else f"{len(remarks)} warnings"
    is_folded = len(remarks) > readout.FEW_REMARKS
    header, body = layout.panel("lumenray_scattering_remarks", default_closed=is_folded)
    header.label(text=f"{text} about the file", icon="ERROR")
    if body:
        for remark in remarks:
            draw_text(body, context, str(remark), "DOT")


def draw_sample(layout, settings) -> None:
    """Draw how the sample lies on the surface, and how its file is read."""
    column = layout.column()
    column.prop(settings, "back")
    column.prop(settings, "is_turned")
    column.prop(settings, "rotation")
    column.prop(settings, "tolerance")


def draw_picture(layout, context, reading, kind: str) -> None:
    """Draw a picture of the file about as wide as the panel, point by point as it was made."""
    scale = context.preferences.system.ui_scale
    side = side_of(context.region.width - MARGIN * scale)
    icon = pictures.icon(reading, side, has_dark_theme(context.preferences), kind)
    if icon == 0:
        layout.label(text="Drawing the picture…", icon="TIME")
        return
    layout.template_icon(icon, scale=(side / scale + ICON_BORDER) / ICON_UNIT)


class MeasuredPanel(MaterialPanel):
    """Panel of a material that scatters as a file says."""

    @classmethod
    def poll(cls, context):
        return super().poll(context) and is_measured(context.material)


class MeasuredChild(MeasuredPanel):
    """Panel of a measured material whose file is read."""

    bl_parent_id = "LUMENRAY_PT_measured"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        return readout.state_of(context.material.lumenray.measured).reading is not None

    def draw(self, context):
        settings = context.material.lumenray.measured
        reading = readout.state_of(settings).reading
        if reading is not None:
            self.draw_part(self.layout, context, settings, reading)


class LUMENRAY_PT_measured(MeasuredPanel, bpy.types.Panel):
    """File and figures."""

    bl_label = "Measured Scattering"

    def draw(self, context):
        layout = self.layout
        settings = context.material.lumenray.measured
        state = readout.state_of(settings)
        draw_file(layout, context, settings, state)
        if state.reading is not None:
            draw_lines(layout, readout.describe_file(state.reading), LABELS)
            draw_remarks(layout, context, state.reading.file.remarks)
            for words in readout.describe_words(state.reading):
                draw_text(layout, context, words)
        if state.name:
            layout.use_property_split = True
            draw_sample(layout, settings)
            layout.operator("lumenray.fit_scattering_look", icon="SHADING_RENDERED")


class LUMENRAY_PT_measured_cuts(MeasuredChild, bpy.types.Panel):
    """Polar cuts."""

    bl_label = "Cuts"

    def draw_part(self, layout, context, settings, reading):
        """Draw the scattering in the plane of incidence."""
        draw_picture(layout, context, reading, "cuts")


class LUMENRAY_PT_measured_totals(MeasuredChild, bpy.types.Panel):
    """Total reflectance and transmittance."""

    bl_label = "Totals"

    def draw_part(self, layout, context, settings, reading):
        """Draw the shares of light that are reflected and transmitted, by angle."""
        draw_picture(layout, context, reading, "totals")


class LUMENRAY_PT_measured_colour(MeasuredChild, bpy.types.Panel):
    """Colour under an illuminant."""

    bl_label = "Colour"

    def draw_part(self, layout, context, settings, reading):
        """Draw the colour of all light near the normal."""
        layout.use_property_split = True
        layout.prop(settings, "illuminant")
        layout.prop(settings, "swatch", text="")
        draw_lines(layout, readout.describe_colour(reading, settings.illuminant), LABELS)


CLASSES = (
    LUMENRAY_PT_measured,
    LUMENRAY_PT_measured_cuts,
    LUMENRAY_PT_measured_totals,
    LUMENRAY_PT_measured_colour,
)
