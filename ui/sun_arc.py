"""The sun's arc in the 3D view: its way over the day with hours, the solstices, the compass, and the sun to be dragged."""

import blf
import bpy
import gpu
from bpy_extras.view3d_utils import location_3d_to_region_2d
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ..engine.errors import LumenrayError
from ..imports import loaded_when_used

with loaded_when_used():
    import numpy as np

    from ..blender_addon.daylight import arc as daylight_arc
    from ..blender_addon.daylight import moment as daylight_moment

DAY_COLOUR, SOLSTICE_COLOUR = (1.0, 0.72, 0.2, 1.0), (1.0, 0.72, 0.2, 0.45)
"""Of the day's arc, and of those of the solstices."""

LIFT = 2e-3
"""By which the horizon is drawn above the ground, so that a floor at its height does not hide it. [radius]"""

HORIZON_COLOUR, NORTH_COLOUR = (0.75, 0.75, 0.75, 0.8), (0.95, 0.25, 0.2, 1.0)
"""Of the horizon and all points of the compass but north."""

SUN_COLOUR = (1.0, 0.86, 0.48, 0.8)
"""Of the ray from the sun."""

THICK, THIN = 2.5, 1.2
"""Widths of lines. [pixel]"""

TICK, POINT = 0.03, 0.08
"""Length of an hour's mark, and of a point of the compass. [radius]"""

TEXT_SIZE = 13.0
"""[point]"""


def read_arc(scene) -> "tuple[daylight_moment.Moment, daylight_arc.SunArc] | None":
    """Return the moment and the arc that a scene shows, None where it shows none."""
    world = scene.world
    if world is None or not world.lumenray.arc.is_shown:
        return None
    try:
        moment = daylight_moment.find_moment(world, daylight_moment.frame_of(scene))
        return moment, daylight_arc.make_arc(moment, is_lifted=world.lumenray.time.use_refraction)
    except LumenrayError:
        # The panel says what is wrong.
        return None


def is_seen(context) -> bool:
    """Tell whether a 3D view shows overlays of this kind."""
    overlay = context.space_data.overlay
    return overlay.show_overlays and overlay.show_extras


def make_lines(
    moment: "daylight_moment.Moment", arc: "daylight_arc.SunArc"
) -> "list[tuple[float, np.ndarray, np.ndarray]]":
    """Return what is drawn about the origin for the radius 1: width [pixel], pairs of points (n, 3), colours (n, 4)."""
    up = np.array([0.0, 0.0, LIFT])
    cardinal = daylight_arc.compass(moment.place.north)
    ticks = np.array([(mark, (1.0 + TICK) * mark) for _, mark in arc.hours]).reshape(-1, 3)
    north = np.array([0.0 * up, (1.0 + POINT) * cardinal["N"]]) + up
    others = [((1.0 - POINT) * cardinal[letter], cardinal[letter]) for letter in "ESW"]
    level = np.concatenate([daylight_arc.horizon(), np.array(others).reshape(-1, 3)]) + up
    thin = [(level, HORIZON_COLOUR)]
    thin += [(daylight_arc.lines_above(way), SOLSTICE_COLOUR) for way in arc.solstices]
    thin.append((north, NORTH_COLOUR))
    if moment.towards_sun[2] > 0.0:
        thin.append((np.array([0.0 * up, moment.towards_sun]), SUN_COLOUR))
    thick = [(daylight_arc.lines_above(arc.directions), DAY_COLOUR), (ticks, DAY_COLOUR)]
    return [(width, *_joined(parts)) for width, parts in ((THIN, thin), (THICK, thick))]


def _joined(parts) -> "tuple[np.ndarray, np.ndarray]":
    points = np.concatenate([points for points, _ in parts])
    # Repeated rather than broadcast: rows would lie in memory one column after the other.
    colours = np.repeat(
        [colour for _, colour in parts], [len(points) for points, _ in parts], axis=0
    )
    return points, colours


