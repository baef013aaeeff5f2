"""Operators on the ray file of a light: load, prepare anew, add a light with one, and give it a body."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..blender_addon.file_assets.kind import NotReadyError
from ..blender_addon.foundation.selection import select_only
from ..blender_addon.raysets.files import ray_files
from ..blender_addon.raysets.settings import active_rays, rays_of
from ..blender_addon.readout import title_case
from ..engine.errors import LumenrayError
from ..engine.raysets.file_names import ENDINGS
from ..libraries.raysets import PREFIX
from ..libraries.raysets.catalogue import ENTRIES
from .file_operators import FileOperator, LoadFile, ReloadFile

FILTER = ";".join(f"*{ending}" for ending in ENDINGS)
"""Names that the file browser shows; what a file is follows from its content."""


def choose(settings, path: str) -> None:
    """Let settings name a file: one of ours, or one on disk."""
    settings.filepath = ray_files.stored(path)
    settings.use_file = True


def describe(settings, light) -> str:
    """Say what was loaded."""
    flux = "no lumens stated" if light.luminous_flux is None else f"{light.luminous_flux:.4g} lm"
    return f"{ray_files.name_of(settings)}: {light.rays} rays, {flux}"


class ActiveRays(FileOperator):
    """Operator on the ray file of the active light."""

    kind = ray_files
    nobody = "Select a point, spot or area light"
    find = staticmethod(active_rays)

    def take_up(self, settings) -> tuple[set[str], str]:
        """Have the rays prepared, and say so, or what they are."""
        try:
            light = ray_files.obtain(settings, bpy.app.background)
        except NotReadyError:
            return {"INFO"}, f"{ray_files.name_of(settings)}: its rays are being prepared"
        return {"INFO"}, describe(settings, light)


class LUMENRAY_OT_load_rayset(ActiveRays, LoadFile, bpy.types.Operator):
    """Let the active light shine as the rays of a measured or computed source do: TM-25, Zemax, LightTools, SPEOS, ASAP"""

    bl_idname = "lumenray.load_rayset"
    bl_label = "Load Ray File"

    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})

    def work(self, context, settings):
        before = settings.filepath, settings.use_file
        choose(settings, self.filepath)
        try:
            return self.take_up(settings)
        except LumenrayError:
            settings.filepath, settings.use_file = before
            raise


class LUMENRAY_OT_reload_rayset(ActiveRays, ReloadFile, bpy.types.Operator):
    """Read the ray file anew and prepare its rays"""

    bl_idname = "lumenray.reload_rayset"
    bl_label = "Reload Ray File"


class LUMENRAY_OT_add_rayset(bpy.types.Operator):
    """Add a light at the 3D cursor that shines as a ray set does: one of ours, or a file"""

    bl_idname = "lumenray.add_rayset"
    bl_label = "Ray Set"
    bl_options = {"REGISTER", "UNDO"}

    entry: EnumProperty(
        name="Ray Set",
        description="Source of the library, or a file. Default LED with Dome: the first of them",
        items=[
            *((entry.name, title_case(entry.title), entry.description) for entry in ENTRIES),
            ("FILE", "File…", "A file"),
        ],
    )
    filepath: StringProperty(
        description="Path of the ray file; empty asks for one",
        subtype="FILE_PATH",
        options={"SKIP_SAVE"},
    )
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
            light = ray_files.obtain(settings, bpy.app.background)
        except NotReadyError:
            light = None
        except LumenrayError as error:
            bpy.data.lights.remove(data)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        made = bpy.data.objects.new(title, data)
        made.location = context.scene.cursor.location
        context.collection.objects.link(made)
        select_only(context.view_layer, [made])
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
            "The body reflects and shades like any other mesh; right where the file's rays start outside of it. "
            "Else it only shows where the light is. Default off: most rays start inside the body"
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
