"""Turn a newly opened window into one worth a picture: rendered viewport, render settings shown."""

import bpy

bpy.context.scene.render.engine = "LUMENRAY"
for window in bpy.context.window_manager.windows:
    for area in window.screen.areas:
        for space in area.spaces:
            if space.type == "VIEW_3D":
                space.shading.type = "RENDERED"
                space.region_3d.view_perspective = "CAMERA"
            elif space.type == "PROPERTIES":
                space.context = "RENDER"
