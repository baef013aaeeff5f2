"""The world: its background and what its numbers mean."""

import bpy

from .parts import PropertiesPanel, draw_surface


class WorldPanel(PropertiesPanel):
    """Panel of the world tab."""

    bl_context = "world"

    @classmethod
    def poll(cls, context):
        return context.world is not None and super().poll(context)


class LUMENRAY_PT_world_surface(WorldPanel, bpy.types.Panel):
    """Background nodes."""

    bl_label = "Surface"

    def draw(self, context):
        layout = self.layout
        world = context.world
        if bpy.app.version < (5, 0, 0):
            layout.prop(world, "use_nodes", icon="NODETREE")
        layout.use_property_split = True
        if world.node_tree is None or (bpy.app.version < (5, 0, 0) and not world.use_nodes):
            layout.prop(world, "color")
            return
        draw_surface(layout, world.node_tree)


class LUMENRAY_PT_world_unit(WorldPanel, bpy.types.Panel):
    """Unit of the background."""

    bl_label = "Unit of the Background"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        settings = context.world.lumenray
        layout.prop(settings, "unit")
        if settings.unit == "ILLUMINANCE":
            layout.prop(settings, "illuminance", text="Illuminance [lx]")
        elif settings.unit == "BLENDER":
            layout.prop(context.scene.lumenray, "efficacy", text="lm per watt")


CLASSES = (LUMENRAY_PT_world_surface, LUMENRAY_PT_world_unit)
