"""Measure the rendered view of the bundled office in a real Blender window: ``--python office_view.py -- office FOLDER``.

After each edit: when the edit was sent, when its first picture was there, and when the view's error fell below `GOALS`. A
picture of the screen and ``office.json`` are written to FOLDER. Blender quits at the end.
"""

import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

import window
from window import module, region, view

PART, FOLDER = sys.argv[sys.argv.index("--") + 1 :][:2]
FOLDER = Path(FOLDER)

GOALS = 0.2, 0.1, 0.05
"""Relative errors of the picture that are waited for. [-]"""

PATIENCE = 120.0
"""How long each of them is waited for. [s]"""

SIZE = 960, 600
"""Least width and height of the view. [pixel]"""

EDITS = 3
"""How often the light is edited."""

record = window.Record(FOLDER / f"{PART}.json")


def show_office():
    """Open the office and show it, rendered, through its camera."""
    path = module("libraries.scenes").scene_path("office")
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    yield 1.0
    window.prepare_window()
    yield 0.5
    window.look_through_camera()
    bpy.context.scene.lumenray.viewport.samples = 1 << 16
    size = region().width, region().height
    record.check(all(has >= least for has, least in zip(size, SIZE, strict=True)), f"view: {size}")
    begin = time.monotonic()
    window.space().shading.type = "RENDERED"
    window.redraw()
    yield from wait_for_picture(begin, "opened", 0)
    yield from wait_for_errors(begin, "opened")


def dim_light():
    """Dim a panel to and fro."""
    light = next(data for data in bpy.data.lights if data.name.startswith("LED Panel"))
    full = light.lumenray.value
    for number in range(EDITS):
        name = f"edit {number + 1} of a light"
        revision = view().frame.revision
        begin = time.monotonic()
        light.lumenray.value = (0.5 if number % 2 == 0 else 1.0) * full
        yield from wait_for_picture(begin, name, revision)
    yield from wait_for_errors(begin, name)


def wait_for_picture(begin, name, revision):
    """Wait until a picture of a later state of the scene is there."""

    def is_there():
        frame = view() and view().frame
        return frame is not None and frame.revision > revision

    yield from window.wait_for(is_there, name, PATIENCE)
    record.measure(f"{name}: seconds to its first picture", round(time.monotonic() - begin, 2))
    told = view().status
    record.measure(f"{name}: of these, walk and transfer", round(told.walk + told.transfer, 3))
    record.measure(
        f"{name}: the engine's, by its own clock", round(told.commit + told.first_sample, 3)
    )


def wait_for_errors(begin, name):
    """Wait until the view is as exact as it can be expected to be, and note what it reached."""
    for goal in GOALS:
        try:
            yield from window.wait_for(
                lambda goal=goal: view().status.error <= goal, name, PATIENCE
            )
        except TimeoutError:
            reached = f"{view().status.error:.1%} after {time.monotonic() - begin:.0f} s"
            record.measure(f"{name}: {goal:.0%} not reached", reached)
            break
        told = f"{time.monotonic() - begin:.1f} with {view().status.samples} samples"
        record.measure(f"{name}: seconds to {goal:.0%}", told)
    window.take_picture(FOLDER / f"{PART}_{name.replace(' ', '_')}.png")


bpy.context.preferences.view.show_splash = False
window.start([show_office, dim_light], record, bpy.ops.wm.quit_blender)
