"""Moves a slider of a paint and measures when the panel's sphere has followed, and what Blender computed for that.

Run by ``run_paint.sh``; numbers go to ``/out/paint/record.json``. Seconds of processors are those of Blender's own process,
whatever else the machine does.
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
    flakes = next(layer.flakes[0] for layer in settings.layers if layer.flakes)

    def is_drawn():
        area.tag_redraw()
        digest = preview.described(settings).digest
        return any(name.startswith(digest) for name in pictures._icons or {})

    yield from wait_for(is_drawn, "the first sphere")
    rows = []
    for step in range(STEPS):
        begin, used = time.monotonic(), time.process_time()
        flakes.core_nm += 3.0
        yield from wait_for(is_drawn, f"sphere {step}")
        rows.append((time.monotonic() - begin, time.process_time() - used))
        yield 0.1
    for name, place in (("clock", 0), ("processors", 1)):
        record.measure(name, sorted(round(row[place], 3) for row in rows[2:]))
    least = min(row[1] for row in rows[2:])
    record.check(least <= LIMIT, f"a move takes {least:.3f} s of Blender's processors")


FOLDER.mkdir(parents=True, exist_ok=True)
record = Record(FOLDER / "record.json")
start([follow], record, bpy.ops.wm.quit_blender)
