"""New lit room: a room with luminaires, ready to be baked."""

import bpy
from bpy.props import FloatProperty, IntProperty

from ..imports import loaded_when_used

with loaded_when_used():
    from ..blender_addon import lit_room


def _length(name: str, description: str, default: float, least: float):
    """Property of a length in metres; with a subtype Blender would show it by the scale of the scene."""
    return FloatProperty(
        name=name, description=description, default=default, min=least, max=500.0, soft_max=50.0
    )


def _count(name: str, axis: str):
    """Property of a number of luminaires along an axis."""
    description = (
        f"Number of recessed panels of 3800 lm along {axis}. Default 2: 2 by 2, when new, give 550 lx on the work plane "
        "of the room as it comes; EN 12464-1 asks for 500 lx, kept in use, where people write and read"
    )
    return IntProperty(name=name, description=description, default=2, min=1, max=50, soft_max=10)


class LUMENRAY_OT_new_lit_room(bpy.types.Operator):
    """Add a room of matt surfaces with luminaires, work plane and camera; Lumenray and metres become the scene's"""

    bl_idname = "lumenray.new_lit_room"
    bl_label = "New Lit Room"
    bl_options = {"REGISTER", "UNDO"}

    width: _length(
        "Width [m]", "Inner length along X in metres. Default 5: for two or three people", 5.0, 1.0
    )
    depth: _length(
        "Depth [m]", "Inner length along Y in metres. Default 4: for two or three people", 4.0, 1.0
    )
    height: _length(
        "Height [m]", "From floor to ceiling in metres. Default 2.8: usual in offices", 2.8, 2.0
    )
    columns: _count("Luminaires Along Width", "X")
    rows: _count("Luminaires Along Depth", "Y")

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("Rooms are added in object mode")
            return False
        if context.scene.library is not None:
            cls.poll_message_set("The scene is linked from another file")
            return False
        return True

    def execute(self, context):
        lit_room.add_lit_room(
            context, lit_room.Plan(self.width, self.depth, self.height, self.columns, self.rows)
        )
        space = context.space_data
        if space is not None and space.type == "VIEW_3D":
            space.region_3d.view_perspective = "CAMERA"
        self.report({"INFO"}, "Its surfaces are selected: Bake Illuminance computes their lux maps")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_new_lit_room,)
