"""What operators on the composition of the active material share, whether it is a paint, a pigment layer or a cloth."""

import json
from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty

from ..blender_addon.compositions import presets as own_presets
from ..blender_addon.scattering.settings import active_material
from ..blender_addon.surface_models import MODELS
from ..engine.errors import LumenrayError
from ..imports import loaded_when_used
from .file_operators import LoadFile

with loaded_when_used():
    from ..engine.reading import whole_file

FILTER = "*.json"
"""Names that the file browser shows."""

NOBODY = "Select an object with a material"
ELSEWHERE = "The material is linked from another file, where it can be changed"


class CompositionOperator:
    """Operator on the composition of the active material.

    Each kind of composition gives ``model``, the surface model; ``group``, the name of its settings; ``folder``, where its
    users' presets lie; ``describe``, which returns what settings state as a file has it; and ``tables``, which returns what
    computes them. An operator's ``work`` returns what is reported, if anything.
    """

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        material = active_material(context)
        if material is None:
            cls.poll_message_set(NOBODY)
            return False
        if material.library is not None:
            cls.poll_message_set(ELSEWHERE)
            return False
        own = material.lumenray
        if not own.use_override or own.model != cls.model:
            cls.poll_message_set(f"The material's model is not {MODELS[cls.model].title}")
            return False
        return True

    def execute(self, context):
        material = active_material(context)
        try:
            words = self.work(context, getattr(material.lumenray, self.group))
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        material.update_tag()
        if words:
            self.report({"INFO"}, words)
        return {"FINISHED"}

    def write(self, path: Path, settings) -> None:
        """Write the composition as a file."""
        text = json.dumps(self.describe(settings), indent=2, ensure_ascii=False)
        with whole_file.write_whole(path, "utf-8") as stream:
            stream.write(text + "\n")


class SetPreset(CompositionOperator):
    """Operator that takes over a preset by ``load``; ``known`` returns the files of all there are, by name."""

    preset: StringProperty(description="Name of the preset's file without its ending")

    def work(self, context, settings):
        """Load it."""
        path = self.known().get(self.preset)
        if path is None:
            raise LumenrayError(f"there is no preset '{self.preset}'")
        self.load(settings, path)


class LoadComposition(LoadFile):
    """Operator that takes over a composition from a file by ``load``; gives ``model`` and ``group`` as above."""

    nobody, elsewhere = NOBODY, ELSEWHERE

    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})

    @classmethod
    def find(cls, context):
        material = active_material(context)
        return None if material is None else getattr(material.lumenray, cls.group)

    def work(self, context, settings):
        self.load(settings, bpy.path.abspath(self.filepath))
        owner = settings.id_data.lumenray
        owner.model, owner.use_override = self.model, True
        return {"INFO"}, f"{settings.name or Path(self.filepath).stem} is taken over"


class SaveComposition(CompositionOperator):
    """Operator that writes a composition as a file; ``unnamed``: what a file of one without a name is called."""

    filepath: StringProperty(
        description="Path of the file", subtype="FILE_PATH", options={"SKIP_SAVE"}
    )
    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})
    check_existing: BoolProperty(default=True, options={"HIDDEN"})

    def invoke(self, context, event):
        if self.filepath:
            return self.execute(context)
        name = getattr(active_material(context).lumenray, self.group).name or self.unnamed
        self.filepath = bpy.path.clean_name(name).lower() + ".json"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, context, settings):
        """Write it."""
        path = Path(bpy.path.abspath(bpy.path.ensure_ext(self.filepath, ".json")))
        self.write(path, settings)
        return f"{path.name} is written"


class AddCompositionPreset(CompositionOperator):
    """Operator that keeps a composition as a preset of the user."""

    name: StringProperty(name="Name", description="Of the preset; one of this name is replaced")

    def invoke(self, context, event):
        self.name = getattr(active_material(context).lumenray, self.group).name
        return context.window_manager.invoke_props_dialog(self)

    def work(self, context, settings):
        """Write it."""
        name = bpy.path.clean_name(self.name).strip("_").lower()
        if not name:
            raise LumenrayError("a preset needs a name")
        self.write(own_presets.folder_of(self.folder) / f"{name}.json", settings)
        return f"'{own_presets.title_of(name)}' is among the presets"


class CancelComposition(CompositionOperator):
    """Operator that ends the computation of a table."""

    bl_options = {"INTERNAL"}

    def work(self, context, settings):
        """End it."""
        self.tables().stop(settings)


class ComputeComposition(CompositionOperator):
    """Operator that begins the computation of a table that was cancelled."""

    bl_options = {"INTERNAL"}

    def work(self, context, settings):
        """Begin it."""
        self.tables().restart(settings)
