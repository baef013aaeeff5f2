"""Lights: Blender's own shape and colour, and the amount of light in photometric units."""

import bpy

from ..blender_addon import readout
from ..blender_addon.file_assets.settings import settings_used
from ..imports import loaded_when_used
from .parts import PropertiesPanel, draw_colour, draw_description, draw_spectrum, draw_wide

with loaded_when_used():
    from ..blender_addon.sync.lights import kinds, portals


def draw_shape(layout, light) -> None:
    """Draw what Blender knows about a light's size and beam, as far as it counts."""
    if settings_used(light, "rayset") is not None:
        return
    luminaire = settings_used(light, "luminaire")
    if luminaire is not None:
        if luminaire.emission == "LIGHT":
            _draw_size(layout, light)
        return
    for name in kinds.kind_of(light).settings:
        if name in DRAWN:
            DRAWN[name](layout, light)
        else:
            layout.prop(light, name)


def _draw_size(layout, light) -> None:
    if light.type != "AREA":
        layout.prop(light, "shadow_soft_size", text="Radius")
        return
    layout.prop(light, "shape")
    column = layout.column(align=True)
    if light.shape in {"RECTANGLE", "ELLIPSE"}:
        column.prop(light, "size", text="Size X")
        column.prop(light, "size_y", text="Y")
    else:
        column.prop(light, "size")


def _draw_tube_length(layout, light) -> None:
    layout.prop(light.lumenray, "tube_length")


def _draw_limb_darkening(layout, light) -> None:
    layout.prop(light.lumenray, "limb_darkening")


def _draw_beam(layout, light) -> None:
    layout.prop(light, "spot_size", text="Beam Angle")
    layout.prop(light, "spot_blend", text="Soft Edge", slider=True)
    layout.prop(light, "show_cone")


def _draw_portal(layout, light) -> None:
    if hasattr(light, "cycles"):
        layout.prop(light.cycles, "is_portal", text="Portal")


def _draw_spread(layout, light) -> None:
    if not portals.is_portal(light):
        layout.prop(light, "spread")


DRAWN = {
    "size": _draw_size,
    "tube_length": _draw_tube_length,
    "limb_darkening": _draw_limb_darkening,
    "beam": _draw_beam,
    "portal": _draw_portal,
    "spread": _draw_spread,
}
"""What is drawn for settings of a kind of light that are more than one property with its own name."""


def draw_amount(layout, light) -> None:
    """Draw how much light there is and of which spectrum."""
    settings = light.lumenray
    if settings.use_physical:
        row = layout.row(align=True)
        row.use_property_split = False
        for quantity in readout.quantities_of(light):
            row.prop_enum(settings, "quantity", quantity, text=readout.value_unit(light, quantity))
        name = f"{readout.value_name(light)} [{readout.value_unit(light)}]"
        draw_wide(layout, settings, "value", name)
        draw_spectrum(layout, settings, light)
        return
    layout.prop(light, "energy")
    if hasattr(light, "exposure"):
        layout.prop(light, "exposure")
    draw_colour(layout, light)


def describe(context, light):
    """Return what the light emits, with the scale of the object that it is shown for."""
    source = context.object
    if source is not None and source.data == light:
        return readout.describe_lamp(source, context.scene)
    return readout.describe_light(light, context.scene.lumenray)


class LightPanel(PropertiesPanel):
    """Panel of the data tab of a light."""

    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return context.light is not None and super().poll(context)


class LUMENRAY_PT_light(LightPanel, bpy.types.Panel):
    """Kind and shape."""

    bl_label = "Light"

    def draw(self, context):
        layout = self.layout
        layout.row().prop(context.light, "type", expand=True)
        layout.use_property_split = True
        draw_shape(layout.column(), context.light)


class LUMENRAY_PT_light_photometry(LightPanel, bpy.types.Panel):
    """Amount and spectrum, where no photometric file states them."""

    bl_label = "Amount of Light"

    @classmethod
    def poll(cls, context):
        if not super().poll(context) or portals.is_portal(context.light):
            return False
        light = context.light
        if settings_used(light, "rayset") is not None:
            return False
        return settings_used(light, "luminaire") is None

    def draw(self, context):
        layout = self.layout
        layout.prop(context.light.lumenray, "use_physical")
        layout.use_property_split = True
        draw_amount(layout.column(), context.light)


class LUMENRAY_PT_light_readout(LightPanel, bpy.types.Panel):
    """The same amount in other units."""

    bl_label = "In Other Units"
    bl_parent_id = "LUMENRAY_PT_light_photometry"

    def draw(self, context):
        draw_description(self.layout, context, describe(context, context.light))


CLASSES = (LUMENRAY_PT_light, LUMENRAY_PT_light_photometry, LUMENRAY_PT_light_readout)
