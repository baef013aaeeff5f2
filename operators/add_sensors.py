"""Add sensors: at the 3D cursor, on a face, over a floor, or those of a whole room."""

import bpy
from bpy.props import EnumProperty, FloatProperty

from ..blender_addon.sensors.settings import LAYOUTS, QUANTITIES
from ..engine.errors import LumenrayError
from ..imports import loaded_when_used

with loaded_when_used():
    from ..blender_addon.sensors import adding


class LUMENRAY_OT_add_sensors(bpy.types.Operator):
    """Add illuminance sensors: at the 3D cursor, on the active face of a mesh, or over a floor"""

    bl_idname = "lumenray.add_sensors"
    bl_label = "Add Sensors"
    bl_options = {"REGISTER", "UNDO"}

    layout: EnumProperty(
        name="Layout",
        description="Where the sensors stand. Default Point: one place",
        items=LAYOUTS,
        default="POINT",
    )
    quantity: EnumProperty(
        name="Quantity",
        description="What is measured. Default Planar: that of work places and floors",
        items=QUANTITIES,
        default="PLANAR",
    )
    height: FloatProperty(
        name="Height",
        description="Of the sensors over the floor, in metres. Default 0.75: that of desks",
        default=0.75,
        min=0.0,
        max=100.0,
        soft_max=2.0,
    )

    def execute(self, context):
        try:
            empty = adding.add_sensors(context, self.layout, self.quantity, self.height)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Sensors '{empty.name}' added; measure them in the sidebar")
        return {"FINISHED"}


class LUMENRAY_OT_add_room_sensors(bpy.types.Operator):
    """Add the sensors of a room of the selected meshes: floor, walls, ceiling, and what is around an active task area"""

    bl_idname = "lumenray.add_room_sensors"
    bl_label = "Add Room's Sensors"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("A room's sensors are added in object mode")
            return False
        return True

    def execute(self, context):
        try:
            made = adding.add_room(context)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{len(made)} objects with sensors added")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_add_sensors, LUMENRAY_OT_add_room_sensors)
"""For registration."""