def draw_lines() -> None:
    """Draw the arc in a 3D view; called by Blender for every 3D view."""
    context = bpy.context
    shown = read_arc(context.scene)
    if shown is None or not is_seen(context):
        return
    radius = context.scene.world.lumenray.arc.radius
    before = gpu.state.depth_test_get(), gpu.state.blend_get()
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.blend_set("ALPHA")
    try:
        shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
        shader.uniform_float("viewportSize", (context.region.width, context.region.height))
        for width, points, colours in make_lines(*shown):
            content = {
                "pos": (radius * points).astype(np.float32),
                "color": colours.astype(np.float32),
            }
            pixels = width * context.preferences.system.pixel_size
            shader.uniform_float("lineWidth", pixels)
            batch_for_shader(shader, "LINES", content).draw(shader)
    finally:
        gpu.state.depth_test_set(before[0])
        gpu.state.blend_set(before[1])


def make_labels(
    moment: "daylight_moment.Moment", arc: "daylight_arc.SunArc"
) -> "list[tuple[str, np.ndarray, tuple]]":
    """Return the texts about the origin for the radius 1: text, where it is (3,), colour (4,)."""
    labels = [(text, (1.0 + 2.2 * TICK) * mark, DAY_COLOUR) for text, mark in arc.hours]
    for letter, place in daylight_arc.compass(moment.place.north).items():
        colour = NORTH_COLOUR if letter == "N" else (*HORIZON_COLOUR[:3], 1.0)
        labels.append((letter, (1.0 + 1.6 * POINT) * place, colour))
    return labels


def draw_labels() -> None:
    """Write hours and compass into a 3D view; called by Blender for every 3D view."""
    context = bpy.context
    shown = read_arc(context.scene)
    if shown is None or not is_seen(context):
        return
    radius = context.scene.world.lumenray.arc.radius
    font = 0
    blf.size(font, TEXT_SIZE * context.preferences.system.ui_scale)
    for text, place, colour in make_labels(*shown):
        found = location_3d_to_region_2d(context.region, context.region_data, radius * place)
        if found is None:
            continue
        width, height = blf.dimensions(font, text)
        blf.position(font, found.x - 0.5 * width, found.y - 0.5 * height, 0.0)
        blf.color(font, *colour)
        blf.draw(font, text)


class LUMENRAY_GGT_sun(bpy.types.GizmoGroup):
    """The sun on its arc, which is dragged to state the time."""

    bl_idname = "LUMENRAY_GGT_sun"
    bl_label = "Sun"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"3D", "PERSISTENT", "SHOW_MODAL_ALL"}

    @classmethod
    def poll(cls, context):
        shown = read_arc(context.scene)
        return shown is not None and is_seen(context) and shown[0].towards_sun[2] > 0.0

    def setup(self, context):
        handle = self.gizmos.new("GIZMO_GT_button_2d")
        handle.icon = "LIGHT_SUN"
        handle.draw_options = {"BACKDROP", "OUTLINE"}
        handle.color, handle.alpha = DAY_COLOUR[:3], 0.9
        handle.color_highlight, handle.alpha_highlight = (1.0, 0.86, 0.48), 1.0
        handle.scale_basis = 0.2
        handle.target_set_operator("lumenray.drag_sun")
        self.handle = handle

    def draw_prepare(self, context):
        shown = read_arc(context.scene)
        if shown is not None:
            radius = context.scene.world.lumenray.arc.radius
            self.handle.matrix_basis = Matrix.Translation(radius * shown[0].towards_sun)


_handles = []


def attach():
    """Draw in every 3D view from now on, and let the sun be dragged there."""
    if _handles or bpy.app.background:
        return
    # Groups of gizmos do not tell whether they are registered, as other classes do.
    bpy.utils.register_class(LUMENRAY_GGT_sun)
    for function, when in ((draw_lines, "POST_VIEW"), (draw_labels, "POST_PIXEL")):
        _handles.append(bpy.types.SpaceView3D.draw_handler_add(function, (), "WINDOW", when))


def detach():
    """Draw no more."""
    if _handles:
        bpy.utils.unregister_class(LUMENRAY_GGT_sun)
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
