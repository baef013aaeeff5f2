"""Use the rendered view in a real Blender window: ``--python viewport.py -- PART FOLDER [REPEATS]``.

``look``: what is seen. ``faults``: a killed and a stopped engine, shading, files, the extension. ``memory``: many edits and
resizes. ``save``, ``quit``, ``render`` and ``rendered_view`` serve `watch_viewport.py`, which ends Blender in several ways.

Pictures of the screen and ``PART.json`` are written to FOLDER. Blender quits at the end.
"""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils import Quaternion, Vector

sys.path.insert(0, str(Path(__file__).parent))

import stage
import window
from window import blocks, module, region, settle, space, take_picture, view, wait_for

PART, FOLDER = sys.argv[sys.argv.index("--") + 1 :][:2]
FOLDER = Path(FOLDER)

REPEATS = float((sys.argv[sys.argv.index("--") + 3 :] or ["1"])[0])
"""Share of the edits and resizes that ``memory`` makes."""

MODES = {"Standard": "standard", "AgX": "agx"}
"""View transforms and their names in files."""

BLOCK = 16
"""Side of the squares that pictures are compared in. [pixel]"""

NOISE = 6.0
"""Most by which the same square may differ in two pictures of the same scene, of 255."""

RED_WEIGHTS = np.array([0.2126, 0.7152, 0.0722])
"""Weights of linear Rec. 709 red, green and blue in the relative luminance (ITU-R BT.709)."""

record = window.Record(FOLDER / f"{PART}.json")


def set_up():
    """Build the scene and show it, rendered, through its camera."""
    window.prepare_window()
    stage.build()
    # The sizes of regions follow the preferences when the window is drawn.
    yield 0.5
    window.look_through_camera()
    space().shading.type = "RENDERED"
    taken = yield from settle()
    record.measure("seconds to the first complete picture", round(taken, 1))
    record.check(
        view().status.samples >= stage.SAMPLES, f"the view has {view().status.samples} samples"
    )


def difference(first, second):
    """Return by how much two pictures differ in every square: the largest of red, green and blue."""
    return np.abs(blocks(first, BLOCK) - blocks(second, BLOCK)).max(axis=-1)


def check_same(first, second, text, allowed=NOISE):
    """Note whether two pictures show the same."""
    apart = difference(first, second)
    worst = f"squares differ by {apart.mean():.2f} on the average and {apart.max():.2f} at most"
    record.check(apart.max() < allowed, f"{text}: {worst} of 255")


# ---- look ----


def object_moved():
    """Move the block to and fro; the picture changes where it was and is."""
    block = bpy.data.objects["Block"]
    for transform, step in (("Standard", 1.5), ("AgX", -1.5)):
        name = MODES[transform]
        bpy.context.scene.view_settings.view_transform = transform
        yield from settle()
        before = take_picture(FOLDER / f"moved_{name}_before.png")
        was = window.bounds_on_screen(block)
        begin = time.monotonic()
        block.location.x += step
        yield from wait_for(lambda: view().status.changed == "1 object moved", "the edit", 10.0)
        edit_seconds = time.monotonic() - begin
        record.check(True, f"{transform}: the status says '1 object moved'")
        yield from settle()
        after = take_picture(FOLDER / f"moved_{name}_after.png")
        seconds = round(time.monotonic() - begin, 1)
        record.measure(f"{transform}: seconds until the edit was sent", round(edit_seconds, 2))
        record.measure(f"{transform}: seconds until the picture was complete", seconds)
        check_change(before, after, (was, window.bounds_on_screen(block)), transform)


def check_change(before, after, bounds, text):
    """Note whether a picture has changed inside of bounds, and away from them and their shadows has not."""
    change = difference(before, after)
    rows, columns = np.indices(change.shape)
    x, y = (columns + 0.5) * BLOCK, (rows + 0.5) * BLOCK
    far = np.ones(change.shape, bool)
    for left, bottom, right, top in bounds:
        inside = (x > left + BLOCK) & (x < right - BLOCK) & (y > bottom + BLOCK) & (y < top - BLOCK)
        record.check(
            change[inside].min() > 10.0,
            f"{text}: changed by {change[inside].min():.1f} or more at {left:.0f}, {bottom:.0f}",
        )
        reach = 0.7 * (right - left)
        far &= (x < left - reach) | (x > right + reach) | (y < bottom - reach) | (y > top + reach)
    record.check(
        far.any() and change[far].max() < NOISE,
        f"{text}: elsewhere ({far.mean():.0%}) changed by {change[far].max():.1f} at most",
    )


