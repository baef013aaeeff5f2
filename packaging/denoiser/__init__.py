"""Open Image Denoise for Lumenray: this extension only brings the library, which Lumenray finds by itself."""

import bpy

LINES = (
    "Brings Open Image Denoise, by which Lumenray can filter the noise of pictures.",
    "Choose it in Render > Film & Exposure: Smooth Noise, Noise Filter.",
    "Lux maps, sensors and all passes but Combined stay as they were computed.",
)


class LumenrayDenoiserPreferences(bpy.types.AddonPreferences):
    """Says what this is for; there is nothing to set."""

    bl_idname = __package__

    def draw(self, context):
        """Draw the lines."""
        column = self.layout.column(align=True)
        for line in LINES:
            column.label(text=line)


def register():
    """Called by Blender."""
    bpy.utils.register_class(LumenrayDenoiserPreferences)


def unregister():
    """Called by Blender."""
    bpy.utils.unregister_class(LumenrayDenoiserPreferences)
