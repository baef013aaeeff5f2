"""Sensors in the 3D view: cells in false colours, isolux lines, and every reading with its error; grey when out of date."""

from dataclasses import dataclass, field

import blf
import bpy
import gpu
from bpy.app.handlers import persistent
from bpy_extras.view3d_utils import location_3d_to_region_2d
from gpu_extras.batch import batch_for_shader

from ..blender_addon.foundation.handlers import leave, listen
from ..blender_addon.foundation.units import metres_per_unit
from ..blender_addon.rendering.light_mix import levels_of
from ..blender_addon.sensors import results
from ..blender_addon.sensors.settings import find_sensors
from ..imports import loaded_when_used
from .sun_arc import is_seen

with loaded_when_used():
    import numpy as np

    from ..blender_addon.sensors import drawing

LINE_COLOUR = (0.05, 0.05, 0.05, 1.0)
TEXT_COLOUR, HALO_COLOUR = (1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 1.0)
OUTDATED_COLOUR = (0.7, 0.7, 0.7, 1.0)
"""Of lines and numbers."""

LINE_WIDTH = 1.6
"""[pixel]"""

VALUE_SIZE, LINE_SIZE = 11.0, 13.0
"""Sizes of letters of readings and of lines. [point]"""

SQUARE = 8
"""Side of the squares of a view of which each has at most one number. [pixel]"""

BAR = (14.0, 160.0)
"""Width and height of the bar of colours. [pixel]"""

BAR_STEPS = 48


@dataclass
class _Cache:
    """What a view shows until something of it changes."""

    views: dict = field(default_factory=dict)


_cache = _Cache()


def drawing_of(context) -> "drawing.Drawing":
    """Return what the sensors of a view show, made anew only after a change."""
    scene = context.scene
    shown = [e for e in find_sensors(scene) if e.visible_get(view_layer=context.view_layer)]
    settings = scene.lumenray.sensors
    state = (
        settings.automatic,
        settings.high,
        levels_of(scene),
        tuple(
            (
                e.session_uid,
                e.lumenray.sensor.serial,
                results.is_outdated(e),
                e.lumenray.sensor.show_isolux,
                e.lumenray.sensor.show_values,
            )
            for e in shown
        ),
    )
    kept = _cache.views.get(scene.session_uid)
    if kept is None or kept[0] != state:
        keys = {e.session_uid for e in shown}
        made = drawing.make_drawing(scene, lambda empty: empty.session_uid in keys)
        kept = _cache.views[scene.session_uid] = (state, made)
    return kept[1]


def draw_shapes() -> None:
    """Draw cells and lines in a 3D view; called by Blender for every 3D view."""
    context = bpy.context
    if not is_seen(context):
        return
    shown = drawing_of(context)
    if not len(shown.corners):
        return
    metres = metres_per_unit(context.scene)
    before = gpu.state.depth_test_get(), gpu.state.blend_get()
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.blend_set("ALPHA")
    try:
        _draw_cells(shown, metres)
        _draw_lines(context, shown, metres)
    finally:
        gpu.state.depth_test_set(before[0])
        gpu.state.blend_set(before[1])


