"""Pictures of the surroundings: loaded into the world, analysed, the sky picked in them, the time read off their sun."""

import bpy
from bpy.props import BoolProperty, StringProperty

from ..blender_addon.environment.loading import EXTENSIONS, show_picture
from ..engine.errors import LumenrayError
from ..imports import loaded_when_used

with loaded_when_used():
    from ..blender_addon.environment import found


class WithWorld:
    """Operator on the scene's world."""

    @classmethod
    def poll(cls, context):
        world = context.scene.world
        if world is None or world.lumenray.source != "NODES":
            cls.poll_message_set("The scene has no world that its nodes light")
            return False
        if world.library is not None:
            cls.poll_message_set("The world is linked from another file")
            return False
        return True


class LUMENRAY_OT_analyse_environment(WithWorld, bpy.types.Operator):
    """Find the sun and other bright sources in the world's picture, weigh them against the rest, and say what that means"""

    bl_idname = "lumenray.analyse_environment"
    bl_label = "Analyse Picture"
    bl_options = {"REGISTER", "UNDO"}

    use_picture: BoolProperty(
        name="Marked Picture",
        description=(
            "Make an image that shows the picture with its sources marked. Default on: eyes see faults at once"
        ),
        default=True,
    )

    def execute(self, context):
        scene = context.scene
        try:
            made = found.analyse_world(scene.world, scene.lumenray.efficacy)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        found.keep(scene.world, made)
        words = made.analysis.verdict[0]
        if self.use_picture:
            words += f"; see image '{found.mark_picture(made).name}'"
        self.report({"INFO"}, words[:1].upper() + words[1:])
        return {"FINISHED"}


class LUMENRAY_OT_time_from_sun(WithWorld, bpy.types.Operator):
    """Set time and north offset to those at which the sun stands where the world's picture shows it, on the date above"""

    bl_idname = "lumenray.time_from_sun"
    bl_label = "Time and North from Sun"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            words = found.state_time(context.scene, context.scene.world)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, words[:1].upper() + words[1:])
        return {"FINISHED"}


class LUMENRAY_OT_pick_sky(WithWorld, bpy.types.Operator):
    """Click on clear sky in the image, away from the sun: by it the sun of the world's picture is mended"""

    bl_idname = "lumenray.pick_sky"
    bl_label = "Pick Sky"
    bl_options = {"REGISTER", "UNDO", "BLOCKING"}

    @classmethod
    def poll(cls, context):
        space = context.space_data
        if space is None or space.type != "IMAGE_EDITOR" or space.image is None:
            cls.poll_message_set(
                "The sky is picked in an Image Editor that shows the world's picture"
            )
            return False
        return super().poll(context)

    def invoke(self, context, event):
        context.window.cursor_modal_set("EYEDROPPER")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in {"RIGHTMOUSE", "ESC"}:
            context.window.cursor_modal_restore()
            return {"CANCELLED"}
        if event.type == "LEFTMOUSE" and event.value == "PRESS":
            context.window.cursor_modal_restore()
            window = next(each for each in context.area.regions if each.type == "WINDOW")
            place = window.view2d.region_to_view(event.mouse_x - window.x, event.mouse_y - window.y)
            return self.pick(context, *place)
        return {"RUNNING_MODAL"}

    def pick(self, context, u: float, v: float):
        """Take a place of the image, 0 to 1 from its left and its lower edge."""
        if not (0.0 <= u <= 1.0 and 0.5 < v <= 1.0):
            self.report(
                {"ERROR"}, "That is no place of the sky: click into the upper half of the image"
            )
            return {"CANCELLED"}
        context.scene.world.lumenray.environment.sky_point = (u, v)
        return {"FINISHED"}


class LUMENRAY_OT_load_environment(bpy.types.Operator):
    """Let an equirectangular picture, HDR or OpenEXR, light the scene as its world"""

    bl_idname = "lumenray.load_environment"
    bl_label = "Load Picture of the Surroundings"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(
        name="Picture",
        description="Equirectangular picture, HDR or OpenEXR",
        subtype="FILE_PATH",
        options={"SKIP_SAVE"},
    )
    filter_glob: StringProperty(
        default=";".join(f"*{ending}" for ending in EXTENSIONS), options={"HIDDEN"}
    )

    def invoke(self, context, event):
        if self.filepath:
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        try:
            image = show_picture(context.scene, self.filepath)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        width, height = image.size
        self.report({"INFO"}, f"'{image.name}', {width} x {height} pixels, lights the scene")
        return {"FINISHED"}


class LUMENRAY_FH_environment(bpy.types.FileHandler):
    """Pictures of the surroundings that are dropped onto a 3D view."""

    bl_idname = "LUMENRAY_FH_environment"
    bl_label = "Picture of the Surroundings"
    bl_import_operator = "lumenray.load_environment"
    bl_file_extensions = ";".join(EXTENSIONS)

    @classmethod
    def poll_drop(cls, context):
        return (
            context.area is not None
            and context.area.type == "VIEW_3D"
            and context.engine == "LUMENRAY"
        )


CLASSES = (
    LUMENRAY_OT_analyse_environment,
    LUMENRAY_OT_time_from_sun,
    LUMENRAY_OT_pick_sky,
    LUMENRAY_OT_load_environment,
    LUMENRAY_FH_environment,
)
