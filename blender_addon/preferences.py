"""Settings of the extension, the same for all files."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

from . import feedback
from .asset_libraries import follow_own_folder
from .foundation import engine_process
from .foundation.preferences import PACKAGE, SOLID_RADIUS
from .foundation.redraw import redraw

DEVICES = [
    (
        "AUTO",
        "Automatic",
        "The processor; where it cannot be used a graphics card that computes rightly when tried",
        0,
    ),
    ("CUDA", "NVIDIA GPU (CUDA)", "Refused where there is none", 1),
    ("METAL", "Apple GPU (Metal)", "Refused where there is none", 2),
    ("CPU", "CPU (LLVM)", "All threads of the processor", 3),
]


def _use_device(self, context):
    engine_process.close()
    engine_process.note_device("")
    feedback.check_again()


def _follow_luminaire_folder(self, context):
    follow_own_folder()


def _keep_steps(self, context):
    """Have Blender save it, also where it is set elsewhere than in the preferences."""
    context.preferences.is_dirty = True
    redraw("VIEW_3D")


class LumenrayPreferences(bpy.types.AddonPreferences):
    """Shown in Blender's preferences, under the extension."""

    bl_idname = PACKAGE

    device: EnumProperty(
        name="Device",
        description=(
            "What the engine computes on. A change ends the engine; the next action starts it on the new device. "
            "Default Automatic: what all jobs were seen to be right on"
        ),
        items=DEVICES,
        default="AUTO",
        update=_use_device,
    )
    memory_limit: FloatProperty(
        name="Memory of the Engine",
        description=(
            "Most memory in GiB that the engine's process may ask for, so that a job that is too large ends with a "
            "message instead of stopping the computer. Takes effect when the engine starts next. Default 0: no "
            "limit is set"
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
            "How far a luminaire's largest intensity reaches when its distribution is drawn in a 3D view: in "
            "metres, whatever the units of the scene, because preferences belong to all scenes. Default 0.5: it can "
            "be seen in a room"
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

    city_list: StringProperty(
        name="Own Cities",
        description=(
            "List of your own places for the world's daylight, a CSV file with the columns name, country, latitude, "
            "longitude, elevation_m and zone; its places come before those that ship"
        ),
        subtype="FILE_PATH",
    )

    constituents: StringProperty(
        name="Own Constituents",
        description=(
            "File of your own flakes, pigments, binders and indices of paints, JSON in the form of the guide; they are in "
            "the menus of paints and known to compositions that are opened"
        ),
        subtype="FILE_PATH",
    )

    cluster_address: StringProperty(
        name="Cluster",
        description=(
            "Address of the scheduler whose workers compute, such as tls://render.office:8786; tcp://127.0.0.1:8786 for one "
            "on this computer, which 'lumenray cluster local' starts. Default empty: there is none"
        ),
    )
    cluster_authority: StringProperty(
        name="Authority",
        description="Certificate in PEM of whom this computer and the cluster both trust; needed off this computer",
        subtype="FILE_PATH",
    )
    cluster_certificate: StringProperty(
        name="Certificate",
        description="Own certificate in PEM, made by that authority; needed off this computer",
        subtype="FILE_PATH",
    )
    cluster_key: StringProperty(
        name="Key",
        description="Key in PEM of the own certificate; needed off this computer",
        subtype="FILE_PATH",
    )

    show_steps: BoolProperty(
        name="Show First Steps",
        description=(
            "Show in the sidebar what is left to do from a light to lux that can be seen; else one line is left, in "
            "all files. Default on: the first hour needs it"
        ),
        default=True,
        update=_keep_steps,
    )

    def draw(self, context):
        """Draw the settings."""
        self.layout.use_property_split = True
        self.layout.prop(self, "device")
        self._draw_devices(context)
        self.layout.prop(self, "memory_limit", text="Engine Memory [GiB]")
        self.layout.prop(self, "solid_radius", text="Distributions [m]")
        self.layout.prop(self, "luminaire_folder", text="Own Assets")
        self.layout.prop(self, "city_list", text="Own Cities")
        self.layout.prop(self, "constituents", text="Own Constituents")
        self.layout.prop(self, "show_steps")

    def _draw_devices(self, context):
        """Show what the engine computes on, or why it does not."""
        engine = context.window_manager.lumenray.engine
        column = self.layout.column(align=True)
        if not engine.checked:
            column.label(text="Looking for devices…", icon="TIME")
            return
        for line in engine.found.splitlines():
            column.label(text=line, icon="NONE")
        if not engine.usable:
            column.label(text=engine.cause, icon="ERROR")
            column.label(text=engine.remedy)
        row = self.layout.row()
        row.operator("lumenray.check_engine", icon="FILE_REFRESH")
        row.operator("lumenray.try_devices", icon="CHECKMARK")


CLASSES = (LumenrayPreferences,)
