"""Drag the suns and the ground of a photomontage and of a world's picture in a window, and drop a picture of surroundings.

Run by ``run_environment.sh``, which moves the mouse where files in ``/out/environment`` say, gesture by gesture, and reads
``told.txt`` there: what came of each.
"""

import math
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Matrix, Vector

FOLDER = Path("/out/environment")

TOWARDS = np.array([0.5, -0.35, 0.7]) / np.linalg.norm([0.5, -0.35, 0.7])
"""To the sun that the shadow on the floor is of."""

FOOT, TOP = (-1.14, 0.66, 0.0), (-1.14, 0.66, 1.0)
"""Of the post. [m]"""

PICTURE = "/out/environment/outside.hdr"


def area_of():
    """Return the largest 3D view."""
    areas = bpy.context.window_manager.windows[0].screen.areas
    return max((a for a in areas if a.type == "VIEW_3D"), key=lambda a: a.width * a.height)


def view_context():
    """Return what operators of the 3D view need."""
    area = area_of()
    region = next(each for each in area.regions if each.type == "WINDOW")
    return {
        "window": bpy.context.window_manager.windows[0],
        "area": area,
        "region": region,
        "region_data": area.spaces.active.region_3d,
    }


def on_screen(point) -> tuple[int, int]:
    """Where a point of the scene is on the screen, from its upper left corner. [pixel]"""
    context = view_context()
    region = context["region"]
    place = location_3d_to_region_2d(region, context["region_data"], Vector(point))
    height = bpy.context.window_manager.windows[0].height
    return round(region.x + place.x), round(height - (region.y + place.y))


def ask(name: str, *places) -> None:
    """Write where the mouse has to go for a gesture."""
    lines = [" ".join(map(str, place)) for place in places]
    (FOLDER / f"{name}.tmp").write_text("\n".join(lines) + "\n", encoding="ascii")
    (FOLDER / f"{name}.tmp").rename(FOLDER / f"{name}.txt")


def tell(words: str) -> None:
    """Write down what came of a gesture."""
    with (FOLDER / "told.txt").open("a", encoding="utf-8") as file:
        file.write(words + "\n")


def build() -> None:
    """Build a photomontage: a camera with its photo over a post on the ground."""
    scene = bpy.context.scene
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    scene.render.engine = "LUMENRAY"
    scene.render.resolution_x, scene.render.resolution_y = 960, 640
    data = bpy.data.cameras.new("Eye")
    camera = bpy.data.objects.new("Eye", data)
    scene.collection.objects.link(camera)
    forward = Vector((0.0, 6.0, -1.4)).normalized()
    turned = forward.to_track_quat("-Z", "Y").to_matrix().to_4x4()
    camera.matrix_world = Matrix.Translation((0.0, -6.0, 1.9)) @ turned
    # As wide as 0.75 at the distance 1.
    data.sensor_width, data.lens = 36.0, 36.0 / 0.75
    scene.camera = camera
    shown = data.background_images.new()
    shown.image = bpy.data.images.load(str(FOLDER / "photo.png"))
    shown.alpha, shown.display_depth = 1.0, "BACK"
    data.show_background_images = True
    settings = scene.world.lumenray.ground
    settings.photo, settings.use_ground, settings.radius = "CAMERA", True, 4.0
    space = area_of().spaces.active
    space.shading.type = "SOLID"
    space.region_3d.view_perspective = "CAMERA"
    space.region_3d.view_camera_zoom = 20.0
    space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = False


def start_shadow():
    """Ask for the sun by a shadow, whose end is where the sun of the photo throws it."""
    with bpy.context.temp_override(**view_context()):
        bpy.ops.lumenray.sun_from_shadow("INVOKE_DEFAULT")
    end = np.array(TOP) - TOWARDS * (TOP[2] / TOWARDS[2])
    ask("shadow", on_screen(FOOT), on_screen(TOP), on_screen(end))
    bpy.app.timers.register(wait_for_sun, first_interval=1.0)


def sun_towards():
    """Direction to the photo's sun, None while there is none. (3,)"""
    lamp = bpy.data.objects.get("Photo Sun")
    return None if lamp is None else np.array(lamp.matrix_world.col[2][:3])


