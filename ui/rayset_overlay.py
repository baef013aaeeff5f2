"""Ray sets in the 3D view: where their light starts, as a cloud of points, and a few of their rays."""

import bpy
import gpu
import numpy as np
from bpy.app.handlers import persistent
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ..blender_addon import rayset_readout
from ..blender_addon.raysets.cloud_drawing import make_points, make_rays
from ..blender_addon.sync.units import metres_per_unit

POINT_COLOUR = (1.0, 0.62, 0.2, 0.9)
RAY_COLOUR = (1.0, 0.86, 0.48, 0.75)
FADED = (1.0, 0.86, 0.48, 0.0)
"""Of the far end of a ray."""

POINT_SIZE, LINE_WIDTH = 2.0, 1.2
"""[pixel]"""

KEPT_SHAPES = 64
"""Ray sets whose geometry is kept."""

_batches: dict = {}


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
    gpu.state.point_size_set(POINT_SIZE * context.preferences.system.pixel_size)
    metres = metres_per_unit(context.scene)
    for thing, light in shown:
        points, rays = _shape(light)
        # Size as in the file, whatever the object's scale.
        place = thing.matrix_world.normalized() @ Matrix.Scale(1.0 / metres, 4)
        with gpu.matrix.push_pop():
            gpu.matrix.multiply_matrix(place)
            shader = gpu.shader.from_builtin("UNIFORM_COLOR")
            shader.uniform_float("color", POINT_COLOUR)
            points.draw(shader)
            shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
            shader.uniform_float("viewportSize", (context.region.width, context.region.height))
            shader.uniform_float("lineWidth", LINE_WIDTH * context.preferences.system.pixel_size)
            rays.draw(shader)
    gpu.state.point_size_set(1.0)
    gpu.state.depth_test_set(before[0])
    gpu.state.depth_mask_set(before[1])
    gpu.state.blend_set(before[2])


def _shape(light):
    """Batches of points and rays of a light. [m]"""
    key = id(light)
    kept = _batches.get(key)
    # The light is kept beside its batches, so that its id stays its own.
    if kept is None:
        while len(_batches) >= KEPT_SHAPES:
            _batches.pop(next(iter(_batches)))
        ends = make_rays(light)
        colours = np.tile([RAY_COLOUR, FADED], (len(ends) // 2, 1)).astype(np.float32)
        points = batch_for_shader(
            gpu.shader.from_builtin("UNIFORM_COLOR"), "POINTS", {"pos": make_points(light)}
        )
        rays = batch_for_shader(
            gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR"),
            "LINES",
            {"pos": ends, "color": colours},
        )
        kept = _batches[key] = (light, points, rays)
    return kept[1:]


@persistent
def _forget(*_) -> None:
    _batches.clear()


_handles = []


def attach():
    """Draw in every 3D view from now on."""
    if _handles or bpy.app.background:
        return
    _handles.append(bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_VIEW"))
    bpy.app.handlers.load_post.append(_forget)


def detach():
    """Draw no more."""
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
        bpy.app.handlers.load_post.remove(_forget)
    _batches.clear()
