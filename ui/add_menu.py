"""What Blender's own Add menu offers of ours."""

import bpy

from ..blender_addon.readout import title_case
from ..libraries.raysets.catalogue import ENTRIES


def draw_luminaire(menu, context) -> None:
    """Draw the entry that adds luminaires from photometric files."""
    menu.layout.separator()
    menu.layout.operator(
        "lumenray.add_luminaire", text="Luminaire (IES, LDT)…", icon="OUTLINER_OB_LIGHT"
    )
    menu.layout.menu("LUMENRAY_MT_add_rayset", icon="LIGHT_POINT")


class LUMENRAY_MT_add_rayset(bpy.types.Menu):
    """Ray sets of the library, and files."""

    bl_idname = "LUMENRAY_MT_add_rayset"
    bl_label = "Ray Set"

    def draw(self, context):
        """Draw an entry for every source."""
        for entry in ENTRIES:
            made = self.layout.operator("lumenray.add_rayset", text=title_case(entry.title))
            made.entry = entry.name
        self.layout.separator()
        made = self.layout.operator("lumenray.add_rayset", text="Ray File…", icon="FILEBROWSER")
        made.entry = "FILE"


def draw_sensors(menu, context) -> None:
    """Draw the entry that adds sensors."""
    menu.layout.menu("LUMENRAY_MT_add_sensors", icon="OUTLINER_DATA_LIGHTPROBE")


class LUMENRAY_MT_add_sensors(bpy.types.Menu):
    """Sensors by where they stand and what they measure."""

    bl_idname = "LUMENRAY_MT_add_sensors"
    bl_label = "Sensors"

    def draw(self, context):
        """Draw an entry for what is wanted most, and one for a room."""
        for text, layout, quantity, height in SENSORS:
            made = self.layout.operator("lumenray.add_sensors", text=text)
            made.layout, made.quantity, made.height = layout, quantity, height
        self.layout.separator()
        self.layout.operator("lumenray.add_room_sensors", text="Room: Floor, Walls, Ceiling")


SENSORS = (
    ("Point", "POINT", "PLANAR", 0.75),
    ("Line", "LINE", "PLANAR", 0.75),
    ("Rectangle", "GRID", "PLANAR", 0.75),
    ("On Active Face", "FACE", "PLANAR", 0.75),
    ("Over Floor at Desk Height", "FLOOR", "PLANAR", 0.75),
    ("Over Floor, Cylindrical, Seated", "FLOOR", "CYLINDRICAL", 1.2),
    ("Over Floor, Cylindrical, Standing", "FLOOR", "CYLINDRICAL", 1.6),
    ("Over Floor, Vertical at Eyes", "FLOOR", "VERTICAL", 1.2),
    ("Eye", "POINT", "VERTICAL", 1.2),
    ("Semicylindrical Point", "POINT", "SEMICYLINDRICAL", 1.5),
    ("Spherical Point", "POINT", "SPHERICAL", 1.2),
    ("Luminance Meter", "POINT", "LUMINANCE", 1.2),
    ("Camera Luminances", "CAMERA", "LUMINANCE", 1.2),
    ("Observer of Glare", "POINT", "GLARE", 1.2),
    ("Goniometer", "SPHERE", "INTENSITY", 1.2),
)
"""Entries of the menu: text, layout, quantity, height over the floor [m]; eyes are 1.2 m up, of who stands 1.6."""

CLASSES = (LUMENRAY_MT_add_rayset, LUMENRAY_MT_add_sensors)


def attach():
    """Add to Blender's menus, once."""
    detach()
    bpy.types.VIEW3D_MT_light_add.append(draw_luminaire)
    bpy.types.VIEW3D_MT_add.append(draw_sensors)


def detach():
    """Take it off again."""
    bpy.types.VIEW3D_MT_light_add.remove(draw_luminaire)
    bpy.types.VIEW3D_MT_add.remove(draw_sensors)
