"""Drag the suns and the ground of a photomontage and of a world's picture in a window, and drop a picture of surroundings.

Run by ``run_environment.sh``. Pictures of the screen and ``record.json`` with what was checked come to ``/out/environment``.
"""

import math
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Matrix, Vector

sys.path.insert(0, str(Path(__file__).parent))

import mouse
import window
from window import module, take_picture, wait_for

FOLDER = Path("/out/environment")

TOWARDS = np.array([0.5, -0.35, 0.7]) / np.linalg.norm([0.5, -0.35, 0.7])
"""To the sun that the shadow on the floor is of."""

FOOT, TOP = (-1.14, 0.66, 0.0), (-1.14, 0.66, 1.0)
"""Of the post. [m]"""

PICTURES = ("outside.hdr", "outside.exr")
"""What is dropped: what becomes of the first is chosen with the mouse, of the second with the keyboard."""

CHANGED = 20.0
"""By how much a menu that opens changes the screen, of 255."""

WIDE, HIGH = 50, 20
"""What of a menu has changed at least: so many pixels in a row, and so many of such rows."""

RECORD = window.Record(FOLDER / "record.json")


def on_screen(point) -> tuple[int, int]:
    """Where a point of the scene is on the screen, from its upper left corner. [pixel]"""
    region = window.region()
    place = location_3d_to_region_2d(region, window.space().region_3d, Vector(point))
    return round(region.x + place.x), round(window.window().height - (region.y + place.y))


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
    space = window.view_area().spaces.active
    space.shading.type = "SOLID"
    space.region_3d.view_perspective = "CAMERA"
    space.region_3d.view_camera_zoom = 20.0
    space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = False


def find_sun():
    """Direction to the photo's sun, None while there is none. (3,)"""
    lamp = bpy.data.objects.get("Photo Sun")
    return None if lamp is None else tuple(lamp.matrix_world.col[2][:3])


def find_picture_sun():
    """Direction to the sun of the world's picture, by its handle. (3,)"""
    return tuple(module("blender_addon.sun_handle").sun_of_picture(bpy.context.scene.world))


def look_from_aside(place):
    """Look at a place from aside, and wait until that is drawn."""
    view = window.space().region_3d
    view.view_perspective = "PERSP"
    view.view_location, view.view_distance = place, 12.0
    view.view_rotation = Vector((0.3, -1.0, 0.45)).to_track_quat("Z", "Y")
    view.update()
    for _ in range(10):
        window.redraw()
        yield window.TICK


# ---- what is done ----


def sun_by_shadow():
    """Tell the sun by the foot of the post, its top and the end of its shadow."""
    listener = mouse.Listener(module("operators.sun_from_shadow").LUMENRAY_OT_sun_from_shadow)
    with window.override():
        bpy.ops.lumenray.sun_from_shadow("INVOKE_DEFAULT")
    foot, top, end = map(on_screen, (FOOT, TOP, np.array(TOP) - TOWARDS * (TOP[2] / TOWARDS[2])))
    yield from mouse.move(foot, lambda: listener.is_at(foot), "the mouse at the foot")
    yield from mouse.press(lambda: listener.places == 1, "the foot")
    mouse.do("mouseup", 1)
    yield from mouse.move(top, lambda: listener.is_at(top), "the mouse at the top")
    yield from mouse.press(lambda: listener.places == 2, "the top")
    yield from mouse.drag_to(
        top, end, lambda: listener.is_at(end) and find_sun() is not None, "the shadow's end"
    )
    take_picture(FOLDER / "shadow.png")
    yield from mouse.release(lambda: not listener.is_running, "the end of the drag")
    off = math.degrees(math.acos(min(float(np.array(find_sun()) @ TOWARDS), 1.0)))
    RECORD.measure("sun by its shadow, degrees off", round(off, 3))
    RECORD.check(off < 1.0, "the sun is within a degree of the one that threw the shadow")


def ground_by_arrow():
    """Raise the ground by its arrow, which stands below the camera."""
    handle = mouse.handle_of("LUMENRAY_GGT_ground", "arrow")
    yield from look_from_aside((0.0, -3.0, 0.5))
    settings = bpy.context.scene.world.lumenray.ground
    x, y = on_screen((0.0, -6.0, 0.0))
    yield from mouse.drag_handle(
        handle, (x, y - 45), (x, y - 125), lambda: settings.level, FOLDER / "ground.png"
    )
    RECORD.measure("ground raised by, m", round(settings.level, 3))
    RECORD.check(settings.level > 0.2, "the ground follows its arrow")
    settings.level = 0.0


