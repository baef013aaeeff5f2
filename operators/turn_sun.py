"""Dragging the sun of a photo or of the world's picture in a 3D view."""

import bpy
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d

from ..imports import loaded_when_used

with loaded_when_used():
    import numpy as np

    from ..blender_addon import sun_direction, sun_handle


class LUMENRAY_OT_turn_sun(bpy.types.Operator):
    """Drag the sun: a photo's Sun light to any side, that of the world's picture about the vertical, with the picture"""

    bl_idname = "lumenray.turn_sun"
    bl_label = "Turn Sun"
    bl_options = {"REGISTER", "UNDO", "BLOCKING"}

    middle: bpy.props.FloatVectorProperty(name="Middle", size=3, options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        if context.region_data is None or context.scene.world is None:
            cls.poll_message_set("The sun is dragged in a 3D view of a scene with a world")
            return False
        return True

    def invoke(self, context, event):
        self.handle = sun_handle.find_handle(context.scene, context.object, self.middle)
        if self.handle is None:
            self.report({"ERROR"}, "There is no sun to drag: analyse the world's picture first")
            return {"CANCELLED"}
        self.is_front = sun_handle.is_in_front(self.handle, self._ray(context, event)[0])
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in {"RIGHTMOUSE", "ESC"}:
            sun_handle.drag_handle(context.scene, self.handle, self.handle.towards)
            return self._end(context, {"CANCELLED"})
        if event.type == "LEFTMOUSE" and event.value == "RELEASE":
            return self._end(context, {"FINISHED"})
        if event.type == "MOUSEMOVE":
            towards = sun_handle.find_towards(
                self.handle, *self._ray(context, event), self.is_front
            )
            sun_handle.drag_handle(context.scene, self.handle, towards)
            shown = (
                sun_handle.find_handle(context.scene, context.object, self.middle) or self.handle
            )
            elevation, azimuth = np.degrees(sun_direction.angles(shown.towards))
            context.area.header_text_set(f"Sun {elevation:.1f}° high at {azimuth % 360.0:.1f}°")
        return {"RUNNING_MODAL"}

    def _ray(self, context, event):
        mouse = (event.mouse_region_x, event.mouse_region_y)
        view = (context.region, context.region_data, mouse)
        return np.array(region_2d_to_origin_3d(*view)), np.array(region_2d_to_vector_3d(*view))

    def _end(self, context, result):
        context.area.header_text_set(None)
        return result


CLASSES = (LUMENRAY_OT_turn_sun,)
