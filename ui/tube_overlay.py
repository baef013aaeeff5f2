"""Luminous tubes in the 3D view: Blender draws a point light, whatever its tube length."""

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from ..blender_addon.file_assets.settings import settings_used
from ..imports import loaded_when_used

with loaded_when_used():
    import numpy as np

    from ..blender_addon.sync.lights import kinds

COLOUR, CHOSEN_COLOUR = (1.0, 0.86, 0.48, 0.6), (1.0, 0.86, 0.48, 1.0)
"""Of tubes, and of selected ones."""

LINE_WIDTH = 1.4
"""[pixel]"""

SEGMENTS, EDGES = 24, 4
"""Around an end, and from end to end."""


def make_outline(length: float, radius: float) -> "np.ndarray":
    """Ends and edges of a tube along x as pairs of points. (n, 3), in the unit of the numbers"""
    turn = 2.0 * np.pi * np.arange(SEGMENTS + 1) / SEGMENTS
    ring = np.column_stack([0.0 * turn, radius * np.cos(turn), radius * np.sin(turn)])
    pairs = np.stack([ring[:-1], ring[1:]], axis=1)
    half = np.array([0.5 * length, 0.0, 0.0])
    corners = ring[: -1 : SEGMENTS // EDGES]
    edges = np.stack([corners - half, corners + half], axis=1)
    return np.concatenate([pairs - half, pairs + half, edges]).reshape(-1, 3)


def place_outline(thing) -> "np.ndarray":
    """Outline of a light object in the world, as the engine places it. (n, 3), in Blender's units"""
    tube = kinds.Tube().make(thing.data, kinds.Place("", "", thing.matrix_world, 1.0), None)
    return make_outline(tube.length, tube.radius) @ tube.frame[:3, :3].T + tube.frame[:3, 3]


def shown_tubes(context) -> list:
    """Light objects of the view that shine as tubes."""
    tubes = {light for light in bpy.data.lights if _is_drawn(light)}
    if not tubes:
        return []
    return [thing for thing in context.visible_objects if thing.data in tubes]


def _is_drawn(light) -> bool:
    files = settings_used(light, "rayset"), settings_used(light, "luminaire")
    return kinds.Tube.fits(light) and files == (None, None)


def draw() -> None:
    """Draw the tubes of a 3D view; called by Blender for every 3D view."""
    context = bpy.context
    overlay = context.space_data.overlay
    if not (overlay.show_overlays and overlay.show_extras):
        return
    tubes = shown_tubes(context)
    if not tubes:
        return
    parts = [place_outline(thing) for thing in tubes]
    colours = [
        np.broadcast_to(CHOSEN_COLOUR if thing.select_get() else COLOUR, (len(part), 4))
        for thing, part in zip(tubes, parts, strict=True)
    ]
    content = {
        "pos": np.concatenate(parts).astype(np.float32),
        # Row by row: what was broadcast would lie in memory one column after the other.
        "color": np.ascontiguousarray(np.concatenate(colours), np.float32),
    }
    before = gpu.state.depth_test_get(), gpu.state.blend_get()
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.blend_set("ALPHA")
    try:
        shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
        shader.uniform_float("viewportSize", (context.region.width, context.region.height))
        shader.uniform_float("lineWidth", LINE_WIDTH * context.preferences.system.pixel_size)
        batch_for_shader(shader, "LINES", content).draw(shader)
    finally:
        gpu.state.depth_test_set(before[0])
        gpu.state.blend_set(before[1])


_handles = []


def attach():
    """Draw in every 3D view from now on."""
    if not (_handles or bpy.app.background):
        _handles.append(bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_VIEW"))


def detach():
    """Draw no more."""
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
