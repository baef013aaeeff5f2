"""Render tab: how long, how bright, which passes."""

import bpy

from ..blender_addon import readout
from ..imports import loaded_when_used
from .parts import PropertiesPanel, draw_stop, draw_text
from .presets import draw_presets

with loaded_when_used():
    from ..engine.analysis import denoiser

NO_DENOISER = (
    "Not installed: install the zip lumenray-denoiser for this platform as you did Lumenray's. Until then pictures are "
    "shown as computed"
)


class RenderPanel(PropertiesPanel):
    """Panel of the render tab."""

    bl_context = "render"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        self.draw_settings(layout, context, context.scene.lumenray)


class LUMENRAY_PT_sampling(RenderPanel, bpy.types.Panel):
    """When the render ends."""

    bl_label = "Sampling"

    def draw_header_preset(self, context):
        draw_presets(self.layout, context)

    def draw_settings(self, layout, context, settings):
        """Draw the stopping rule, the method, and what the last picture came to."""
        draw_stop(layout, settings.render)
        layout.prop(settings.render, "method")
        row = layout.row()
        row.active = settings.render.method != "PATHS"
        row.prop(settings.render, "use_unbiased")
        text = context.window_manager.lumenray.render
        if text:
            draw_text(layout, context, f"Last: {text}", "INFO")


class LUMENRAY_PT_film(RenderPanel, bpy.types.Panel):
    """Brightness of the picture."""

    bl_label = "Film & Exposure"

    def draw_settings(self, layout, context, settings):
        """Draw which luminance becomes white, and the spectral file."""
        layout.prop(settings, "exposure")
        if settings.exposure == "LUMINANCE":
            layout.prop(settings, "white_luminance", text="White [cd/m²]")
        elif settings.exposure == "EV100":
            layout.prop(settings, "ev100")
        if settings.exposure != "LUMINANCE":
            draw_text(layout, context, readout.describe_exposure(settings), "INFO")
        layout.prop(settings.render, "use_denoising")
        if settings.render.use_denoising and denoiser.find_denoiser() is None:
            draw_text(layout, context, NO_DENOISER, "INFO")
        layout.prop(settings.render, "use_spectral_file")
        column = layout.column()
        column.active = settings.render.use_spectral_file
        column.prop(settings.render, "spectral_bands")


class LUMENRAY_PT_passes(RenderPanel, bpy.types.Panel):
    """Photometric passes; Blender's own are in the view layer tab."""

    bl_label = "Passes"

    def draw_settings(self, layout, context, settings):
        """Draw the photometric passes."""
        layout.use_property_split = False
        column = layout.column()
        column.prop(settings.render, "use_pass_luminance", text="Luminance [cd/m²]")
        column.prop(settings.render, "use_pass_illuminance", text="Illuminance [lx]")
        column.prop(settings.render, "use_pass_denoising", text="Denoising Data")
        column = layout.column()
        column.prop(context.view_layer, "use_pass_z", text="Depth")
        column.prop(context.view_layer, "use_pass_normal", text="Normal")
        column.prop(context.view_layer, "use_pass_object_index", text="Object Index")
        column.prop(context.view_layer, "use_pass_material_index", text="Material Index")


class LUMENRAY_PT_advanced(RenderPanel, bpy.types.Panel):
    """What is rarely changed."""

    bl_label = "Advanced"
    # Below the panel of the bake, which is registered later.
    bl_order = 1
    bl_options = {"DEFAULT_CLOSED"}

    def draw_settings(self, layout, context, settings):
        """Draw transport, meaning of watts and seed."""
        layout.prop(settings, "transport")
        layout.prop(settings, "efficacy", text="lm per Watt")
        layout.prop(settings, "seed")


CLASSES = (
    LUMENRAY_PT_sampling,
    LUMENRAY_PT_film,
    LUMENRAY_PT_passes,
    LUMENRAY_PT_advanced,
)
