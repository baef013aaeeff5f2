"""Materials: measurable parameters, or the node tree while they are off."""

import bpy

from ..blender_addon.surface_models import MODELS
from .parts import PropertiesPanel, draw_spectrum, draw_surface, draw_wide


class MaterialPanel(PropertiesPanel):
    """Panel of the material tab."""

    bl_context = "material"

    @classmethod
    def poll(cls, context):
        material = context.material
        return material is not None and not material.grease_pencil and super().poll(context)


def _draw_reflectance(layout, settings):
    layout.prop(settings, "reflectance_source", text="Reflectance")
    names = {
        "VALUE": ("reflectance", "Value"),
        "COLOR": ("reflectance_color", "Colour"),
        "FILE": ("reflectance_file", "File"),
    }
    name, label = names[settings.reflectance_source]
    layout.prop(settings, name, text=label)


def _draw_transmittance(layout, settings):
    draw_wide(layout, settings, "transmittance", "Transmittance")


def _draw_index(layout, settings):
    layout.prop(settings, "ior_source", text="Index n")
    if settings.ior_source == "FILE":
        layout.prop(settings, "ior_file", text="File")
        return
    layout.prop(settings, "ior", text="A" if settings.ior_source == "CAUCHY" else "Value")
    if settings.ior_source == "CAUCHY":
        layout.prop(settings, "cauchy_b", text="B [µm²]")


def _draw_pane(layout, settings):
    layout.prop(settings, "pane_source", text="Pane From")
    if settings.pane_source == "FILE":
        layout.prop(settings, "pane_file", text="File")
        return
    draw_wide(layout, settings, "transmittance", "Internal Transmittance")
    _draw_index(layout, settings)


def _draw_luminance(layout, settings):
    draw_wide(layout, settings, "luminance", "Luminance [cd/m²]")


def _draw_spectrum(layout, settings):
    draw_spectrum(layout, settings)
    if settings.spectrum == "RGB":
        layout.prop(settings, "reflectance_color", text="Colour")


def _draw_measured(layout, settings):
    layout.label(text="See the panel below", icon="INFO")


DRAWN = {
    "reflectance": _draw_reflectance,
    "transmittance": _draw_transmittance,
    "ior": _draw_index,
    "pane": _draw_pane,
    "luminance": _draw_luminance,
    "spectrum": _draw_spectrum,
    "measured": _draw_measured,
    "paint": _draw_measured,
    "ink": _draw_measured,
    "cloth": _draw_measured,
}
"""What is drawn for settings of a model that are more than one property with its own name."""


def draw_model(layout, settings) -> None:
    """Draw the settings of a material's model of a surface."""
    for name in MODELS[settings.model].settings:
        if name in DRAWN:
            DRAWN[name](layout, settings)
        else:
            layout.prop(settings, name)


class LUMENRAY_PT_material_override(MaterialPanel, bpy.types.Panel):
    """Measurable parameters."""

    bl_label = "Physical Override"

    def draw_header(self, context):
        self.layout.prop(context.material.lumenray, "use_override", text="")

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        settings = context.material.lumenray
        if not settings.use_override:
            layout.label(text="Off: the nodes below are used", icon="INFO")
            return
        layout.prop(settings, "model")
        draw_model(layout.column(), settings)


class LUMENRAY_PT_material_surface(MaterialPanel, bpy.types.Panel):
    """Node tree."""

    bl_label = "Surface"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and not context.material.lumenray.use_override

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        material = context.material
        if bpy.app.version < (5, 0, 0):
            layout.prop(material, "use_nodes", icon="NODETREE")
            if not material.use_nodes:
                layout.prop(material, "diffuse_color", text="Colour")
                return
        if material.node_tree is None:
            layout.label(text="The material has no nodes", icon="INFO")
            return
        draw_surface(layout, material.node_tree)


CLASSES = (LUMENRAY_PT_material_override, LUMENRAY_PT_material_surface)
