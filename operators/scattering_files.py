"""Scattering file of the active material: open, read anew, embed, link, and show its look in Blender's own views."""

import bpy
from bpy.props import StringProperty

from ..blender_addon.file_assets.kind import NotReadyError
from ..blender_addon.scattering.files import MEASURED, scattering_files
from ..blender_addon.scattering.settings import active_material
from ..engine.errors import LumenrayError
from ..engine.scattering.file_names import ENDINGS
from ..imports import loaded_when_used
from .file_operators import (
    FileOperator,
    LoadFile,
    PackFile,
    ReloadFile,
    UnpackFile,
    WithFile,
    tell,
)

with loaded_when_used():
    from ..blender_addon.scattering import look_nodes

FILTER = ";".join(f"*{ending}" for ending in ENDINGS)
"""Names that the file browser shows; what a file is follows from its content."""


class ActiveScattering(FileOperator):
    """Operator on the scattering file of the active material."""

    kind = scattering_files
    nobody = "Select an object with a material"
    elsewhere = "The material is linked from another file, where it can be changed"

    @staticmethod
    def find(context):
        material = active_material(context)
        return None if material is None else material.lumenray.measured

    def take_up(self, settings) -> tuple[set[str], str]:
        """Have the file read and give the material its look, at once or as soon as it is read; say so."""
        try:
            reading = scattering_files.obtain(settings, is_patient=bpy.app.background)
        except NotReadyError:
            look_nodes.show_when_ready(settings.id_data)
            return {"INFO"}, f"{scattering_files.name_of(settings)} is being read"
        look_nodes.show_look(settings.id_data, reading.look)
        words = f"{scattering_files.name_of(settings)}: {reading.file.format}"
        return tell(words, reading.file.remarks)


class LUMENRAY_OT_load_scattering_file(ActiveScattering, LoadFile, bpy.types.Operator):
    """Let the active material scatter as a file says: BRDF or BTDF of an instrument or a program"""

    bl_idname = "lumenray.load_scattering_file"
    bl_label = "Open Scattering File"

    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})

    def work(self, context, settings):
        owner = settings.id_data.lumenray
        before = settings.filepath, settings.text, owner.model, owner.use_override
        settings.filepath = scattering_files.stored(self.filepath)
        owner.model, owner.use_override = MEASURED, True
        try:
            return self.take_up(settings)
        except LumenrayError:
            # In this order: a path takes the place of the text.
            settings.filepath, settings.text, owner.model, owner.use_override = before
            raise


class LUMENRAY_OT_reload_scattering_file(ActiveScattering, ReloadFile, bpy.types.Operator):
    """Read the scattering file anew from its path; an embedded one from where it was read from, and embed it again"""

    bl_idname = "lumenray.reload_scattering_file"
    bl_label = "Reload Scattering File"


class LUMENRAY_OT_pack_scattering_file(ActiveScattering, PackFile, bpy.types.Operator):
    """Keep the content of the linked scattering file in the Blender file, in Lumenray's compact format"""

    bl_idname = "lumenray.pack_scattering_file"
    bl_label = "Embed Scattering File"


class LUMENRAY_OT_unpack_scattering_file(ActiveScattering, UnpackFile, bpy.types.Operator):
    """Link the scattering file by its path; it is written beside the Blender file, or into a folder"""

    bl_idname = "lumenray.unpack_scattering_file"
    bl_label = "Link Scattering File"

    directory: StringProperty(
        description="Folder that the file is written to", subtype="DIR_PATH", options={"SKIP_SAVE"}
    )

    def invoke(self, context, event):
        if bpy.data.filepath:
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, context, settings):
        return {"INFO"}, f"linked to {scattering_files.unpack(settings, self.directory)}"


class LUMENRAY_OT_fit_scattering_look(ActiveScattering, WithFile, bpy.types.Operator):
    """Show the material with a look near the file's in solid shading, EEVEE and Cycles; its own nodes and values are kept"""

    bl_idname = "lumenray.fit_scattering_look"
    bl_label = "Fit Viewport Look"

    def work(self, context, settings):
        material = settings.id_data
        look_nodes.show_look(material, scattering_files.obtain(settings).look)
        return {"INFO"}, f"'{material.name}' looks like {scattering_files.name_of(settings)}"


CLASSES = (
    LUMENRAY_OT_load_scattering_file,
    LUMENRAY_OT_reload_scattering_file,
    LUMENRAY_OT_pack_scattering_file,
    LUMENRAY_OT_unpack_scattering_file,
    LUMENRAY_OT_fit_scattering_look,
)
