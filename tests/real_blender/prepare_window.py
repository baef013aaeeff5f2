"""Turn a newly opened window into one worth a picture.

The viewport is rendered, its sidebar shows the tab of Lumenray, and the properties editor shows the
settings of the active light, or of the render where no light is active.
"""

import bpy

CATEGORY = "Lumenray"

ATTEMPTS = 20
"""How often the sidebar is asked for its tab; it has none before it was drawn."""


def shade(shading):
    """Show the render, or plain surfaces where the engine draws no viewport.

    Blender's own preview of materials would take minutes for its shaders without a graphics card.
    """
    try:
        shading.type = "RENDERED"
    except TypeError:
        shading.type = "SOLID"


def prepare_spaces(window):
    """Choose what the window's editors show."""
    light = bpy.context.object is not None and bpy.context.object.type == "LIGHT"
    for area in window.screen.areas:
        for space in area.spaces:
            if space.type == "VIEW_3D":
                shade(space.shading)
                space.region_3d.view_perspective = "CAMERA"
                space.show_region_ui = True
            elif space.type == "PROPERTIES":
                space.context = "DATA" if light else "RENDER"


def sidebars(window):
    """Return area and sidebar of every viewport."""
    return [
        (area, region)
        for area in window.screen.areas
        if area.type == "VIEW_3D"
        for region in area.regions
        if region.type == "UI"
    ]


def choose_tab():
    """Return a timer function that brings the tab to the front as soon as there is one."""
    left = ATTEMPTS

    def choose():
        nonlocal left
        left -= 1
        done = True
        for window in bpy.context.window_manager.windows:
            for area, region in sidebars(window):
                try:
                    region.active_panel_category = CATEGORY
                except (AttributeError, TypeError):
                    # Read-only while there are no tabs.
                    done = False
                area.tag_redraw()
                done = done and region.active_panel_category == CATEGORY
        return None if done or left == 0 else 0.3

    return choose


bpy.context.preferences.view.show_splash = False
bpy.context.scene.render.engine = "LUMENRAY"
for shown in bpy.context.window_manager.windows:
    prepare_spaces(shown)
bpy.app.timers.register(choose_tab(), first_interval=1.0)
