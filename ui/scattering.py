"""Measured materials: the scattering file of a material, what it says, its pictures, its colour, and how it lies."""

import bpy

from ..blender_addon.scattering.files import is_measured, scattering_files
from ..blender_addon.scattering.preview import pictures
from ..imports import loaded_when_used
from .file_parts import LABELS, draw_file, draw_picture, draw_remarks
from .material import MaterialPanel
from .parts import draw_lines, draw_text

with loaded_when_used():
    from ..blender_addon.scattering import readout


def draw_sample(layout, settings) -> None:
    """Draw how the sample lies on the surface, and how its file is read."""
    column = layout.column()
    column.prop(settings, "back")
    column.prop(settings, "is_turned")
    column.prop(settings, "rotation")
    column.prop(settings, "tolerance")


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
        return scattering_files.state_of(context.material.lumenray.measured).reading is not None

    def draw(self, context):
        settings = context.material.lumenray.measured
        reading = scattering_files.state_of(settings).reading
        if reading is not None:
            self.draw_part(self.layout, context, settings, reading)


class LUMENRAY_PT_measured(MeasuredPanel, bpy.types.Panel):
    """File and figures."""

    bl_label = "Measured Scattering"

    def draw(self, context):
        layout = self.layout
        settings = context.material.lumenray.measured
        state = scattering_files.state_of(settings)
        invitation = "Open Scattering File"
        draw_file(layout, context, settings, state, "scattering_file", invitation, readout.REMEDY)
        if state.reading is not None:
            draw_lines(layout, readout.describe_file(state.reading), LABELS)
            draw_remarks(layout, context, state.reading.file.remarks, "scattering")
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
        draw_picture(layout, context, pictures, reading, "cuts")


class LUMENRAY_PT_measured_totals(MeasuredChild, bpy.types.Panel):
    """Total reflectance and transmittance."""

    bl_label = "Totals"

    def draw_part(self, layout, context, settings, reading):
        """Draw the shares of light that are reflected and transmitted, by angle."""
        draw_picture(layout, context, pictures, reading, "totals")


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
