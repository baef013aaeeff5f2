"""The surroundings in the 3D view: rings and lines of their ground, an arrow for its height, and a handle at their sun."""

import bpy
import gpu
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ..imports import loaded_when_used
from .sun_arc import SUN_COLOUR, is_seen

with loaded_when_used():
    import numpy as np

    from ..blender_addon import sun_handle

COLOUR, WIDTH = (0.85, 0.35, 0.3, 0.8), 1.2
"""Of its lines, as red as those of the reference system; width [pixel]."""

SIDES, LINES, RINGS = 96, 8, (0.25, 0.5, 1.0)
"""Of a ring; lines from the middle outwards; rings, by the radius: at the half of it the ground begins to pass into what is
at infinity."""

ARROW = 1.0
"""Length of the arrow, over that of Blender's own."""


def make_lines() -> "np.ndarray":
    """Return pairs of points on the plane of radius 1. (n, 3)"""
    angle = 2.0 * np.pi * np.arange(SIDES + 1) / SIDES
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(SIDES + 1)], axis=1)
    ring = np.stack([circle[:-1], circle[1:]], axis=1).reshape(-1, 3)
    spokes = circle[: -1 : SIDES // LINES]
    spokes = np.stack([0.0 * spokes, spokes], axis=1).reshape(-1, 3)
    return np.concatenate([*(share * ring for share in RINGS), spokes])


def place_of(scene) -> tuple[float, float, float, float] | None:
    """Return the middle of the ground and its radius, None where the scene has none. [Blender unit]"""
    settings = None if scene.world is None else scene.world.lumenray.ground
    if settings is None or not settings.use_ground:
        return None
    x, y = settings.centre
    if settings.photo == "CAMERA" and scene.camera is not None:
        x, y = scene.camera.matrix_world.translation[:2]
    return x, y, settings.level, settings.radius


def handle_of(context):
    """Return the sun that can be dragged, as `find_handle`, None without one."""
    return sun_handle.find_handle(
        context.scene, context.object, (place_of(context.scene) or (0.0, 0.0, 0.0))[:3]
    )


def draw_lines() -> None:
    """Draw ground and sun in a 3D view; called by Blender for every 3D view."""
    context = bpy.context
    if not is_seen(context):
        return
    shown, sun = place_of(context.scene), handle_of(context)
    lines = []
    if shown is not None:
        lines.append((COLOUR, shown[3] * make_lines() + np.array(shown[:3])))
    if sun is not None:
        lines.append(
            (SUN_COLOUR, sun.middle + np.array([0.0 * sun.towards, sun.radius * sun.towards]))
        )
    if not lines:
        return
    before = gpu.state.depth_test_get(), gpu.state.blend_get()
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.blend_set("ALPHA")
    try:
        shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
        shader.uniform_float("viewportSize", (context.region.width, context.region.height))
        shader.uniform_float("lineWidth", WIDTH * context.preferences.system.pixel_size)
        for colour, points in lines:
            shader.uniform_float("color", colour)
            content = {"pos": points.astype(np.float32)}
            batch_for_shader(shader, "LINES", content).draw(shader)
    finally:
        gpu.state.depth_test_set(before[0])
        gpu.state.blend_set(before[1])


class LUMENRAY_GGT_ground(bpy.types.GizmoGroup):
    """Arrow on the ground, which is dragged to state its height."""

    bl_idname = "LUMENRAY_GGT_ground"
    bl_label = "Ground"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"3D", "PERSISTENT"}

    @classmethod
    def poll(cls, context):
        return place_of(context.scene) is not None and is_seen(context)

    def setup(self, context):
        arrow = self.gizmos.new("GIZMO_GT_arrow_3d")
        arrow.color, arrow.alpha = COLOUR[:3], 0.7
        arrow.color_highlight, arrow.alpha_highlight = (1.0, 0.6, 0.5), 1.0
        arrow.scale_basis = ARROW
        self.arrow, self.owner = arrow, 0

    def draw_prepare(self, context):
        shown, world = place_of(context.scene), context.scene.world
        if shown is None:
            return
        if world.session_uid != self.owner:
            # The arrow stands for the height by its offset from 0.
            self.arrow.target_set_prop("offset", world.lumenray.ground, "level")
            self.owner = world.session_uid
        self.arrow.matrix_basis = Matrix.Translation((shown[0], shown[1], 0.0))


class LUMENRAY_GGT_surroundings_sun(bpy.types.GizmoGroup):
    """The sun of a photo or of the world's picture, which is dragged."""

    bl_idname = "LUMENRAY_GGT_surroundings_sun"
    bl_label = "Sun of the Surroundings"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"3D", "PERSISTENT", "SHOW_MODAL_ALL"}

    @classmethod
    def poll(cls, context):
        return is_seen(context) and handle_of(context) is not None

    def setup(self, context):
        handle = self.gizmos.new("GIZMO_GT_button_2d")
        handle.icon = "LIGHT_SUN"
        handle.draw_options = {"BACKDROP", "OUTLINE"}
        handle.color, handle.alpha = SUN_COLOUR[:3], 0.9
        handle.color_highlight, handle.alpha_highlight = (1.0, 1.0, 0.7), 1.0
        handle.scale_basis = 0.2
        self.action = handle.target_set_operator("lumenray.turn_sun")
        self.handle = handle

    def draw_prepare(self, context):
        sun = handle_of(context)
        if sun is not None:
            self.action.middle = sun.middle
            self.handle.matrix_basis = Matrix.Translation(sun.middle + sun.radius * sun.towards)


GROUPS = (LUMENRAY_GGT_ground, LUMENRAY_GGT_surroundings_sun)

_handles = []


def attach():
    """Draw in every 3D view from now on, and let the height be dragged there."""
    if _handles or bpy.app.background:
        return
    # Groups of gizmos do not tell whether they are registered, as other classes do.
    for group in GROUPS:
        bpy.utils.register_class(group)
    _handles.append(bpy.types.SpaceView3D.draw_handler_add(draw_lines, (), "WINDOW", "POST_VIEW"))


def detach():
    """Draw no more."""
    if _handles:
        for group in GROUPS:
            bpy.utils.unregister_class(group)
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
