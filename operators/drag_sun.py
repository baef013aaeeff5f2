"""Dragging the sun along its arc in a 3D view, which states the time."""

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d

from ..engine.errors import LumenrayError
from ..imports import loaded_when_used

with loaded_when_used():
    import numpy as np

    from ..blender_addon.daylight import arc as daylight_arc
    from ..blender_addon.daylight import moment as daylight_moment

STEP, FINE_STEP = 300.0, 60.0
"""To which the time is rounded, and with Shift held. [s]"""


class LUMENRAY_OT_drag_sun(bpy.types.Operator):
    """Drag the sun along its way of the day, in steps of 5 minutes, with Shift held of one minute"""

    bl_idname = "lumenray.drag_sun"
    bl_label = "Drag Sun"
    bl_options = {"REGISTER", "UNDO", "BLOCKING"}

    @classmethod
    def poll(cls, context):
        if context.region_data is None or context.scene.world is None:
            cls.poll_message_set("The sun is dragged in a 3D view of a scene with a world")
            return False
        return True

    def invoke(self, context, event):
        world = context.scene.world
        try:
            moment = daylight_moment.find_moment(world, daylight_moment.frame_of(context.scene))
            arc = daylight_arc.make_arc(moment, is_lifted=world.lumenray.time.use_refraction)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.start, self.seconds = moment.seconds, arc.seconds
        self.points = _on_screen(context, world.lumenray.arc.radius * arc.directions)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in {"RIGHTMOUSE", "ESC"}:
            self._state(context, self.start)
            return self._end(context, {"CANCELLED"})
        if event.type == "LEFTMOUSE" and event.value == "RELEASE":
            return self._end(context, {"FINISHED"})
        if event.type == "MOUSEMOVE":
            mouse = np.array([event.mouse_region_x, event.mouse_region_y], float)
            step = FINE_STEP if event.shift else STEP
            try:
                seconds = daylight_arc.find_nearest_time(self.seconds, self.points, mouse)
            except LumenrayError as error:
                self.report({"ERROR"}, str(error))
                return self._end(context, {"CANCELLED"})
            # The end of a day is the next one's beginning.
            self._state(context, min(step * round(seconds / step), self.seconds[-1] - step))
        return {"RUNNING_MODAL"}

    def _state(self, context, seconds):
        scene = context.scene
        daylight_moment.state_moment(scene.world, daylight_moment.frame_of(scene), seconds)
        title = daylight_moment.find_moment(scene.world, daylight_moment.frame_of(scene)).title
        context.area.header_text_set(title)

    def _end(self, context, result):
        context.area.header_text_set(None)
        return result


def _on_screen(context, points: "np.ndarray") -> "np.ndarray":
    """Where points above the horizon are seen, NaN for all others. (n, 2) [pixel]"""
    seen = np.full((len(points), 2), np.nan)
    for i in np.flatnonzero(points[:, 2] >= 0.0):
        found = location_3d_to_region_2d(context.region, context.region_data, points[i])
        if found is not None:
            seen[i] = found
    return seen


CLASSES = (LUMENRAY_OT_drag_sun,)