def wait_for_sun():
    """Go on when the gesture is over."""
    if not (FOLDER / "shadow.done").exists():
        return 0.5
    towards = sun_towards()
    off = 180.0
    if towards is not None:
        off = math.degrees(math.acos(min(float(towards @ TOWARDS), 1.0)))
    tell(f"shadow {off:.3f}")
    start_ground()
    return None


def start_ground():
    """Ask for a drag of the ground's arrow, seen from aside."""
    view = area_of().spaces.active.region_3d
    view.view_perspective = "PERSP"
    view.view_location, view.view_distance = (0.0, -3.0, 0.5), 12.0
    view.view_rotation = Vector((0.3, -1.0, 0.45)).to_track_quat("Z", "Y")
    bpy.app.timers.register(ask_ground, first_interval=3.0)


def ask_ground():
    """Say where the arrow is: it stands below the camera."""
    x, y = on_screen((0.0, -6.0, 0.0))
    ask("ground", (x, y - 45), (x, y - 125))
    bpy.app.timers.register(wait_for_ground, first_interval=1.0)


def wait_for_ground():
    """Go on when the gesture is over."""
    if not (FOLDER / "ground.done").exists():
        return 0.5
    settings = bpy.context.scene.world.lumenray.ground
    tell(f"ground {settings.level:.3f}")
    settings.level = 0.0
    bpy.context.scene.world.lumenray.arc.radius = 3.0
    bpy.app.timers.register(ask_sun, first_interval=2.0)
    return None


def ask_sun():
    """Ask for a drag of the sun's handle by the width of a hand."""
    place = np.array([0.0, -6.0, 0.0]) + 3.0 * sun_towards()
    x, y = on_screen(place)
    tell("sun_before " + " ".join(f"{value:.3f}" for value in sun_towards()))
    ask("sun", (x, y), (x - 90, y + 40))
    bpy.app.timers.register(wait_for_drag, first_interval=1.0)


def wait_for_drag():
    """Go on when the gesture is over."""
    if not (FOLDER / "sun.done").exists():
        return 0.5
    tell("sun_after " + " ".join(f"{value:.3f}" for value in sun_towards()))
    drop()
    return None


def drop():
    """Drop a picture by Blender's own way for files from outside, analyse it, and ask for a drag of its sun."""
    bpy.data.objects.remove(bpy.data.objects["Photo Sun"])
    world = bpy.context.scene.world
    world.lumenray.ground.photo, world.lumenray.ground.use_ground = "NONE", False
    with bpy.context.temp_override(**view_context()):
        bpy.ops.wm.drop_import_file(
            "INVOKE_DEFAULT",
            directory=str(FOLDER),
            files=[{"name": Path(PICTURE).name}],
        )
    bpy.app.timers.register(ask_picture, first_interval=3.0)


def ask_picture():
    """Analyse what was dropped and say where its sun's handle is."""
    shown = [n for n in bpy.context.scene.world.node_tree.nodes if n.type == "TEX_ENVIRONMENT"]
    tell(f"dropped {shown[0].image.name if shown and shown[0].image else '-'}")
    bpy.ops.lumenray.analyse_environment(use_picture=False)
    bpy.app.timers.register(ask_picture_sun, first_interval=3.0)


def ask_picture_sun():
    """Ask for a drag of the picture's sun about the vertical."""
    handle = find_picture_sun()
    tell("picture_before " + " ".join(f"{value:.3f}" for value in handle))
    view = area_of().spaces.active.region_3d
    view.view_location = (0.0, 0.0, 1.0)
    bpy.app.timers.register(ask_picture_drag, first_interval=2.0)


def ask_picture_drag():
    """Say where the handle is."""
    x, y = on_screen(3.0 * find_picture_sun())
    ask("picture", (x, y), (x - 110, y))
    bpy.app.timers.register(wait_for_picture, first_interval=1.0)


def find_picture_sun():
    """Direction to the sun of the world's picture, by its handle."""
    from bl_ext.user_default.lumenray.blender_addon.sun_handle import sun_of_picture

    return sun_of_picture(bpy.context.scene.world)


def wait_for_picture():
    """End when the gesture is over."""
    if not (FOLDER / "picture.done").exists():
        return 0.5
    tell("picture_after " + " ".join(f"{value:.3f}" for value in find_picture_sun()))
    (FOLDER / "end.txt").write_text("\n", encoding="ascii")
    return None


def start():
    """Begin when the window is there."""
    build()
    bpy.app.timers.register(start_shadow, first_interval=4.0)


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(start, first_interval=2.0)
