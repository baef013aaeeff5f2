"""Composition of the active material's pigment layer: presets and files."""

import json
from pathlib import Path

import bpy
from bpy.props import StringProperty

from ..blender_addon.scattering.settings import active_material
from ..blender_addon.surface_models import INK
from ..engine.errors import LumenrayError
from ..imports import loaded_when_used
from .file_operators import LoadFile
from .paints import FILTER

with loaded_when_used():
    from ..blender_addon.inks import description, presets, tables
    from ..engine.reading import whole_file


class InkOperator:
    """Operator on the pigment layer of the active material."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        material = active_material(context)
        if material is None:
            cls.poll_message_set("Select an object with a material")
            return False
        if material.library is not None:
            cls.poll_message_set(
                "The material is linked from another file, where it can be changed"
            )
            return False
        if not tables.is_ink(material):
            cls.poll_message_set("The material's model is not Pigment Layer")
            return False
        return True

    def execute(self, context):
        material = active_material(context)
        try:
            words = self.work(context, material.lumenray.ink)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        material.update_tag()
        if words:
            self.report({"INFO"}, words)
        return {"FINISHED"}


class LUMENRAY_OT_load_ink(LoadFile, bpy.types.Operator):
    """Let the active material be a pigment layer as a file describes it, by Lumenray's schema of compositions"""

    bl_idname = "lumenray.load_ink"
    bl_label = "Open Pigment Layer"
    nobody = "Select an object with a material"
    elsewhere = "The material is linked from another file, where it can be changed"

    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})

    @staticmethod
    def find(context):
        material = active_material(context)
        return None if material is None else material.lumenray.ink

    def work(self, context, settings):
        presets.load(settings, bpy.path.abspath(self.filepath))
        owner = settings.id_data.lumenray
        owner.model, owner.use_override = INK, True
        return {"INFO"}, f"{settings.name or Path(self.filepath).stem} is taken over"


class LUMENRAY_OT_save_ink(InkOperator, bpy.types.Operator):
    """Write the composition of the pigment layer as a JSON file, which other scenes and the command 'lumenray ink' read"""

    bl_idname = "lumenray.save_ink"
    bl_label = "Save Pigment Layer"

    filepath: StringProperty(
        description="Path of the file", subtype="FILE_PATH", options={"SKIP_SAVE"}
    )
    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})
    check_existing: bpy.props.BoolProperty(default=True, options={"HIDDEN"})

    def invoke(self, context, event):
        if self.filepath:
            return self.execute(context)
        name = active_material(context).lumenray.ink.name or "print"
        self.filepath = bpy.path.clean_name(name).lower() + ".json"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, context, settings):
        """Write it."""
        path = Path(bpy.path.abspath(bpy.path.ensure_ext(self.filepath, ".json")))
        text = json.dumps(description.describe(settings), indent=2, ensure_ascii=False)
        with whole_file.write_whole(path, "utf-8") as stream:
            stream.write(text + "\n")
        return f"{path.name} is written"


class LUMENRAY_OT_set_ink_preset(InkOperator, bpy.types.Operator):
    """Take over the composition of a preset; what was set before is gone but for undoing"""

    bl_idname = "lumenray.set_ink_preset"
    bl_label = "Pigment Layer Preset"

    preset: StringProperty(description="Name of the preset's file without its ending")

    def work(self, context, settings):
        """Load it."""
        path = presets.shipped().get(self.preset)
        if path is None:
            raise LumenrayError(f"there is no preset '{self.preset}'")
        presets.load(settings, path)


CLASSES = (LUMENRAY_OT_load_ink, LUMENRAY_OT_save_ink, LUMENRAY_OT_set_ink_preset)
