"""Luminaires: the photometric file of a light or an empty, what it says, and how much of it shines and which way."""

import bpy

from ..blender_addon.luminaires.files import photometric_files
from ..blender_addon.luminaires.preview import pictures
from ..blender_addon.luminaires.settings import active_settings
from ..blender_addon.raysets.settings import is_rayset
from ..imports import loaded_when_used
from .file_parts import LABELS, draw_file, draw_picture, draw_remarks
from .parts import (
    PropertiesPanel,
    draw_description,
    draw_lines,
    draw_spectrum,
    draw_text,
    draw_wide,
)

with loaded_when_used():
    from ..blender_addon.luminaires import readout

BOTH = "A ray set is on too and gives the light: switch one off"
"""Said of a luminaire that a file from elsewhere holds together with a ray set."""


def draw_luminaire_file(layout, context, settings, state) -> None:
    """Draw which file it is, what can be done with it, and why it cannot be used."""
    invitation = "Open IES, EULUMDAT or TM-33"
    draw_file(layout, context, settings, state, "luminaire_file", invitation, readout.REMEDY)


def draw_flux(layout, settings) -> None:
    """Draw what sets the amount of light."""
    column = layout.column()
    column.prop(settings, "amount")
    if settings.amount == "LUMENS":
        draw_wide(column, settings, "luminous_flux", "Luminous Flux [lm]")
    column = layout.column()
    column.prop(settings, "dimming")
    column.prop(settings, "maintenance_factor", text="Maintenance")
    column.prop(settings, "lamp_factor")


def draw_mounting(layout, settings, file) -> None:
    """Draw which way the distribution is turned, and what it shines from."""
    column = layout.column()
    column.prop(settings, "rotation")
    if file.photometric_type == "C":
        column.prop(settings, "mirror")
    if file.photometric_type == "B":
        column.prop(settings, "flip_h")
    column.prop(settings, "emission")
    if hasattr(settings, "blocks_light"):
        column.prop(settings, "blocks_light")
    column.prop(settings, "show_solid")


class LuminairePanel(PropertiesPanel):
    """Panel of the data tab of a light or an empty."""

    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return active_settings(context) is not None and super().poll(context)


class LuminaireChild(LuminairePanel):
    """Panel of a luminaire whose file can be used."""

    bl_parent_id = "LUMENRAY_PT_luminaire"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and readout.reading_used(active_settings(context)) is not None

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        settings = active_settings(context)
        self.draw_part(layout, context, settings, readout.reading_used(settings))


class LUMENRAY_PT_luminaire(LuminairePanel, bpy.types.Panel):
    """File and polar diagram."""

    bl_label = "Luminaire"

    def draw_header(self, context):
        self.layout.prop(active_settings(context), "use_file", text="")

    def draw(self, context):
        layout = self.layout
        settings = active_settings(context)
        state = photometric_files.state_of(settings)
        layout.active = settings.use_file or not state.name
        draw_luminaire_file(layout, context, settings, state)
        if is_rayset(context.object):
            if settings.use_file:
                draw_text(layout, context, BOTH, "ERROR")
            else:
                draw_text(layout, context, "Off: the ray set gives the light", "INFO")
        if state.reading is None:
            return
        draw_picture(layout, context, pictures, state.reading)
        draw_lines(layout, readout.describe_file(state.reading), LABELS)
        draw_remarks(layout, context, state.reading.file.remarks, "luminaire")


class LUMENRAY_PT_luminaire_amount(LuminaireChild, bpy.types.Panel):
    """Flux, and the way to it."""

    bl_label = "Amount of Light"

    def draw_part(self, layout, context, settings, reading):
        """Draw the factors and their effect."""
        draw_flux(layout, settings)
        draw_description(
            layout.box(), context, readout.describe_output(settings, reading, context.object)
        )


class LUMENRAY_PT_luminaire_mounting(LuminaireChild, bpy.types.Panel):
    """Orientation and source."""

    bl_label = "Mounting"

    def draw_part(self, layout, context, settings, reading):
        """Draw how the luminaire is mounted."""
        draw_mounting(layout, settings, reading.file)


class LUMENRAY_PT_luminaire_spectrum(LuminaireChild, bpy.types.Panel):
    """Spectrum, and why it is this one."""

    bl_label = "Spectrum"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_part(self, layout, context, settings, reading):
        """Draw the file's reason or the user's choice."""
        row = layout.row()
        row.use_property_split = False
        row.prop(settings, "spectrum_source", expand=True)
        if settings.spectrum_source == "FILE":
            draw_text(layout, context, reading.lamp_spectrum.reason, "INFO")
        elif context.light is not None:
            draw_spectrum(layout, context.light.lumenray, context.light)
        else:
            draw_spectrum(layout, settings, settings)


class LUMENRAY_PT_luminaire_words(LuminaireChild, bpy.types.Panel):
    """Maker, names, lamps."""

    bl_label = "Written in the File"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_part(self, layout, context, settings, reading):
        """Draw what the file tells in words."""
        draw_lines(layout, readout.describe_words(reading.file), LABELS)


CLASSES = (
    LUMENRAY_PT_luminaire,
    LUMENRAY_PT_luminaire_amount,
    LUMENRAY_PT_luminaire_mounting,
    LUMENRAY_PT_luminaire_spectrum,
    LUMENRAY_PT_luminaire_words,
)
