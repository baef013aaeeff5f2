"""Photometric files of the active light or empty: load, embed, link, and read anew."""

import bpy
from bpy.props import BoolProperty, StringProperty

from ..blender_addon.luminaires import files, placing
from ..blender_addon.luminaires.settings import active_settings
from ..engine.errors import LumenrayError

FILTER = ";".join(f"*{ending}" for ending in files.EXTENSIONS)
"""Names that the file browser shows."""

NO_TILT_FILE = "the TILT file that it names stays outside; link the luminaire to keep them together"


class ActiveLuminaire:
    """Operator on the photometric file of the active light or empty."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        settings = active_settings(context)
        problem = cls.problem(settings)
        if problem:
            cls.poll_message_set(problem)
        return not problem

    @classmethod
    def problem(cls, settings) -> str:
        """Say why the operator cannot be used, empty if it can."""
        if settings is None:
            return "Select a point, spot or area light, or an empty"
        if settings.id_data.library is not None:
            return "It is linked from another file, where it can be changed"
        return ""

    def execute(self, context):
        try:
            self.report(*self.work(context, active_settings(context)))
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def describe(reading, settings, is_embedded: bool) -> tuple[set[str], str]:
    """Say what was loaded, as an operator reports it; ``is_embedded``: whether that was asked for."""
    name, remarks = files.name_of(settings), reading.file.remarks
    words = f"{name}: {reading.flux:.4g} {reading.file.units.flux}"
    if is_embedded and settings.text is None:
        return {"WARNING"}, f"{words}; linked, because Blender's texts cannot hold it"
    if settings.text is not None and files.names_tilt_file(files.content_of(settings.text)):
        return {"WARNING"}, f"{words}; {NO_TILT_FILE}"
    if remarks:
        count = f"{len(remarks)} remarks, the first: " if len(remarks) > 1 else ""
        return {"WARNING"}, f"{words}; {count}{remarks[0]}"
    return {"INFO"}, words


class LUMENRAY_OT_load_luminaire_file(ActiveLuminaire, bpy.types.Operator):
    """Let the active light or empty shine as a photometric file says: IES, EULUMDAT or TM-33"""

    bl_idname = "lumenray.load_luminaire_file"
    bl_label = "Load Photometric File"

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})
    use_embed: BoolProperty(
        name="Embed",
        description="Keep the file's content in the Blender file; else only its path",
        default=True,
    )

    def invoke(self, context, event):
        if self.filepath:
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, context, settings):
        reading = files.load(settings, self.filepath, self.use_embed)
        owner = settings.id_data
        if isinstance(owner, bpy.types.Object) and placing.has_body(owner):
            placing.add_body(context, owner, reading.file)
        return describe(reading, settings, self.use_embed)


class LUMENRAY_OT_pack_luminaire_file(ActiveLuminaire, bpy.types.Operator):
    """Keep the content of the linked photometric file in the Blender file"""

    bl_idname = "lumenray.pack_luminaire_file"
    bl_label = "Embed Photometric File"

    @classmethod
    def problem(cls, settings):
        if settings is not None and settings.text is not None:
            return "The file is embedded already"
        if settings is not None and not settings.filepath:
            return "No photometric file is chosen"
        return super().problem(settings)

    def work(self, context, settings):
        files.pack(settings)
        return {"INFO"}, f"{files.name_of(settings)} is embedded"


class LUMENRAY_OT_unpack_luminaire_file(ActiveLuminaire, bpy.types.Operator):
    """Link the photometric file by its path; where it is not on disk, it is written beside the Blender file"""

    bl_idname = "lumenray.unpack_luminaire_file"
    bl_label = "Link Photometric File"

    @classmethod
    def problem(cls, settings):
        if settings is not None and settings.text is None:
            return "No file is embedded"
        return super().problem(settings)

    def work(self, context, settings):
        return {"INFO"}, f"linked to {files.unpack(settings)}"


class LUMENRAY_OT_reload_luminaire_file(ActiveLuminaire, bpy.types.Operator):
    """Read the photometric file anew from where it was read"""

    bl_idname = "lumenray.reload_luminaire_file"
    bl_label = "Reload Photometric File"

    @classmethod
    def problem(cls, settings):
        if settings is not None and not settings.filepath:
            return "It is not known where the file was read from"
        return super().problem(settings)

    def work(self, context, settings):
        is_embedded = settings.text is not None
        return describe(files.reload(settings), settings, is_embedded)


class LUMENRAY_OT_clear_luminaire_file(ActiveLuminaire, bpy.types.Operator):
    """Take the photometric file off the active light or empty"""

    bl_idname = "lumenray.clear_luminaire_file"
    bl_label = "Remove Photometric File"

    @classmethod
    def problem(cls, settings):
        if settings is not None and settings.text is None and not settings.filepath:
            return "No photometric file is chosen"
        return super().problem(settings)

    def work(self, context, settings):
        name, owner = files.name_of(settings), settings.id_data
        files.clear(settings)
        if isinstance(owner, bpy.types.Object):
            placing.remove_body(owner)
        return {"INFO"}, f"{name} is removed"


CLASSES = (
    LUMENRAY_OT_load_luminaire_file,
    LUMENRAY_OT_pack_luminaire_file,
    LUMENRAY_OT_unpack_luminaire_file,
    LUMENRAY_OT_reload_luminaire_file,
    LUMENRAY_OT_clear_luminaire_file,
)
