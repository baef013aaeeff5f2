"""Operators on the ray file of a light: load, prepare anew, add a light with one, and give it a body."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..blender_addon.luminaires.files import stored_path
from ..blender_addon.raysets import files
from ..blender_addon.raysets import readout as rayset_readout
from ..blender_addon.raysets.settings import active_rays, rays_of
from ..blender_addon.raysets.source import name_of
from ..blender_addon.readout import title_case
from ..engine.errors import LumenrayError
from ..libraries.raysets import PREFIX
from ..libraries.raysets.catalogue import ENTRIES

FILTER = "*.tm25ray;*.ray;*.dat;*.dis;*.txt;*.rsf;*.src;*.sdf"
"""Names that the file browser shows; what a file is follows from its content."""


class ActiveRays:
    """Operator on the ray file of the active light."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        settings = active_rays(context)
        if settings is None:
            cls.poll_message_set("Select a point, spot or area light")
        elif settings.id_data.library is not None:
            cls.poll_message_set("It is linked from another file, where it can be changed")
        else:
            return True
        return False


def choose(settings, path: str) -> None:
    """Let settings name a file: one of ours, or one on disk."""
    settings.filepath = path if path.startswith((PREFIX, "//")) else stored_path(path)
    settings.use_file = True


class LUMENRAY_OT_load_rayset(ActiveRays, bpy.types.Operator):
    """Let the active light shine as the rays of a measured or computed source do: TM-25, Zemax, LightTools, SPEOS, ASAP"""

    bl_idname = "lumenray.load_rayset"
    bl_label = "Load Ray File"

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})

    def invoke(self, context, event):
        if self.filepath:
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        settings = active_rays(context)
        before = settings.filepath, settings.use_file
        choose(settings, self.filepath)
        try:
            light = files.obtain(settings, bpy.app.background)
        except files.NotReadyError:
            self.report({"INFO"}, f"{name_of(settings)}: its rays are being prepared")
            return {"FINISHED"}
        except LumenrayError as error:
            settings.filepath, settings.use_file = before
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, describe(settings, light))
        return {"FINISHED"}


def describe(settings, light) -> str:
    """Say what was loaded."""
    flux = "no lumens stated" if light.luminous_flux is None else f"{light.luminous_flux:.4g} lm"
    return f"{name_of(settings)}: {light.rays} rays, {flux}"


class LUMENRAY_OT_reload_rayset(ActiveRays, bpy.types.Operator):
    """Read the ray file anew and prepare its rays"""

    bl_idname = "lumenray.reload_rayset"
    bl_label = "Reload Ray File"

    def execute(self, context):
        settings = active_rays(context)
        files.forget(settings)
        settings.id_data.update_tag()
        state = rayset_readout.state_of(settings)
        if state.problem:
            self.report({"ERROR"}, state.problem)
            return {"CANCELLED"}
        return {"FINISHED"}


class LUMENRAY_OT_add_rayset(bpy.types.Operator):
    """Add a light at the 3D cursor that shines as a ray set does: one of ours, or a file"""

    bl_idname = "lumenray.add_rayset"
    bl_label = "Ray Set"
    bl_options = {"REGISTER", "UNDO"}

    entry: EnumProperty(
        name="Ray Set",
        description="Which source",
        items=[
            *((entry.name, title_case(entry.title), entry.description) for entry in ENTRIES),
            ("FILE", "File…", "A file"),
        ],
    )
    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def invoke(self, context, event):
        if self.entry == "FILE" and not self.filepath:
            context.window_manager.fileselect_add(self)
            return {"RUNNING_MODAL"}
        return self.execute(context)

    def execute(self, context):
        ours = next((e for e in ENTRIES if e.name == self.entry), None)
        if ours is None and not self.filepath:
            self.report({"ERROR"}, "no ray file is chosen")
            return {"CANCELLED"}
        title = ours.title if ours is not None else Path(self.filepath).stem
        data = bpy.data.lights.new(title, "POINT")
        data.shadow_soft_size = 0.0
        settings = data.lumenray.rayset
        choose(settings, PREFIX + ours.name if ours is not None else self.filepath)
        if ours is not None:
            _set_spectrum(data.lumenray, ours.spectrum)
            settings.spectrum_source = "LIGHT"
        try:
            light = files.obtain(settings, bpy.app.background)
        except files.NotReadyError:
            light = None
        except LumenrayError as error:
            bpy.data.lights.remove(data)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        made = bpy.data.objects.new(title, data)
        made.location = context.scene.cursor.location
        context.collection.objects.link(made)
        for thing in context.selected_objects:
            thing.select_set(False)
        made.select_set(True)
        context.view_layer.objects.active = made
        if light is not None:
            self.report({"INFO"}, describe(settings, light))
        return {"FINISHED"}


def _set_spectrum(settings, spectrum: str) -> None:
    """Let a light have the spectrum of an entry: a colour temperature or an illuminant."""
    settings.use_physical = True
    if spectrum.endswith(" K"):
        settings.spectrum = "BLACKBODY"
        settings.colour_temperature = float(spectrum.removesuffix(" K"))
    else:
        settings.spectrum, settings.illuminant = "ILLUMINANT", spectrum


class LUMENRAY_OT_parent_rayset_body(bpy.types.Operator):
    """Make the other selected meshes the body of the active light: they move with it and do not block its light"""

    bl_idname = "lumenray.parent_rayset_body"
    bl_label = "Make Body of Ray Set"
    bl_options = {"REGISTER", "UNDO"}

    is_lit: BoolProperty(
        name="Part of the Light Calculation",
        description=(
            "The body reflects and shades like any other mesh; right where the file's rays start outside of it. Else it "
            "only shows where the light is"
        ),
        default=False,
    )

    @classmethod
    def poll(cls, context):
        settings = rays_of(context.object)
        if settings is None or not settings.use_file:
            cls.poll_message_set("The active object has to be a light with a ray file")
            return False
        if not _bodies(context):
            cls.poll_message_set("Select the meshes of the body too")
            return False
        return True

    def execute(self, context):
        light = context.object
        bodies = _bodies(context)
        for body in bodies:
            place = body.matrix_world.copy()
            body.parent = light
            body.matrix_parent_inverse = light.matrix_world.inverted()
            body.matrix_world = place
            body.lumenray.is_luminaire_body = not self.is_lit
            body.update_tag()
        self.report(
            {"INFO"}, f"{len(bodies)} mesh{'es' if len(bodies) > 1 else ''} of '{light.name}'"
        )
        return {"FINISHED"}


def _bodies(context) -> list:
    """Selected meshes beside the active object."""
    return [
        thing
        for thing in context.selected_objects
        if thing.type == "MESH" and thing != context.object and thing.library is None
    ]


CLASSES = (
    LUMENRAY_OT_load_rayset,
    LUMENRAY_OT_reload_rayset,
    LUMENRAY_OT_add_rayset,
    LUMENRAY_OT_parent_rayset_body,
)
