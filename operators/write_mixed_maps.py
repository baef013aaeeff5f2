"""Write lux maps with the light groups of a bake as their sliders have them."""

import bpy

from ..blender_addon.readout import format_number
from ..engine.errors import LumenrayError
from ..imports import loaded_when_used

with loaded_when_used():
    from ..blender_addon.bake import mixing

MOST_TOLD = 3
"""Objects that are told in the status line."""


class LUMENRAY_OT_write_mixed_maps(bpy.types.Operator):
    """Write the lux maps and figures of the last bake with its light groups as the sliders have them, into the folder mix"""

    bl_idname = "lumenray.write_mixed_maps"
    bl_label = "Write Mixed Maps"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        if len(context.scene.lumenray.look.layers) > 0:
            return True
        cls.poll_message_set("Bake with Layers first, and show the light in EEVEE")
        return False

    def execute(self, context):
        try:
            made, folder = mixing.write_mix(context.scene)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        told = [f"{each.name} {format_number(each.mean)} lx" for each in made[:MOST_TOLD]]
        more = ", …" if len(made) > MOST_TOLD else ""
        self.report({"INFO"}, f"Means: {', '.join(told)}{more}; written to {folder}")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_write_mixed_maps,)
"""For registration."""
