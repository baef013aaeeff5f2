"""What Blender's own Add menu offers of ours."""

import bpy


def draw_luminaire(menu, context) -> None:
    """Draw the entry that adds luminaires from photometric files."""
    menu.layout.separator()
    menu.layout.operator(
        "lumenray.add_luminaire", text="Luminaire (IES, LDT)…", icon="OUTLINER_OB_LIGHT"
    )


def attach():
    """Add to Blender's menu of lights, once."""
    detach()
    bpy.types.VIEW3D_MT_light_add.append(draw_luminaire)


def detach():
    """Take it off again."""
    bpy.types.VIEW3D_MT_light_add.remove(draw_luminaire)
