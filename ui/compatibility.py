"""Blender's own panels for our engine: the ones that show what we read."""

import bpy

ENGINE = "LUMENRAY"

LEFT_OUT = {
    # ours stand in their place
    "DATA_PT_light",
    "DATA_PT_spot",
    "NODE_DATA_PT_light",
    "NODE_DATA_PT_spot",
    # what the engine does not do
    "DATA_PT_camera_stereoscopy",
    "MATERIAL_PT_freestyle_line",
    "RENDER_PT_freestyle",
    "RENDER_PT_gpencil",
    "RENDER_PT_grease_pencil_render",
    "RENDER_PT_grease_pencil_viewport",
    "RENDER_PT_simplify_greasepencil",
    "RENDER_PT_stereoscopy",
}
"""Panels that would mislead."""

LEFT_OUT_STEMS = (
    "DATA_PT_lightprobe",
    "DATA_PT_context_lightprobe",
    "DATA_PT_volume_render",
    "VIEWLAYER_PT_freestyle",
)
"""Beginnings of the names of panels that would mislead."""

TAKEN_TOO = {
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "EEVEE_MATERIAL_PT_context_material",
    "MATERIAL_PT_preview",
}
"""Panels for which Blender names only its own engines although they hold for any."""


def panels() -> list[type]:
    """Return Blender's own panels that make sense for us."""
    return [panel for panel in bpy.types.Panel.__subclasses__() if _fits(panel)]


def _fits(panel) -> bool:
    name = panel.__name__
    engines = getattr(panel, "COMPAT_ENGINES", None)
    if engines is None or not panel.__module__.startswith("bl_ui."):
        return False
    if name in LEFT_OUT or name.startswith(LEFT_OUT_STEMS):
        return False
    return "BLENDER_RENDER" in engines or name in TAKEN_TOO


def attach():
    """Name our engine in these panels."""
    for panel in panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def detach():
    """Take our name out of every panel of Blender's."""
    for panel in bpy.types.Panel.__subclasses__():
        if panel.__module__.startswith("bl_ui."):
            getattr(panel, "COMPAT_ENGINES", set()).discard(ENGINE)
