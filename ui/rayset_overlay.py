"""Ray sets in the 3D view: where their light starts, as a cloud of points, and a few of their rays."""

from weakref import WeakKeyDictionary

import bpy
import gpu
from bpy.app.handlers import persistent
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ..blender_addon.foundation.handlers import leave, listen
from ..blender_addon.foundation.units import metres_per_unit
from ..engine.errors import SceneError
from ..imports import loaded_when_used

with loaded_when_used():
    import numpy as np

    from ..blender_addon.foundation import pose
    from ..blender_addon.raysets import cloud_drawing
    from ..blender_addon.raysets import readout as rayset_readout

POINT_COLOUR = (1.0, 0.62, 0.2, 0.9)
RAY_COLOUR = (1.0, 0.86, 0.48, 0.75)
FADED = (1.0, 0.86, 0.48, 0.0)
"""Of the far end of a ray."""

POINT_SIZE, LINE_WIDTH = 2.0, 1.2
"""[pixel]"""

_batches = WeakKeyDictionary()
"""Geometry on the graphics card, for as long as the prepared light is kept."""


def draw() -> None:
    """Draw the ray sets of a 3D view; called by Blender for every 3D view."""
    context = bpy.context
    space = context.space_data
    if not (space.overlay.show_overlays and space.overlay.show_extras):
        return
    shown = rayset_readout.shown_rays(context)
    if not shown:
        return
    before = gpu.state.depth_test_get(), gpu.state.depth_mask_get(), gpu.state.blend_get()
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(False)
    gpu.state.blend_set("ALPHA")
    try:
        for thing, light in shown:
            _draw_light(context, thing, light)
    finally:
        gpu.state.point_size_set(1.0)
        gpu.state.depth_test_set(before[0])
        gpu.state.depth_mask_set(before[1])
        gpu.state.blend_set(before[2])


def _draw_light(context, thing, light) -> None:
    metres = metres_per_unit(context.scene)
    try:
        # As the engine places it: size as in the file, whatever the object's scale.
        place = Matrix(pose.pose_of(thing.matrix_world, metres).frame)
    except SceneError:
        return
    place.translation = thing.matrix_world.translation
    points, rays = _shape(light)
    pixel = context.preferences.system.pixel_size
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(place @ Matrix.Scale(1.0 / metres, 4))
        shader, has_size = _point_shader()
        shader.uniform_float("color", POINT_COLOUR)
        if has_size:
            shader.uniform_float("size", POINT_SIZE * pixel)
        gpu.state.point_size_set(POINT_SIZE * pixel)
        points.draw(shader)
        shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
        shader.uniform_float("viewportSize", (context.region.width, context.region.height))
        shader.uniform_float("lineWidth", LINE_WIDTH * pixel)
        rays.draw(shader)


def _point_shader():
    """Shader of points, and whether it takes their size: Metal and Vulkan ask for that, older Blenders have none such."""
    try:
        return gpu.shader.from_builtin("POINT_UNIFORM_COLOR"), True
    except ValueError:
        return gpu.shader.from_builtin("UNIFORM_COLOR"), False


def _shape(light):
    """Batches of points and rays of a light. [m]"""
    kept = _batches.get(light)
    if kept is None:
        ends = cloud_drawing.make_rays(light)
        colours = np.tile([RAY_COLOUR, FADED], (len(ends) // 2, 1)).astype(np.float32)
        points = batch_for_shader(
            _point_shader()[0], "POINTS", {"pos": cloud_drawing.make_points(light)}
        )
        shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
        rays = batch_for_shader(shader, "LINES", {"pos": ends, "color": colours})
        kept = _batches[light] = (points, rays)
    return kept


@persistent
def _forget(*_) -> None:
    _batches.clear()


_handles = []

_HANDLERS = {"load_post": _forget}


def attach():
    """Draw in every 3D view from now on."""
    if _handles or bpy.app.background:
        return
    _handles.append(bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_VIEW"))
    listen(_HANDLERS)


def detach():
    """Draw no more."""
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    leave(_HANDLERS)
    _batches.clear()
