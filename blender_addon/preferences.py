"""Settings of the extension, the same for all files."""

import bpy
from bpy.props import FloatProperty

PACKAGE = __package__.rpartition(".")[0]
"""Name of the extension, by which Blender knows its preferences."""


class LumenrayPreferences(bpy.types.AddonPreferences):
    """Shown in Blender's preferences, under the extension."""

    bl_idname = PACKAGE

    memory_limit: FloatProperty(
        name="Memory of the engine",
        description=(
            "Most memory in GiB that the engine's process may ask for, so that a job that is too large ends with a "
            "message instead of stopping the computer; 0 sets no limit. Takes effect when the engine starts next"
        ),
        default=0.0,
        min=0.0,
        soft_max=256.0,
        precision=1,
    )

    def draw(self, context):
        """Draw the settings."""
        self.layout.use_property_split = True
        self.layout.prop(self, "memory_limit", text="Engine memory [GiB]")


def memory_limit() -> int | None:
    """Return the limit, None without one. [byte]"""
    addon = bpy.context.preferences.addons.get(PACKAGE)
    preferences = addon.preferences if addon is not None else None
    limit = preferences.memory_limit if preferences is not None else 0.0
    return int(limit * (1 << 30)) or None


CLASSES = (LumenrayPreferences,)
