"""Helps scripts that use Blender's window: steps by timer, waiting, pictures of the screen, and a record of checks.

A script is made of generators. What they yield is how long to wait until they go on [s], during which Blender handles
events and draws.
"""

import importlib
import json
import subprocess
import time
import traceback
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from checkout import PACKAGE

TICK = 0.05
"""Shortest wait between two steps. [s]"""

PATIENCE = 120.0
"""How long the engine may take for a picture. [s]"""


def module(name):
    """Return a module of the installed extension by its name in the package."""
    return importlib.import_module(f"{PACKAGE}.{name}")


class Record:
    """What was checked and measured, kept in a file that is complete after every entry."""

    def __init__(self, path):
        self.path = Path(path)
        self.checks = []
        self.numbers = {}
        self.start = time.monotonic()

    def check(self, condition, text):
        """Note whether something holds."""
        self.checks.append({"holds": bool(condition), "text": text})
        print(
            f"[{time.monotonic() - self.start:6.1f} s] {'ok    ' if condition else 'FAILED'} {text}",
            flush=True,
        )
        self.write(is_complete=False)

    def measure(self, name, value):
        """Note a number."""
        self.numbers[name] = value
        print(f"[{time.monotonic() - self.start:6.1f} s]        {name}: {value}", flush=True)

    def write(self, is_complete):
        """Write all entries; a run that ended before its time can be told by the file."""
        content = {"complete": is_complete, "checks": self.checks, "numbers": self.numbers}
        self.path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def start(cases, record, end):
    """Go through generators one after the other by timer; one that fails does not keep the others from running.

    Parameters
    ----------
    cases : list of callable    Each gives a generator.
    record : Record
    end : callable    Called after the last.
    """
    left = list(cases)
    running = None

    def step():
        nonlocal running
        try:
            if running is None:
                if not left:
                    record.write(is_complete=True)
                    end()
                    return None
                print(f"-- {left[0].__name__}", flush=True)
                running = left.pop(0)()
            return max(next(running) or TICK, TICK)
        except StopIteration:
            running = None
        except Exception as error:
            traceback.print_exc()
            running = None
            record.check(False, f"ended by {type(error).__name__}: {error}")
        return TICK

    bpy.app.timers.register(step, first_interval=1.0, persistent=True)


def wait_for(condition, what, seconds=PATIENCE):
    """Wait until a condition holds, and give the time that it took. [s]

    Raises
    ------
    TimeoutError    It did not come to hold.
    """
    begin = time.monotonic()
    while not condition():
        if time.monotonic() - begin > seconds:
            raise TimeoutError(f"{what}: not within {seconds:.0f} s")
        yield TICK
    return time.monotonic() - begin


# ---- what the window shows ----


def window():
    """Return the window; nothing of it outlives the loading of a file, so it is looked up anew every time."""
    return bpy.context.window_manager.windows[0]


def view_area():
    """Return the largest 3D view."""
    areas = [area for area in window().screen.areas if area.type == "VIEW_3D"]
    return max(areas, key=lambda area: area.width * area.height)


def region_of(area, kind="WINDOW"):
    """Return an area's region of a kind."""
    return next(region for region in area.regions if region.type == kind)


def region():
    """Return the region in which the largest 3D view is drawn."""
    return region_of(view_area())


def space():
    """Return what the largest 3D view shows."""
    return view_area().spaces.active


def override(area=None):
    """Return the context in which operators find a 3D view."""
    area = area or view_area()
    return bpy.context.temp_override(window=window(), area=area, region=region_of(area))


def prepare_window():
    """Let the 3D view show the picture alone, so that it can be compared point by point."""
    preferences = bpy.context.preferences
    preferences.view.show_splash = False
    # Sidebars beside the picture, not above it.
    preferences.system.use_region_overlap = False
    shown = space()
    shown.overlay.show_overlays = False
    shown.show_gizmo = False
    shown.show_region_ui = False


