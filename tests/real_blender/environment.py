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

STILL = 3
"""Rounds after which what has not moved stands still."""

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


def follow(name: str, read, then) -> None:
    """Go on with ``then(value)`` when the mouse has let go and what it drags, ``read()``, stands still.

    Events wait in a busy window: a gesture is over when nothing has moved for some rounds of Blender's loop. ``NAME.moved``
    says that what is dragged has arrived, with the button still down.
    """
    state = {"value": read(), "start": read(), "still": 0}

    def look():
        value = read()
        state["still"] = state["still"] + 1 if value == state["value"] else 0
        state["value"] = value
        if value != state["start"] and state["still"] >= STILL:
            (FOLDER / f"{name}.moved").touch()
        if not (FOLDER / f"{name}.done").exists() or state["still"] < 2 * STILL:
            return 0.5
        then(value)
        return None

    bpy.app.timers.register(look, first_interval=0.5)


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
    follow("shadow", sun_towards, tell_shadow)


def sun_towards():
    """Direction to the photo's sun, None while there is none. (3,)"""
    lamp = bpy.data.objects.get("Photo Sun")
    return None if lamp is None else tuple(lamp.matrix_world.col[2][:3])


def tell_shadow(towards):
    """Say by how much the sun is off. [degree]"""
    off = 180.0
    if towards is not None:
        off = math.degrees(math.acos(min(float(np.array(towards) @ TOWARDS), 1.0)))
    tell(f"shadow {off:.3f}")
    if towards is None:
        # Nothing is left to be dragged.
        (FOLDER / "end.txt").write_text("\n", encoding="ascii")
        return
    start_ground()


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
    settings = bpy.context.scene.world.lumenray.ground
    follow("ground", lambda: settings.level, tell_ground)


def tell_ground(level):
    """Say how high the ground is, and go on with the sun's handle. [m]"""
    tell(f"ground {level:.3f}")
    bpy.context.scene.world.lumenray.ground.level = 0.0
    bpy.context.scene.world.lumenray.arc.radius = 3.0
    bpy.app.timers.register(ask_sun, first_interval=2.0)


def ask_sun():
    """Ask for a drag of the sun's handle by the width of a hand."""
    place = np.array([0.0, -6.0, 0.0]) + 3.0 * np.array(sun_towards())
    x, y = on_screen(place)
    tell("sun_before " + " ".join(f"{value:.3f}" for value in sun_towards()))
    ask("sun", (x, y), (x - 90, y + 40))
    follow("sun", sun_towards, tell_sun)


def tell_sun(towards):
    """Say where the sun is now, and go on with a dropped picture."""
    tell("sun_after " + " ".join(f"{value:.3f}" for value in towards))
    drop()


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
    # Blender asks what the picture is to be, as an empty or a camera may show it too.
    (FOLDER / "drop.txt").write_text("\n", encoding="ascii")
    follow("drop", dropped_name, tell_drop)


def dropped_name() -> str:
    """Name of the image that the world shows."""
    nodes = bpy.context.scene.world.node_tree.nodes
    images = [n.image for n in nodes if n.type == "TEX_ENVIRONMENT" and n.image]
    return images[0].name if images else "-"


def tell_drop(name):
    """Say what was dropped, and analyse it."""
    tell(f"dropped {name}")
    if name == "-":
        bpy.ops.lumenray.load_environment(filepath=PICTURE)
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
    x, y = on_screen(3.0 * np.array(find_picture_sun()))
    ask("picture", (x, y), (x - 110, y))
    follow("picture", find_picture_sun, tell_picture)


def find_picture_sun():
    """Direction to the sun of the world's picture, by its handle."""
    from bl_ext.user_default.lumenray.blender_addon.sun_handle import sun_of_picture

    return tuple(sun_of_picture(bpy.context.scene.world))


def tell_picture(towards):
    """Say where the sun of the picture is now, and end."""
    tell("picture_after " + " ".join(f"{value:.3f}" for value in towards))
    (FOLDER / "end.txt").write_text("\n", encoding="ascii")


def start():
    """Begin when the window is there."""
    build()
    bpy.app.timers.register(start_shadow, first_interval=4.0)


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(start, first_interval=2.0)
