"""Dask for Lumenray: this extension only brings libraries, which Lumenray's engine finds by itself."""

import bpy

LINES = (
    "Brings Dask, by which Lumenray has the workers of a cluster compute.",
    "Name the cluster in the preferences of Lumenray, and have a scene use it in",
    "Render > Cluster. Pictures, lux maps, sensors and daylight then come from there.",
)


class LumenrayClusterPreferences(bpy.types.AddonPreferences):
    """Says what this is for; there is nothing to set."""

    bl_idname = __package__

    def draw(self, context):
        """Draw the lines."""
        column = self.layout.column(align=True)
        for line in LINES:
            column.label(text=line)


def register():
    """Called by Blender."""
    bpy.utils.register_class(LumenrayClusterPreferences)


def unregister():
    """Called by Blender."""
    bpy.utils.unregister_class(LumenrayClusterPreferences)