def same_as_render():
    """Compare the view through the camera with F12."""
    scene = bpy.context.scene
    window.look_through_camera()
    for transform, name in MODES.items():
        scene.view_settings.view_transform = transform
        yield from settle()
        shown = take_picture(FOLDER / f"compared_{name}_view.png")
        scene.render.image_settings.file_format = "PNG"
        scene.render.filepath = str(FOLDER / f"compared_{name}_render.png")
        bpy.ops.render.render(write_still=True)
        yield 0.5
        rendered = window.read_picture(scene.render.filepath)
        record.check(
            shown.shape == rendered.shape,
            f"view {shown.shape[1]} x {shown.shape[0]}, render {rendered.shape[1]} x {rendered.shape[0]}",
        )
        # The window rounds the view's corners and draws a button at its right edge.
        shown, rendered = (picture[BLOCK:-BLOCK, BLOCK:-BLOCK] for picture in (shown, rendered))
        check_same(shown, rendered, f"{transform}: view and F12", 2.0)
        signed = (blocks(shown, BLOCK) - blocks(rendered, BLOCK)).mean(axis=(0, 1))
        record.measure(
            f"{transform}: view minus F12, red, green, blue", np.round(signed, 3).tolist()
        )


def decode(picture):
    """Return linear values of a picture under the view transform Standard."""
    encoded = picture / 255.0
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def luminance_shown():
    """Compare the view without colour with the luminance of the view in colour."""
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Standard"
    yield from settle()
    colour = take_picture(FOLDER / "luminance_colour.png")
    scene.lumenray.viewport.display = "LUMINANCE"
    yield from settle()
    grey = take_picture(FOLDER / "luminance_grey.png")
    scene.lumenray.viewport.display = "PICTURE"
    record.check(np.ptp(grey, axis=-1).max() < 1.5, "the luminance has no colour")
    inside = blocks(colour, BLOCK).max(axis=-1) < 240.0
    expected = blocks(decode(colour) @ RED_WEIGHTS[:, None], BLOCK)[..., 0]
    found = blocks(decode(grey), BLOCK)[..., 0]
    worst = np.abs(found / expected - 1.0)[inside].max()
    record.check(worst < 0.03, f"luminance and colour agree within {worst:.1%}")


def heart_of(picture, item, share=0.6):
    """Return the pixels in the middle share of an object's width and height: so many that noise does not count."""
    left, bottom, right, top = window.bounds_on_screen(item)
    width, height = 0.5 * (1.0 - share) * (right - left), 0.5 * (1.0 - share) * (top - bottom)
    return picture[
        round(bottom + height) : round(top - height), round(left + width) : round(right - width)
    ]


def check_colour(pixels, value, low, high, text, logarithmic=False):
    """Note whether pixels have the scale's colour of a value on the average."""
    colours = module("engine.analysis.false_colour").colours
    if logarithmic:
        value, low, high = np.log10(value), np.log10(low), np.log10(high)
    wanted = colours(np.array([value]), low, high)[0].astype(float)
    found = pixels.mean(axis=(0, 1))
    record.check(
        np.abs(found - wanted).max() < 2.0,
        f"{text}: {np.round(found).astype(int).tolist()} for {wanted.astype(int).tolist()}",
    )