def sun_by_handle():
    """Drag the photo's sun by its handle."""
    bpy.context.scene.world.lumenray.arc.radius = 3.0
    handle = mouse.handle_of("LUMENRAY_GGT_surroundings_sun", "handle")
    yield from look_from_aside((0.0, -3.0, 0.5))
    before = np.array(find_sun())
    x, y = on_screen(np.array([0.0, -6.0, 0.0]) + 3.0 * before)
    yield from mouse.drag_handle(handle, (x, y), (x - 90, y + 40), find_sun, FOLDER / "sun.png")
    RECORD.check(np.linalg.norm(before - find_sun()) > 0.1, "the sun follows its handle")
    bpy.data.objects.remove(bpy.data.objects["Photo Sun"])
    ground = bpy.context.scene.world.lumenray.ground
    ground.photo, ground.use_ground = "NONE", False


def picture_by_mouse():
    """Drop a picture from outside, and choose our item of the menu that opens with the mouse."""

    def choose(path, left, low, right, high):
        # Ours is the lower one of two.
        screen = window.window().height
        place = int(left + right) // 2, int(screen - low - (high - low) // 4)
        mouse.do("mousemove", *place)
        yield from still_picture(path)
        mouse.do("click", 1)

    yield from drop(PICTURES[0], choose)


def picture_by_keyboard():
    """Drop a picture from outside, and choose our item by the letter that is underlined in it."""

    def choose(*_):
        mouse.do("key", "l")
        yield window.TICK

    yield from drop(PICTURES[1], choose)


def drop(name, choose):
    """Drop a picture on the middle of the 3D view, and require it as the world's.

    ``choose(path, left, low, right, high)`` chooses from the menu, which is there on the screen [pixel].
    """
    region = window.region()
    x = region.x + region.width // 2
    y = window.window().height - (region.y + region.height // 2)
    mouse.do("mousemove", x, y)
    path = FOLDER / f"drop_{name.rpartition('.')[2]}.png"
    before = yield from still_picture(path)
    command = ["python3", str(Path(__file__).parent / "drag_file.py"), str(FOLDER / name)]
    with subprocess.Popen([*command, str(x), str(y)], stderr=subprocess.PIPE, text=True) as drag:
        yield from wait_for(lambda: drag.poll() is not None, "the file dropped", mouse.HEARD)
        RECORD.check(drag.returncode == 0, f"the window takes {name} {drag.stderr.read().strip()}")
    menu = yield from wait_for_menu(path, before)
    yield from choose(path, *menu)
    yield from wait_for(lambda: dropped_name() == name, f"the world shows {name}", mouse.HEARD)
    RECORD.check(dropped_name() == name, f"the world shows {name}")
    RECORD.check(not any(item.type == "EMPTY" for item in bpy.data.objects), "and nothing else")


def wait_for_menu(path, before):
    """Wait until Blender asks what the picture is to be, as an empty or a camera may show it too.

    Returns
    -------
    (int, int, int, int)    Left, bottom, right and top of what has changed in the view since a picture. [pixel]
    """
    for _ in range(int(mouse.HEARD / 0.6)):
        shown = yield from still_picture(path)
        changed = np.abs(shown - before).max(axis=-1) > CHANGED
        rows = np.flatnonzero(changed.sum(axis=1) > WIDE)
        columns = np.flatnonzero(changed.any(axis=0))
        if len(rows) > HIGH:
            x, y = window.region().x, window.region().y
            return x + columns[0], y + rows[0], x + columns[-1], y + rows[-1]
    raise TimeoutError(f"no menu has opened within {mouse.HEARD:.0f} s")


def still_picture(path):
    """Take pictures of the screen until two are alike, and give the part with the 3D view."""
    last = take_picture(path)
    for _ in range(int(mouse.HEARD / 0.3)):
        yield 0.3
        shown = take_picture(path)
        if not np.abs(shown - last).any():
            return shown
        last = shown
    raise TimeoutError(f"the screen is not still within {mouse.HEARD:.0f} s")


def dropped_name() -> str:
    """Name of the image that the world shows."""
    nodes = bpy.context.scene.world.node_tree.nodes
    images = [n.image for n in nodes if n.type == "TEX_ENVIRONMENT" and n.image]
    return images[0].name if images else "-"


def sun_of_picture():
    """Analyse the picture that was dropped, and turn it by the handle at its sun."""
    bpy.ops.lumenray.analyse_environment(use_picture=False)
    handle = mouse.handle_of("LUMENRAY_GGT_surroundings_sun", "handle")
    yield from look_from_aside((0.0, 0.0, 1.0))
    before = np.array(find_picture_sun())
    x, y = on_screen(3.0 * before)
    yield from mouse.drag_handle(
        handle, (x, y), (x - 110, y), find_picture_sun, FOLDER / "picture.png"
    )
    RECORD.check(
        np.linalg.norm(before - find_picture_sun()) > 0.1, "the sun of the picture follows"
    )


def start():
    """Begin when the window is there."""
    build()
    cases = (
        sun_by_shadow,
        ground_by_arrow,
        sun_by_handle,
        picture_by_mouse,
        picture_by_keyboard,
        sun_of_picture,
    )
    window.start(cases, RECORD, bpy.ops.wm.quit_blender)


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(start, first_interval=2.0)
