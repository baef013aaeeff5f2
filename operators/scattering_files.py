"""Scattering file of the active material: open, read anew, embed, link, and show its look in Blender's own views."""

import bpy
from bpy.props import StringProperty

from ..blender_addon.luminaires.files import stored_path
from ..blender_addon.scattering import files
from ..blender_addon.scattering.look_nodes import show_look, show_when_ready
from ..blender_addon.scattering.settings import active_material
from ..blender_addon.scattering.source import MEASURED, name_of
from ..engine.errors import LumenrayError
from ..libraries.materials import PREFIX

FILTER = (
    "*.lumbsdf;*.bsdf;*.brdf;*.btdf;*.xml;*.binary;*.mbsdf;*.simplescattering;*.scattering;*.coated;*.anisotropicbsdf;"
    "*.bsdf180;*.astm;*.csv;*.txt;*.dat"
)
"""Names that the file browser shows; what a file is follows from its content."""


class ActiveScattering:
    """Operator on the scattering file of the active material."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        material = active_material(context)
        problem = cls.problem(material)
        if problem:
            cls.poll_message_set(problem)
        return not problem

    @classmethod
    def problem(cls, material) -> str:
        """Say why the operator cannot be used, empty if it can."""
        if material is None:
            return "Select an object with a material"
        if material.library is not None:
            return "The material is linked from another file, where it can be changed"
        return ""

    def execute(self, context):
        try:
            self.report(*self.work(active_material(context)))
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class WithFile(ActiveScattering):
    """Operator that needs a file to be chosen."""

    @classmethod
    def problem(cls, material) -> str:
        found = super().problem(material)
        if found:
            return found
        settings = material.lumenray.measured
        has_file = settings.text is not None or settings.filepath
        return "" if has_file else "No scattering file is chosen"


def describe(material, reading) -> tuple[set[str], str]:
    """Say what was read, as an operator reports it."""
    words = f"{name_of(material.lumenray.measured)}: {reading.file.format}"
    remarks = reading.file.remarks
    if not remarks:
        return {"INFO"}, words
    count = f"{len(remarks)} remarks, the first: " if len(remarks) > 1 else ""
    return {"WARNING"}, f"{words}; {count}{remarks[0]}"


def take_up(material) -> tuple[set[str], str]:
    """Read the file of a material and give the material its look, at once or as soon as it is read.

    Raises
    ------
    LumenrayError    It cannot be read.
    """
    settings = material.lumenray.measured
    try:
        reading = files.obtain(settings, is_patient=bpy.app.background)
    except files.NotReadyError:
        show_when_ready(material)
        return {"INFO"}, f"{name_of(settings)} is being read"
    show_look(material, reading.look)
    return describe(material, reading)


class LUMENRAY_OT_load_scattering_file(ActiveScattering, bpy.types.Operator):
    """Let the active material scatter as a file says: BRDF or BTDF of an instrument or a program"""

    bl_idname = "lumenray.load_scattering_file"
    bl_label = "Open Scattering File"

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})

    def invoke(self, context, event):
        if self.filepath:
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, material):
        owner, settings = material.lumenray, material.lumenray.measured
        before = settings.filepath, settings.text, owner.model, owner.use_override
        is_stored = self.filepath.startswith((PREFIX, "//"))
        settings.filepath = self.filepath if is_stored else stored_path(self.filepath)
        owner.model, owner.use_override = MEASURED, True
        try:
            return take_up(material)
        except LumenrayError:
            # In this order: a path takes the place of the text.
            settings.filepath, settings.text, owner.model, owner.use_override = before
            raise


class LUMENRAY_OT_reload_scattering_file(WithFile, bpy.types.Operator):
    """Read the scattering file anew from its path; an embedded one from where it was read from, and embed it again"""

    bl_idname = "lumenray.reload_scattering_file"
    bl_label = "Reload Scattering File"

    @classmethod
    def problem(cls, material):
        found = super().problem(material)
        if not found and not material.lumenray.measured.filepath:
            return "It is not known where the file was read from"
        return found

    def work(self, material):
        settings, text = material.lumenray.measured, material.lumenray.measured.text
        files.forget()
        material.update_tag()
        if text is None:
            return take_up(material)
        try:
            settings.text = None
            files.pack(settings)
        except LumenrayError:
            settings.text = text
            raise
        return take_up(material)


class LUMENRAY_OT_pack_scattering_file(WithFile, bpy.types.Operator):
    """Keep the content of the linked scattering file in the Blender file, in Lumenray's compact format"""

    bl_idname = "lumenray.pack_scattering_file"
    bl_label = "Embed Scattering File"

    @classmethod
    def problem(cls, material):
        found = super().problem(material)
        if not found and material.lumenray.measured.text is not None:
            return "The file is embedded already"
        return found

    def work(self, material):
        settings = material.lumenray.measured
        files.pack(settings)
        return {"INFO"}, f"{name_of(settings)} is embedded"


class LUMENRAY_OT_unpack_scattering_file(ActiveScattering, bpy.types.Operator):
    """Link the scattering file by its path; it is written beside the Blender file, or into a folder"""

    bl_idname = "lumenray.unpack_scattering_file"
    bl_label = "Link Scattering File"

    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE"})

    @classmethod
    def problem(cls, material):
        found = super().problem(material)
        if not found and material.lumenray.measured.text is None:
            return "No file is embedded"
        return found

    def invoke(self, context, event):
        if bpy.data.filepath:
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, material):
        path = files.unpack(material.lumenray.measured, self.directory)
        return {"INFO"}, f"linked to {path}"


class LUMENRAY_OT_fit_scattering_look(WithFile, bpy.types.Operator):
    """Show the material with a look near the file's in solid shading, EEVEE and Cycles; its own nodes and values are kept"""

    bl_idname = "lumenray.fit_scattering_look"
    bl_label = "Fit Viewport Look"

    def work(self, material):
        reading = files.obtain(material.lumenray.measured)
        show_look(material, reading.look)
        return {"INFO"}, f"'{material.name}' looks like {name_of(material.lumenray.measured)}"


CLASSES = (
    LUMENRAY_OT_load_scattering_file,
    LUMENRAY_OT_reload_scattering_file,
    LUMENRAY_OT_pack_scattering_file,
    LUMENRAY_OT_unpack_scattering_file,
    LUMENRAY_OT_fit_scattering_look,
)
