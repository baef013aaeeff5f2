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


CLASSES = (LUMENRAY_MT_add_rayset,)


def attach():
    """Add to Blender's menu of lights, once."""
    detach()
    bpy.types.VIEW3D_MT_light_add.append(draw_luminaire)


def detach():
    """Take it off again."""
    bpy.types.VIEW3D_MT_light_add.remove(draw_luminaire)