def look_through_camera():
    """Let the camera's frame fill the region: Blender's zoom is ((2**0.5 + z / 50) / 2)**2 of the region."""
    render, view = bpy.context.scene.render, space().region_3d
    render.resolution_x, render.resolution_y = region().width, region().height
    render.resolution_percentage = 100
    view.view_perspective = "CAMERA"
    view.view_camera_zoom = 50.0 * (2.0 - 2.0**0.5)
    view.view_camera_offset = (0.0, 0.0)


def redraw():
    """Have all 3D views drawn."""
    for area in window().screen.areas:
        if area.type == "VIEW_3D":
            area.tag_redraw()


def show_tab():
    """Open the sidebar with our tab; it has none before it was drawn."""
    space().show_region_ui = True

    def is_shown():
        try:
            region_of(view_area(), "UI").active_panel_category = "Lumenray"
        except (AttributeError, TypeError):
            redraw()
            return False
        return True

    yield from wait_for(is_shown, "the tab in the sidebar", 10.0)
    view_area().tag_redraw()


# ---- our view ----


def engine_pid():
    """Return the number of the engine's process, None without one."""
    return module("blender_addon.foundation.engine_process").pid()


def view(area=None):
    """Return our view in an area's region (`viewport.Viewport`), None without one."""
    return module("blender_addon.rendering.viewport").view_at(region_of(area or view_area()))


def is_settled(shown):
    """Tell whether a view shows the last picture of the scene as it is."""
    feed = None if shown is None else shown._feed
    if feed is None or feed.session.is_lost or feed.session.has_view_work:
        return False
    return shown.frame is not None and shown.frame.is_final


def describe_view(area=None):
    """Say what a view that does not get done shows, what it waits for, and what the engine wrote last."""
    shown = view(area)
    feed = None if shown is None else shown._feed
    if feed is None:
        return "there is no view" if shown is None else f"the view has no engine: '{shown.text()}'"
    state = feed.session._link.view(feed.session.name)
    parts = [
        f"it says '{shown.text()}'",
        f"the engine {'is gone' if feed.session.is_lost else f'is process {engine_pid()}'}",
        f"the newest picture is of change {shown.frame and shown.frame.revision} of {state.applied}",
        f"last one: {state.is_final}, waiting: {state.frame is not None}, asked for: {state.is_watched}",
        *feed.session._link.log()[-5:],
    ]
    return "; ".join(parts)


def settle(area=None, seconds=PATIENCE):
    """Wait until a view is done and drawn."""
    redraw()
    # An edit reaches the engine with the next drawing.
    for _ in range(4):
        yield TICK
    try:
        taken = yield from wait_for(lambda: is_settled(view(area)), "the view done", seconds)
    except TimeoutError as error:
        raise TimeoutError(f"{error}; {describe_view(area)}") from error
    redraw()
    yield 0.3
    return taken


def take_picture(path, of=None):
    """Take a picture of the screen into a PNG file, and return the part with the 3D view.

    Blender's own `screen.screenshot` gives black pictures without a graphics card.

    Parameters
    ----------
    path : Path
    of : bpy.types.Region or None    Another region to return.

    Returns
    -------
    (h, w, 3) float array    0 to 255, row 0 at the bottom.
    """
    subprocess.run(["import", "-silent", "-window", "root", str(path)], check=True)
    pixels = read_picture(path)
    of = of or region()
    return pixels[of.y : of.y + of.height, of.x : of.x + of.width]


def read_picture(path):
    """Return a PNG file's pixels as they are. (h, w, 3), 0 to 255, row 0 at the bottom."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return 255.0 * pixels.reshape(height, width, -1)[..., :3]


def blocks(picture, size):
    """Return the means over squares of pixels; what does not fill a square is left out."""
    height, width = (length // size for length in picture.shape[:2])
    cut = picture[: height * size, : width * size]
    return cut.reshape(height, size, width, size, -1).mean(axis=(1, 3))


def bounds_on_screen(item):
    """Return where an object's corners are in the region: left, bottom, right, top. [pixel]"""
    corners = [item.matrix_world @ vertex.co for vertex in item.data.vertices]
    view_3d = space().region_3d
    places = np.array([location_3d_to_region_2d(region(), view_3d, corner) for corner in corners])
    return (*places.min(axis=0), *places.max(axis=0))