def _draw_cells(shown: "drawing.Drawing", metres: float) -> None:
    first = 4 * np.arange(len(shown.corners) // 4)[:, None]
    triangles = np.concatenate([first + np.array([0, 1, 2]), first + np.array([0, 2, 3])]).astype(
        np.int32
    )
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    content = {
        "pos": (shown.corners / metres).astype(np.float32),
        "color": np.ascontiguousarray(shown.fills, np.float32),
    }
    batch_for_shader(shader, "TRIS", content, indices=triangles).draw(shader)


def _draw_lines(context, shown: "drawing.Drawing", metres: float) -> None:
    if not len(shown.lines):
        return
    colours = np.tile(np.array(LINE_COLOUR, np.float32), (len(shown.lines), 1))
    content = {"pos": (shown.lines / metres).astype(np.float32), "color": colours}
    shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
    shader.uniform_float("viewportSize", (context.region.width, context.region.height))
    shader.uniform_float("lineWidth", LINE_WIDTH * context.preferences.system.pixel_size)
    batch_for_shader(shader, "LINES", content).draw(shader)


def draw_labels() -> None:
    """Write readings, lines' values and the scale into a 3D view; called by Blender for every 3D view."""
    context = bpy.context
    if not is_seen(context):
        return
    shown = drawing_of(context)
    if not shown.labels and shown.scale is None:
        return
    font, metres = 0, metres_per_unit(context.scene)
    scale = context.preferences.system.ui_scale
    blf.enable(font, blf.SHADOW)
    blf.shadow(font, 5, *HALO_COLOUR)
    taken: set[tuple[int, int]] = set()
    # Lines first: where there is no room for all, readings give way.
    for label in sorted(shown.labels, key=lambda each: not each.is_line):
        found = location_3d_to_region_2d(context.region, context.region_data, label.place / metres)
        if found is None:
            continue
        blf.size(font, (LINE_SIZE if label.is_line else VALUE_SIZE) * scale)
        width, height = blf.dimensions(font, label.text)
        box = (
            found.x - 0.5 * width,
            found.y - 0.5 * height,
            found.x + 0.5 * width,
            found.y + 0.5 * height,
        )
        covered = cover(box)
        if not taken.isdisjoint(covered):
            continue
        taken |= covered
        blf.position(font, box[0], box[1], 0.0)
        blf.color(font, *(OUTDATED_COLOUR if label.is_outdated else TEXT_COLOUR))
        blf.draw(font, label.text)
    if shown.scale is not None:
        _draw_scale(context, shown, font, scale)
    blf.disable(font, blf.SHADOW)


def cover(box) -> set[tuple[int, int]]:
    """Squares of the view that a box (left, bottom, right, top) covers in part; boxes that share none are apart. [pixel]"""
    left, bottom, right, top = (int(side // SQUARE) for side in box)
    return {(x, y) for x in range(left, right + 1) for y in range(bottom, top + 1)}


def _draw_scale(context, shown: "drawing.Drawing", font: int, zoom: float) -> None:
    """Draw the bar of colours with its numbers at the lower left."""
    width, height = BAR[0] * zoom, BAR[1] * zoom
    left, bottom = 24.0 * zoom, 40.0 * zoom
    shares = np.linspace(0.0, 1.0, BAR_STEPS)
    colours = np.ones((BAR_STEPS, 4), np.float32)
    colours[:, :3] = shown.scale.colours(shown.scale.value(shares)) / 255.0
    y = bottom + shares * height
    points = np.stack([np.stack([np.full(BAR_STEPS, x), y], 1) for x in (left, left + width)], 1)
    first = 2 * np.arange(BAR_STEPS - 1)[:, None]
    triangles = np.concatenate([first + np.array([0, 1, 3]), first + np.array([0, 3, 2])]).astype(
        np.int32
    )
    content = {
        "pos": points.reshape(-1, 2).astype(np.float32),
        "color": np.repeat(colours, 2, axis=0),
    }
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    batch_for_shader(shader, "TRIS", content, indices=triangles).draw(shader)
    blf.size(font, VALUE_SIZE * zoom)
    blf.color(font, *TEXT_COLOUR)
    for tick in shown.scale.ticks():
        up = float(shown.scale.share(tick)) * height
        blf.position(font, left + width + 6.0 * zoom, bottom + up - 4.0 * zoom, 0.0)
        blf.draw(font, f"{tick:g}")
    blf.position(font, left, bottom + height + 8.0 * zoom, 0.0)
    blf.draw(font, f"{shown.scale.unit}, log" if shown.scale.is_log else shown.scale.unit)


@persistent
def forget(*_) -> None:
    """Make anew what views show."""
    _cache.views.clear()


_handles = []

_HANDLERS = {"undo_post": forget, "redo_post": forget, "load_post": forget}


def attach():
    """Draw in every 3D view from now on."""
    if _handles or bpy.app.background:
        return
    for function, when in ((draw_shapes, "POST_VIEW"), (draw_labels, "POST_PIXEL")):
        _handles.append(bpy.types.SpaceView3D.draw_handler_add(function, (), "WINDOW", when))
    listen(_HANDLERS)


def detach():
    """Draw no more."""
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    leave(_HANDLERS)
    forget()
