"""Drop things in a window: a luminaire's file from outside, and with the mouse a luminaire and a material of the libraries.

Run by ``run_drop.sh``, which moves the mouse where ``/out/drop/luminaire.txt`` and ``material.txt`` say and reads
``objects.txt`` there. The second place is told when the first asset has been dropped.
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
    # The floor beside the cube.
    tell_places("luminaire", browser, 150, -120)
    bpy.app.timers.register(lambda: choose_materials(browser), first_interval=1.0)


def choose_materials(browser):
    """Show the library of materials as soon as a luminaire was dragged."""
    if not any(item.type == "LIGHT" and is_luminaire(item) for item in bpy.data.objects):
        return 1.0
    browser.spaces.active.params.asset_library_reference = "Lumenray: materials"
    # The cube itself.
    bpy.app.timers.register(lambda: tell_places("material", browser, 0, 0), first_interval=3.0)
    return None


def tell_places(what, browser, right, up):
    """Write where the mouse has to go: from the first picture to a place in the view, from its middle. [pixel]"""
    height = bpy.context.window_manager.windows[0].height
    assets, target = region_of(browser), region_of(area_of("VIEW_3D"))
    places = (
        assets.x + 60,
        height - (assets.y + assets.height - 60),
        target.x + target.width // 2 + right,
        height - (target.y + target.height // 2 + up),
    )
    (FOLDER / f"{what}.txt").write_text(" ".join(map(str, places)) + "\n", encoding="ascii")


def is_luminaire(item):
    """Whether an object shines as an embedded file says."""
    settings = item.data.lumenray.luminaire if item.type == "LIGHT" else None
    settings = item.lumenray.luminaire if item.type == "EMPTY" else settings
    return settings is not None and settings.use_file and settings.text is not None


def tell_objects():
    """Write down what lies in the scene, and what the cube is made of."""
    lines = []
    for slot in bpy.data.objects["Cube"].material_slots:
        is_physical = slot.material is not None and slot.material.lumenray.use_override
        lines.append(
            f"CUBE {'physical' if is_physical else '-'} {slot.material and slot.material.name}\n"
        )
    for item in bpy.data.objects:
        lines.append(f"{item.type} {'luminaire' if is_luminaire(item) else '-'} {item.name}\n")
    (FOLDER / "objects.txt").write_text("".join(lines), encoding="utf-8")
    return 1.0


FOLDER.mkdir(exist_ok=True)
# The first click would only close it.
bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(open_browser, first_interval=2.0)
bpy.app.timers.register(tell_objects, first_interval=1.0)
