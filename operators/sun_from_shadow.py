"""The sun of a photo, by a thing's foot, and by dragging from its top to the end of its shadow."""

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d

from ..engine.errors import LumenrayError
from ..imports import loaded_when_used

with loaded_when_used():
    import numpy as np

    from ..blender_addon import shadow_sun, sun_direction

ASKS = (
    "Click the foot of something upright on the ground; Esc ends",
    "Drag from its top to the end of its shadow",
)
"""What is asked for, one after the other."""


class LUMENRAY_OT_sun_from_shadow(bpy.types.Operator):
    """Turn a Sun light by a shadow in the photo: click the foot of a thing, and drag from its top to its shadow's end"""

    bl_idname = "lumenray.sun_from_shadow"
    bl_label = "Sun from Shadow"
    bl_options = {"REGISTER", "UNDO", "BLOCKING"}

    @classmethod
    def poll(cls, context):
        scene = context.scene
        camera = scene.camera
        if scene.world is None or camera is None or camera.type != "CAMERA":
            cls.poll_message_set("The scene needs a world and a camera")
            return False
        if camera.data.type != "PERSP":
            cls.poll_message_set("The scene's camera is no perspective one")
            return False
        if _view_of(context) is None:
            cls.poll_message_set("No 3D view looks through the camera")
            return False
        return True

    def invoke(self, context, event):
        self.places = []
        self.lamp, self.is_new = None, False
        self.area, self.region, self.view = _view_of(context)
        self.area.header_text_set(ASKS[0])
        context.window.cursor_modal_set("CROSSHAIR")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in {"RIGHTMOUSE", "ESC"}:
            return self._end(context, {"CANCELLED"})
        mouse = (event.mouse_x - self.region.x, event.mouse_y - self.region.y)
        place = shadow_sun.film_place(_corners(context.scene, self.region, self.view), mouse)
        if event.type == "LEFTMOUSE" and event.value == "PRESS" and len(self.places) < 2:
            self.places.append(place)
            self.area.header_text_set(ASKS[min(len(self.places), len(ASKS) - 1)])
            return {"RUNNING_MODAL"}
        if len(self.places) < 2:
            return {"PASS_THROUGH"} if event.type in {"MIDDLEMOUSE"} else {"RUNNING_MODAL"}
        is_end = event.type == "LEFTMOUSE" and event.value == "RELEASE"
        if is_end or event.type == "MOUSEMOVE":
            try:
                self._turn(context, place)
            except LumenrayError as error:
                if is_end:
                    self.report({"ERROR"}, f"No sun found: {error}")
                    return self._end(context, {"CANCELLED"})
                self.area.header_text_set(str(error))
            if is_end:
                return self._end(context, {"FINISHED"})
        return {"RUNNING_MODAL"}

    def _turn(self, context, end) -> None:
        scene = context.scene
        level = scene.world.lumenray.ground.level
        towards = shadow_sun.sun_of_shadow(
            context.evaluated_depsgraph_get(), level, *self.places, end
        )
        if self.lamp is None:
            before = set(scene.objects)
            self.lamp = shadow_sun.sun_for(scene, context.object)
            if self.lamp not in before:
                shadow_sun.light_sun(self.lamp, scene, towards)
        shadow_sun.turn_sun(self.lamp, towards)
        elevation, azimuth = np.degrees(sun_direction.angles(towards))
        self.area.header_text_set(f"Sun {elevation:.1f}° high at {azimuth:.1f}°")

    def _end(self, context, result):
        self.area.header_text_set(None)
        context.window.cursor_modal_restore()
        return result


def _view_of(context):
    """Area, region and view of the 3D view that looks through the scene's camera; None without one."""
    screen = context.screen
    areas = [] if screen is None else [each for each in screen.areas if each.type == "VIEW_3D"]
    areas.sort(key=lambda area: area != context.area)
    for area in areas:
        view = area.spaces.active.region_3d
        region = next((each for each in area.regions if each.type == "WINDOW"), None)
        if region is not None and view is not None and view.view_perspective == "CAMERA":
            return area, region, view
    return None


def _corners(scene, region, view) -> "np.ndarray":
    """Where the film's lower left and upper right corner are in a region. (2, 2) [pixel]"""
    camera = scene.camera
    frame = np.array([camera.matrix_world @ each for each in camera.data.view_frame(scene=scene)])
    seen = np.array([location_3d_to_region_2d(region, view, each) for each in frame])
    return np.stack([seen.min(axis=0), seen.max(axis=0)])


CLASSES = (LUMENRAY_OT_sun_from_shadow,)
