"""Add luminaires from photometric files: from a menu, or by dropping the files onto a 3D view."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, CollectionProperty, FloatVectorProperty, StringProperty

from ..blender_addon.luminaires.files import EXTENSIONS, photometric_files
from ..blender_addon.luminaires.settings import settings_of
from ..engine.errors import LumenrayError
from ..imports import loaded_when_used
from .luminaire_files import FILTER, describe

with loaded_when_used():
    from ..blender_addon.luminaires import placing


class FileChoice:
    """Operator on one or several files, as Blender's browser and its drag and drop hand them over."""

    filepath: StringProperty(
        description="Path of the photometric file; empty asks for files",
        subtype="FILE_PATH",
        options={"SKIP_SAVE"},
    )
    directory: StringProperty(
        description="Folder of the files that are chosen",
        subtype="DIR_PATH",
        options={"SKIP_SAVE"},
    )
    files: CollectionProperty(
        description="Names of the files that are chosen",
        type=bpy.types.OperatorFileListElement,
        options={"SKIP_SAVE"},
    )
    use_embed: BoolProperty(
        name="Embed",
        description=(
            "Keep the content of the files in the Blender file; else only their paths. Default on: the file can be "
            "given away alone"
        ),
        default=True,
    )

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("Luminaires are added in object mode")
            return False
        if context.collection is None or context.collection.library is not None:
            cls.poll_message_set("The active collection is linked from another file")
            return False
        return True

    def paths(self) -> list[str]:
        """Return the files that were chosen."""
        names = [element.name for element in self.files if element.name]
        if names:
            return [str(Path(self.directory, name)) for name in names]
        return [self.filepath] if self.filepath else []

    def add(self, context, mount):
        """Add the luminaires and say so."""
        if not self.paths():
            self.report({"ERROR"}, "no photometric file is chosen")
            return {"CANCELLED"}
        try:
            made = placing.add_luminaires(context, self.paths(), mount, self.use_embed)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for empty in made:
            settings = settings_of(empty)
            self.report(*describe(settings, photometric_files.obtain(settings), self.use_embed))
        return {"FINISHED"}


class LUMENRAY_OT_add_luminaire(FileChoice, bpy.types.Operator):
    """Add luminaires at the 3D cursor from photometric files: IES, EULUMDAT or TM-33"""

    bl_idname = "lumenray.add_luminaire"
    bl_label = "Luminaire (IES, LDT)"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})

    def invoke(self, context, event):
        if self.paths():
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        return self.add(context, placing.cursor_mount(context))


class LUMENRAY_OT_drop_luminaire(FileChoice, bpy.types.Operator):
    """Mount luminaires on the surface under the mouse, or at the 3D cursor where there is none"""

    bl_idname = "lumenray.drop_luminaire"
    bl_label = "Drop Luminaire"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    point: FloatVectorProperty(
        name="Place",
        description="Where the first luminaire is mounted, in units of Blender",
        subtype="TRANSLATION",
        options={"SKIP_SAVE"},
    )
    normal: FloatVectorProperty(
        name="Direction",
        description="Where the luminaires shine to: away from the surface",
        default=(0.0, 0.0, -1.0),
        options={"SKIP_SAVE"},
    )
    on_surface: BoolProperty(
        name="On a Surface",
        description=(
            "Stand on a surface at the place; else the 3D cursor is the place. Default off: the mouse decides it"
        ),
        default=False,
        options={"SKIP_SAVE"},
    )

    def invoke(self, context, event):
        mount = placing.mount_under(context, event.mouse_region_x, event.mouse_region_y)
        self.point, self.normal, self.on_surface = mount.point, mount.normal, mount.is_surface
        return self.execute(context)

    def execute(self, context):
        if self.on_surface:
            return self.add(context, placing.Mount(tuple(self.point), tuple(self.normal), True))
        return self.add(context, placing.cursor_mount(context))


class LUMENRAY_FH_luminaire(bpy.types.FileHandler):
    """Photometric files that are dropped onto a 3D view."""

    bl_idname = "LUMENRAY_FH_luminaire"
    bl_label = "Photometric File"
    bl_import_operator = "lumenray.drop_luminaire"
    bl_file_extensions = ";".join(EXTENSIONS)

    @classmethod
    def poll_drop(cls, context):
        return context.area is not None and context.area.type == "VIEW_3D"


CLASSES = (LUMENRAY_OT_add_luminaire, LUMENRAY_OT_drop_luminaire, LUMENRAY_FH_luminaire)
