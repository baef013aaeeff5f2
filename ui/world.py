"""The world: a sky of the CIE, or its background and what that one's numbers mean."""

import bpy

from ..blender_addon import readout
from ..blender_addon.foundation.node_trees import uses_nodes
from ..blender_addon.sky import depends_on_sun, find_sun_lamp
from .parts import PropertiesPanel, draw_description, draw_surface, draw_wide


class WorldPanel(PropertiesPanel):
    """Panel of the world tab."""

    bl_context = "world"

    @classmethod
    def poll(cls, context):
        return context.world is not None and super().poll(context)


class BackgroundPanel(WorldPanel):
    """Panel about the world's nodes, which is there while they count."""

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.world.lumenray.source == "NODES"


class LUMENRAY_PT_world_preview(WorldPanel, bpy.types.Panel):
    """What the world looks like, which Blender has no panel of its own for."""

    bl_label = "Preview"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.layout.template_preview(context.world)


class LUMENRAY_PT_world_sky(WorldPanel, bpy.types.Panel):
    """Choice between nodes and a sky of the CIE, and the latter's settings."""

    bl_label = "Sky"

    def draw(self, context):
        layout = self.layout
        world = context.world
        layout.row().prop(world.lumenray, "source", expand=True)
        if world.lumenray.source != "CIE":
            return
        settings = world.lumenray.sky
        # Over the whole width: the names are long.
        layout.prop(settings, "type", text="")
        layout.use_property_split = True
        column = layout.column()
        draw_wide(column, settings, "illuminance", "Illuminance [lx]")
        column.prop(settings, "colour_temperature", text="Daylight [K]")
        column.prop(settings, "ground_reflectance", text="Ground")
        lamp = None
        if depends_on_sun(settings):
            column = layout.column(heading="Sun From")
            column.prop(settings, "use_sun_lamp")
            if settings.use_sun_lamp:
                lamp = find_sun_lamp(context.scene, context.view_layer)
            if lamp is None:
                column.prop(settings, "elevation")
                column.prop(settings, "azimuth")
        draw_description(layout.box(), context, readout.describe_sky(world, lamp))


class LUMENRAY_PT_world_surface(BackgroundPanel, bpy.types.Panel):
    """Background nodes."""

    bl_label = "Surface"

    def draw(self, context):
        layout = self.layout
        world = context.world
        if bpy.app.version < (5, 0, 0):
            layout.prop(world, "use_nodes", icon="NODETREE")
        layout.use_property_split = True
        if not uses_nodes(world):
            layout.prop(world, "color")
            return
        draw_surface(layout, world.node_tree)


class LUMENRAY_PT_world_unit(BackgroundPanel, bpy.types.Panel):
    """Unit of the background."""

    bl_label = "Unit of the Background"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        settings = context.world.lumenray
        layout.prop(settings, "unit")
        if settings.unit == "ILLUMINANCE":
            draw_wide(layout, settings, "illuminance", "Illuminance [lx]")
        elif settings.unit == "BLENDER":
            layout.prop(context.scene.lumenray, "efficacy", text="lm per Watt")


CLASSES = (
    LUMENRAY_PT_world_preview,
    LUMENRAY_PT_world_sky,
    LUMENRAY_PT_world_surface,
    LUMENRAY_PT_world_unit,
)