def check_scale(picture):
    """Note whether the scale at the left edge has its own colours."""
    colours = module("engine.analysis.false_colour").colours
    drawing = module("blender_addon.rendering.view_drawing")
    column = picture[:, drawing.SCALE_MARGIN + drawing.SCALE_WIDTH // 2]
    for name, band in (("lowest", 0), ("middle", 32), ("highest", drawing.SCALE_STEPS - 1)):
        share = (band + 0.5) / drawing.SCALE_STEPS
        wanted = colours(np.array([share]), 0.0, 1.0)[0].astype(float)
        apart = np.abs(column - wanted).max(axis=-1).min()
        record.check(apart < 3.0, f"scale: the {name} colour is there within {apart:.1f} of 255")


def false_colours():
    """Compare the colours on the screen with those of the scale at known values."""
    settings = bpy.context.scene.lumenray
    panel = bpy.data.objects["Panel"]
    for transform, name in MODES.items():
        bpy.context.scene.view_settings.view_transform = transform
        settings.viewport.display = "FALSE_LUMINANCE"
        settings.viewport.automatic, settings.viewport.low, settings.viewport.high = False, 0, 2700
        yield from settle()
        picture = take_picture(FOLDER / f"false_luminance_{name}.png")
        text = f"{transform}: {stage.PANEL:g} cd/m²"
        check_colour(heart_of(picture, panel), stage.PANEL, 0, 2700, text)
    settings.viewport.low, settings.viewport.logarithmic = 1.0, True
    yield from settle()
    picture = take_picture(FOLDER / "false_luminance_logarithmic.png")
    check_colour(heart_of(picture, panel), stage.PANEL, 1, 2700, "logarithmic", True)
    settings.viewport.logarithmic = False
    settings.viewport.low, settings.viewport.high = 0.0, 900.0
    settings.viewport.display = "FALSE_ILLUMINANCE"
    yield from settle()
    take_picture(FOLDER / "false_illuminance.png")
    stage.leave_sun_only()
    yield from settle()
    picture = take_picture(FOLDER / "false_illuminance_sun.png")
    # A tenth: the floor reaches out of the view, and the scale lies over its left part.
    floor = heart_of(picture, bpy.data.objects["Floor"], 0.1)
    check_colour(floor, stage.SUN, 0, 900, f"{stage.SUN:g} lx")
    check_scale(picture)
    frame = view().frame
    record.check(
        (frame.low, frame.high, frame.unit) == (0.0, 900.0, "lx"),
        f"the scale goes from {frame.low:g} to {frame.high:g} {frame.unit}",
    )
    settings.viewport.automatic = True
    settings.viewport.display = "PICTURE"


VIEWS = (
    # name, perspective, turn about z and x [degrees], location, distance
    ("perspective", "PERSP", 0.0, 80.0, (0.5, 0.5, 1.0), 6.0),
    ("turned", "PERSP", 25.0, 65.0, (0.5, 0.5, 1.0), 6.0),
    ("panned", "PERSP", -20.0, 75.0, (2.0, 0.5, 1.6), 6.0),
    ("near", "PERSP", 0.0, 85.0, (1.5, 1.5, 1.7), 1.7),
    ("orthographic", "ORTHO", 0.0, 80.0, (0.5, 0.5, 1.0), 6.0),
    ("orthographic turned", "ORTHO", 30.0, 60.0, (1.0, 0.5, 1.5), 4.0),
)

CAMERA_VIEWS = (("camera", 0.0, (0.0, 0.0)), ("camera zoomed", 20.0, (0.12, 0.08)))
"""Name, zoom, offset."""


def aligned():
    """Compare where the panel is in the picture with where Blender draws its corners."""
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Standard"
    stage.build()
    scene.lumenray.viewport.samples = 16
    # Nothing but the panel may be as bright as white.
    scene.lumenray.white_luminance = 0.6 * stage.PANEL
    bpy.data.lights["Lamp"].lumenray.value = 900.0
    shown = space().region_3d
    for name, perspective, about_z, about_x, location, distance in VIEWS:
        shown.view_perspective = perspective
        turn_z = Quaternion((0.0, 0.0, 1.0), np.radians(about_z))
        shown.view_rotation = turn_z @ Quaternion((1.0, 0.0, 0.0), np.radians(about_x))
        shown.view_location, shown.view_distance = Vector(location), distance
        yield from check_alignment(name)
    for name, zoom, offset in CAMERA_VIEWS:
        shown.view_perspective = "CAMERA"
        shown.view_camera_zoom, shown.view_camera_offset = zoom, offset
        yield from check_alignment(name)


def check_alignment(name):
    """Note whether the panel is where it should be."""
    yield from settle()
    picture = take_picture(FOLDER / f"aligned_{name.replace(' ', '_')}.png")
    expected = np.array(window.bounds_on_screen(bpy.data.objects["Panel"]))
    rows, columns = np.nonzero(picture.min(axis=-1) > 250.0)
    if not rows.size:
        record.check(False, f"{name}: the panel is not in the picture")
        return
    found = np.array([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1])
    apart = np.abs(found - expected).max()
    inside = (expected[:2] > 0).all() and (expected[2:] < picture.shape[1::-1]).all()
    record.check(
        inside and apart < 1.5,
        f"{name}: panel at {found.tolist()}, corners at {np.round(expected, 1).tolist()}",
    )


# ---- faults ----


def lose_engine(number, seconds):
    """Send the engine a signal while the view renders, as it does after an edit, and wait until the view tells."""
    yield 0.7
    pid = window.engine_pid()
    record.check(view()._feed.session.has_view_work, "the view renders")
    os.kill(pid, number)
    taken = yield from wait_for(lambda: view().status.is_error, "the message", seconds)
    record.measure(f"{signal.Signals(number).name}: seconds to the message", round(taken, 1))
    return pid


def check_words(text):
    """Note what the view says of the engine."""
    message = view().status.message
    record.check(view().text() == message and len(message) > 20, f"{text}: '{message}'")


def turn(degrees):
    """Turn the view about the vertical."""
    shown = space().region_3d
    shown.view_rotation = (
        Quaternion((0.0, 0.0, 1.0), np.radians(degrees)) @ shown.view_rotation.copy()
    )
    window.redraw()


def leave_camera():
    """Look from about where the camera stands."""
    shown = space().region_3d
    shown.view_perspective = "PERSP"
    shown.view_rotation = Quaternion((1.0, 0.0, 0.0), np.radians(78.0))
    shown.view_location, shown.view_distance = Vector((0.0, 0.0, 0.8)), 5.5


def killed():
    """Kill the engine, then turn the view; kill it, then edit."""
    leave_camera()
    yield from window.show_tab()
    yield from settle()
    reference = take_picture(FOLDER / "killed_reference.png")
    turn(20.0)
    pid = yield from lose_engine(signal.SIGKILL, 15.0)
    check_words("killed")
    yield 1.0
    take_picture(FOLDER / "killed_message.png")
    record.check(window.engine_pid() is None, "no engine comes by itself")
    yield from check_return(lambda: turn(-20.0), pid, reference, "turned after a kill")
    space().show_region_ui = False
    lamp = bpy.data.lights["Lamp"].lumenray
    yield from settle()
    reference = take_picture(FOLDER / "killed_reference.png")
    lamp.value = 500.0
    pid = yield from lose_engine(signal.SIGKILL, 15.0)

    def edit():
        lamp.value = 3000.0

    yield from check_return(edit, pid, reference, "edited after a kill")


def stopped():
    """Stop the engine, then turn the view."""
    leave_camera()
    yield from settle()
    reference = take_picture(FOLDER / "stopped_reference.png")
    turn(20.0)
    pid = yield from lose_engine(signal.SIGSTOP, 25.0)
    check_words("stopped")
    yield from check_return(lambda: turn(-20.0), pid, reference, "turned after a stop")


def check_return(action, old_pid, reference, text):
    """Note whether an action brings a new engine and the right picture."""
    action()
    begin = time.monotonic()
    yield from wait_for(lambda: window.engine_pid() not in {None, old_pid}, "a new engine", 30.0)
    yield from settle()
    record.measure(f"{text}: seconds to the picture", round(time.monotonic() - begin, 1))
    record.check(
        not view().status.is_error and not view().status.message, f"{text}: no message is left"
    )
    check_same(reference, take_picture(FOLDER / f"{text.replace(' ', '_')}.png"), text)


def shading_toggled():
    """Leave rendered shading and come back; the engine has kept the scene."""
    yield from settle()
    reference = take_picture(FOLDER / "toggled_reference.png")
    pid = window.engine_pid()
    session = view()._feed.session
    revision = session.revision
    space().shading.type = "SOLID"
    yield from wait_for(lambda: view() is None, "the view left", 10.0)
    yield 0.5
    space().shading.type = "RENDERED"
    taken = yield from settle()
    record.measure("back in rendered shading: seconds to the picture", round(taken, 1))
    record.check(window.engine_pid() == pid, "the engine is the same")
    record.check(
        view()._feed.session is session and session.revision == revision,
        f"nothing was sent: '{view().status.changed}', revision {revision} -> {session.revision}",
    )
    check_same(reference, take_picture(FOLDER / "toggled.png"), "back in rendered shading")
    space().shading.type = "SOLID"
    yield from wait_for(lambda: view() is None, "the view left", 10.0)
    bpy.data.objects["Block"].location.x += 1.0
    yield 0.5
    space().shading.type = "RENDERED"
    yield from settle()
    record.check(
        view().status.changed == "1 object moved",
        f"after an edit meanwhile: '{view().status.changed}', {view().status.sent} sent",
    )
    bpy.data.objects["Block"].location.x -= 1.0
    yield from settle()
    check_same(reference, take_picture(FOLDER / "toggled_edit.png"), "after an edit meanwhile")


def two_views():
    """Show the scene in two views at once and edit it."""
    reference = take_picture(FOLDER / "two_reference.png")
    other = next(area for area in window.window().screen.areas if area.type == "PROPERTIES")
    other.type = "VIEW_3D"
    second = other.spaces.active
    second.overlay.show_overlays = second.show_gizmo = second.show_region_ui = False
    second.region_3d.view_perspective = "CAMERA"
    second.shading.type = "RENDERED"
    yield from settle(other)
    yield from settle()
    record.check(view(other) is not view(), "two views")
    first_before = take_picture(FOLDER / "two_before.png")
    second_before = take_picture(FOLDER / "two_before.png", window.region_of(other))
    record.check(second_before.std() > 10.0, f"the second is not plain ({second_before.std():.0f})")
    check_same(reference, first_before, "the first is as it was alone")
    bpy.data.objects["Block"].location.x += 1.2
    yield from settle(other)
    yield from settle()
    first_after = take_picture(FOLDER / "two_after.png")
    second_after = take_picture(FOLDER / "two_after.png", window.region_of(other))
    for name, before, after in (
        ("first", first_before, first_after),
        ("second", second_before, second_after),
    ):
        change = difference(before, after).max()
        record.check(change > 20.0, f"the {name} view shows the edit ({change:.0f})")
    bpy.data.objects["Block"].location.x -= 1.2
    other.type = "PROPERTIES"
    yield from settle()
    views = len(module("blender_addon.rendering.viewport")._views)
    record.check(views == 1, f"the second view is gone: {views} left")
    textures = len(module("blender_addon.rendering.view_drawing")._textures)
    record.check(textures == 1, f"its texture is gone: {textures} left")
    check_same(reference, take_picture(FOLDER / "two_alone.png"), "the first, alone again")


def local_view():
    """Look at the block alone, and at everything again."""
    reference = take_picture(FOLDER / "local_reference.png")
    for item in bpy.context.view_layer.objects:
        item.select_set(item.name in {"Block", "Lamp"})
    with window.override():
        bpy.ops.view3d.localview(frame_selected=False)
    yield from settle()
    alone = take_picture(FOLDER / "local.png")
    left, bottom, right, top = (
        round(v) for v in window.bounds_on_screen(bpy.data.objects["Block"])
    )
    red = alone[bottom + 20 : top - 20, left + 20 : right - 20].mean(axis=(0, 1))
    record.check(red[0] > 3.0 * red[1], f"local view: the block is there, {np.round(red)}")
    below = alone[BLOCK : bottom - BLOCK, BLOCK:-BLOCK]
    spread = below.std(axis=(0, 1)).max()
    record.check(spread < 4.0, f"local view: the floor is not there, spread {spread:.2f}")
    with window.override():
        bpy.ops.view3d.localview(frame_selected=False)
    yield from settle()
    check_same(reference, take_picture(FOLDER / "local_left.png"), "local view left")


def file_loaded():
    """Save, load again: the engine ends with the file, and a new one shows the loaded one."""
    bpy.ops.object.select_all(action="DESELECT")
    yield from settle()
    reference = take_picture(FOLDER / "file_reference.png")
    pid = window.engine_pid()
    path = str(FOLDER / "stage.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    record.check(not is_process(pid), "loading a file ends the engine")
    yield 0.5
    # Blender loads files in solid shading.
    space().shading.type = "RENDERED"
    yield from settle()
    record.check(window.engine_pid() not in {None, pid}, "a new engine serves the file")
    check_same(reference, take_picture(FOLDER / "file_loaded.png"), "the loaded file")
    pid = window.engine_pid()
    bpy.ops.wm.read_homefile()
    record.check(not is_process(pid), "a new file ends the engine")
    yield 1.0
    record.check(window.engine_pid() is None, "solid shading starts no engine")
    bpy.ops.wm.open_mainfile(filepath=path)
    yield 0.5
    space().shading.type = "RENDERED"
    yield from settle()
    check_same(reference, take_picture(FOLDER / "file_again.png"), "the file once more")


def is_process(pid):
    """Tell whether a process runs; a dead one that nobody has taken notice of does not."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def extension_disabled():
    """Disable the extension while the view renders, and enable it again."""
    yield from settle()
    reference = take_picture(FOLDER / "disabled_reference.png")
    bpy.context.scene.lumenray.viewport.samples = 4096
    window.redraw()
    yield 0.5
    pid = window.engine_pid()
    bpy.ops.preferences.addon_disable(module=window.PACKAGE)
    record.check(not is_process(pid), "disabling the extension ends the engine")
    yield 1.0
    take_picture(FOLDER / "disabled.png")
    bpy.ops.preferences.addon_enable(module=window.PACKAGE)
    yield 0.5
    scene = bpy.context.scene
    scene.lumenray.viewport.samples = stage.SAMPLES
    scene.render.engine = "LUMENRAY"
    space().shading.type = "RENDERED"
    yield from settle()
    check_same(reference, take_picture(FOLDER / "enabled.png"), "the extension enabled again")


# ---- memory ----


def memory():
    """Return resident memory [MiB] and open files of Blender and the engine."""
    found = {}
    for name, pid in (("Blender", os.getpid()), ("engine", window.engine_pid())):
        status = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
        size = next(line for line in status.splitlines() if line.startswith("VmRSS"))
        files = len(list(Path(f"/proc/{pid}/fd").iterdir()))
        found[name] = (round(int(size.split()[1]) / 1024.0, 1), files)
    return found


def check_flat(first, last, text):
    """Note whether memory and files have not grown."""
    for name, (size, files) in last.items():
        old_size, old_files = first[name]
        record.check(
            size < old_size + max(0.05 * old_size, 40.0),
            f"{text}: memory of {name} {old_size} -> {size} MiB",
        )
        record.check(files <= old_files + 4, f"{text}: open files of {name} {old_files} -> {files}")
    textures = len(module("blender_addon.rendering.view_drawing")._textures)
    record.check(textures == 1, f"{text}: {textures} texture")


def resized():
    """Resize the view by the sidebar and by the window."""
    count = round(200 * REPEATS)
    sizes = set()
    first = None
    begin = time.monotonic()
    changes = 0
    for number in range(count):
        old = (region().width, region().height)
        if number % 2:
            space().show_region_ui = not space().show_region_ui
        else:
            width, height = 790 - 8 * (number % 23), 550 - 5 * (number % 31)
            order = ["xdotool", "search", "--class", "blender", "windowsize"]
            subprocess.run([*order, str(width), str(height)], check=True)
        yield from wait_for(
            lambda old=old: (region().width, region().height) != old, "the resize", 5.0
        )
        yield 0.1
        changes += 1
        sizes.add((region().width, region().height))
        if number == count // 4:
            yield from settle()
            first = memory()
    record.measure("seconds of the resizes", round(time.monotonic() - begin, 1))
    record.check(changes == count, f"{changes} resizes, {len(sizes)} different sizes")
    yield from settle()
    check_flat(first, memory(), f"{count} resizes")
    frame = view().frame
    record.check(
        frame.pixels.shape[:2] == (region().height, region().width),
        "the picture has the size of the view",
    )


def edited():
    """Edit the scene again and again while the view renders."""
    count = round(1000 * REPEATS)
    edits = (move, dim, paint, add, delete, rename, move, paint)
    first = None
    begin = time.monotonic()
    shown = 0
    for number in range(count):
        edit = edits[number % len(edits)]
        edit(number)
        before = view().frame_number
        # Every third edit waits for a picture of it, the others come faster than the engine works.
        if number % 3 == 0 and edit is not rename:
            yield from wait_for(
                lambda before=before: view().frame_number != before, "a picture", 20.0
            )
        shown += view().frame_number != before
        yield window.TICK
        if number == count // 10:
            yield from settle()
            first = memory()
            record.measure("memory after the first edits", first)
    record.measure("seconds of the edits", round(time.monotonic() - begin, 1))
    yield from settle()
    check_flat(first, memory(), f"{count} edits")
    record.check(view().status.message == "", "no message after the edits")
    record.check(shown > count // 4, f"{shown} of the edits were shown before the next")


def move(number):
    """Move the block."""
    bpy.data.objects["Block"].location.x = -1.2 + 0.01 * (number % 200 + 1)


def dim(number):
    """Change the lamp."""
    bpy.data.lights["Lamp"].lumenray.value = 2000.0 + 10.0 * (number % 100)


def paint(number):
    """Change the colour of the block."""
    bpy.data.materials["Red"].lumenray.reflectance_color = (0.3 + 0.003 * (number % 100), 0.2, 0.1)


def add(number):
    """Add an object with a mesh of its own."""
    mesh = bpy.data.objects["Block"].data.copy()
    mesh.name = "Added"
    item = bpy.data.objects.new("Added", mesh)
    item.location = (0.005 * (number % 200), 1.0, 0.4)
    bpy.context.scene.collection.objects.link(item)


def delete(number):
    """Delete it."""
    for item in [each for each in bpy.data.objects if each.name.startswith("Added")]:
        mesh = item.data
        bpy.data.objects.remove(item)
        bpy.data.meshes.remove(mesh)


def rename(number):
    """Rename the wall."""
    item = next(each for each in bpy.data.objects if each.name.startswith("Wall"))
    item.name = f"Wall {number}"


# ---- for the watcher ----


def save_long():
    """Save the scene with a render that takes very long."""
    stage.build()
    bpy.context.scene.lumenray.render.samples = 1 << 18
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / "long.blend"))
    yield


def start_render():
    """Press F12, as it were, and wait until the engine computes."""
    stage.build()
    bpy.context.scene.lumenray.render.samples = 1 << 18
    with window.override():
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from wait_for(lambda: window.engine_pid() is not None, "the engine", 30.0)
    yield 2.0
    record.check(bpy.app.is_job_running("RENDER"), "the render runs")


def start_view():
    """Show the view rendered, endlessly."""
    yield from set_up()
    bpy.context.scene.lumenray.viewport.samples = 1 << 18
    window.redraw()
    yield 1.0
    record.check(view()._feed.session.has_view_work, "the view renders")


def stay():
    """Tell that the window can be ended now and do not end."""
    record.write(is_complete=True)
    while True:
        yield 1.0


PARTS = {
    "look": (set_up, object_moved, same_as_render, luminance_shown, false_colours, aligned),
    "faults": (
        set_up,
        killed,
        stopped,
        shading_toggled,
        two_views,
        local_view,
        file_loaded,
        extension_disabled,
    ),
    "memory": (set_up, resized, edited),
    "save": (save_long,),
    "quit": (start_render,),
    "render": (start_render, stay),
    "rendered_view": (start_view, stay),
}

bpy.context.preferences.view.show_splash = False
window.start(PARTS[PART], record, bpy.ops.wm.quit_blender)
