"""Settings of the extension, the same for all files."""

import bpy
from bpy.props import FloatProperty, StringProperty

from .asset_library.registration import follow_own_folder
from .foundation.preferences import PACKAGE, SOLID_RADIUS


def _follow_luminaire_folder(self, context):
    follow_own_folder()


class LumenrayPreferences(bpy.types.AddonPreferences):
    """Shown in Blender's preferences, under the extension."""

    bl_idname = PACKAGE

    memory_limit: FloatProperty(
        name="Memory of the Engine",
        description=(
            "Most memory in GiB that the engine's process may ask for, so that a job that is too large ends with a "
            "message instead of stopping the computer; 0 sets no limit. Takes effect when the engine starts next"
        ),
        default=0.0,
        min=0.0,
        soft_max=256.0,
        precision=1,
    )
    solid_radius: FloatProperty(
        name="Size of Distributions",
        # Without a subtype of length: Blender would show it in the units of the scene that is open, by its scale too.
        description=(
            "How far a luminaire's largest intensity reaches when its distribution is drawn in a 3D view: in metres, "
            "whatever the units of the scene, because preferences belong to all scenes"
        ),
        default=SOLID_RADIUS,
        min=0.01,
        soft_max=10.0,
    )

    luminaire_folder: StringProperty(
        name="Own Assets",
        description=(
            "Folder of your own luminaires and materials, shown in the Asset Browser once 'lumenray luminaire library "
            "FOLDER' has made assets of its photometric files, or 'lumenray brdf library FOLDER' of its materials.json"
        ),
        subtype="DIR_PATH",
        update=_follow_luminaire_folder,
    )

    def draw(self, context):
        """Draw the settings."""
        self.layout.use_property_split = True
        self.layout.prop(self, "memory_limit", text="Engine Memory [GiB]")
        self.layout.prop(self, "solid_radius", text="Distributions [m]")
        self.layout.prop(self, "luminaire_folder", text="Own Assets")


CLASSES = (LumenrayPreferences,)
