"""Moves a slider of a paint and measures when the panel's sphere has followed, and what Blender computed for that.

Run by ``run_paint.sh``; numbers go to ``/out/paint/record.json``. *Clock* is from the move to the sphere in the panel,
*processors* is what drawing the sphere took of them, whatever else the machine does, and *other* is what
Blender takes to draw the panel twice where another value of the material moves, which no sphere shows: all views are
drawn anew, and without a graphics card that is most of it.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import time

import bpy
from window import Record, module, start, wait_for, window

FOLDER = Path("/out/paint")

STEPS = 8
"""Moves of the slider; the first two warm up."""

LIMIT = 0.2
"""Seconds within which the sphere has to follow."""


def follow():
    """Move the thickness of a core, and wait for each sphere."""
    presets, preview = (
        module("blender_addon.paints.presets"),
        module("blender_addon.paints.preview"),
    )
    # Blender's own preview would be rendered beside, during which no script may write.
    bpy.utils.unregister_class(bpy.types.MATERIAL_PT_preview)
    bpy.context.scene.render.engine = "LUMENRAY"
    item = bpy.data.objects["Cube"]
    bpy.context.view_layer.objects.active = item
    material = item.active_material
    material.lumenray.use_override, material.lumenray.model = True, "PAINT"
    settings = material.lumenray.paint
    presets.load(settings, presets.shipped()["violet_pearl"])
    area = max(
        (area for area in window().screen.areas if area.type == "PROPERTIES"),
        key=lambda area: area.height,
    )
    area.tag_redraw()
    yield 2.0
    area.spaces.active.context = "MATERIAL"
    pictures = preview.pictures
    drawn, taken, redraws = pictures._draw, [], []

    def timed(*arguments):
        begin = time.thread_time()
        try:
            return drawn(*arguments)
        finally:
            taken.append(time.thread_time() - begin)

    pictures._draw = timed
    handle = bpy.types.SpaceProperties.draw_handler_add(
        lambda: redraws.append(time.monotonic()), (), "WINDOW", "POST_PIXEL"
    )
    flakes = next(layer.flakes[0] for layer in settings.layers if layer.flakes)

    def is_drawn():
        digest = preview.described(settings).digest
        return any(name.startswith(digest) for name in pictures._icons or {})

    yield from wait_for(is_drawn, "the first sphere")
    rows = []
    for step in range(STEPS):
        begin = time.monotonic()
        redraws.clear()
        flakes.core_nm += 3.0
        area.tag_redraw()
        yield from wait_for(is_drawn, f"sphere {step}")
        rows.append((time.monotonic() - begin, taken[-1]))
        yield 0.1
    other = []
    for _ in range(STEPS):
        begin = time.monotonic()
        material.metallic = 0.1 + 0.01 * len(other)
        for _ in range(2):
            redraws.clear()
            area.tag_redraw()
            yield from wait_for(lambda: redraws, "a redraw")
        other.append(time.monotonic() - begin)
    bpy.types.SpaceProperties.draw_handler_remove(handle, "WINDOW")
    for name, values in (
        ("clock", [row[0] for row in rows[2:]]),
        ("processors", [row[1] for row in rows[2:]]),
        ("other", other[2:]),
    ):
        record.measure(name, sorted(round(value, 3) for value in values))
    least = min(row[1] for row in rows[2:])
    record.check(least <= LIMIT, f"a sphere takes {least:.3f} s of processors")


FOLDER.mkdir(parents=True, exist_ok=True)
record = Record(FOLDER / "record.json")
start([follow], record, bpy.ops.wm.quit_blender)
