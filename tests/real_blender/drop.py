"""Drop luminaires in a window: a file from outside, and an asset from the Asset Browser with the mouse.

Run by ``run_drop.sh``, which moves the mouse where ``/out/drop/places.txt`` says and reads ``/out/drop/objects.txt``.
"""

from pathlib import Path

import bpy

FOLDER = Path("/out/drop")

FILE = "wall_washer.ies"
"""Photometric file that is dropped."""

PHOTOMETRY = "/project/libraries/luminaires/photometry"


def area_of(kind):
    """Return the largest area of a kind."""
    areas = bpy.context.window_manager.windows[0].screen.areas
    return max((a for a in areas if a.type == kind), key=lambda a: a.width * a.height)


def region_of(area):
    """Return an area's main region."""
    return next(region for region in area.regions if region.type == "WINDOW")


def open_browser():
    """Turn the properties into an Asset Browser."""
    area = area_of("PROPERTIES")
    area.ui_type = "ASSETS"
    area.spaces.active.show_region_toolbar = False
    bpy.app.timers.register(lambda: choose_library(area), first_interval=2.0)


def choose_library(area):
    """Show our library; it takes a moment to be read."""
    area.spaces.active.params.asset_library_reference = "Lumenray"
    bpy.app.timers.register(lambda: drop_file(area), first_interval=3.0)


def drop_file(browser):
    """Drop the file by Blender's own way for files from outside, and say where the mouse has to go."""
    view = area_of("VIEW_3D")
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, area=view, region=region_of(view)):
        bpy.ops.wm.drop_import_file("INVOKE_DEFAULT", directory=PHOTOMETRY, files=[{"name": FILE}])
    height = window.height
    assets, target = region_of(browser), region_of(view)
    places = (
        # The first picture, and the floor beside the cube.
        assets.x + 60,
        height - (assets.y + assets.height - 60),
        target.x + target.width // 2 + 150,
        height - (target.y + target.height // 2 - 120),
    )
    (FOLDER / "places.txt").write_text(" ".join(map(str, places)) + "\n", encoding="ascii")


def tell_objects():
    """Write down what lies in the scene."""
    lines = []
    for item in bpy.data.objects:
        settings = item.data.lumenray.luminaire if item.type == "LIGHT" else None
        settings = item.lumenray.luminaire if item.type == "EMPTY" else settings
        is_luminaire = settings is not None and settings.use_file and settings.text is not None
        lines.append(f"{item.type} {'luminaire' if is_luminaire else '-'} {item.name}\n")
    (FOLDER / "objects.txt").write_text("".join(lines), encoding="utf-8")
    return 1.0


FOLDER.mkdir(exist_ok=True)
# The first click would only close it.
bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(open_browser, first_interval=2.0)
bpy.app.timers.register(tell_objects, first_interval=1.0)
