"""Photometric files of the active light or empty: load, embed, link, and read anew."""

import bpy
from bpy.props import BoolProperty, StringProperty

from ..blender_addon.luminaires.files import EXTENSIONS, names_tilt_file, photometric_files
from ..blender_addon.luminaires.settings import active_settings
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
    from ..blender_addon.luminaires import placing

FILTER = ";".join(f"*{ending}" for ending in EXTENSIONS)
"""Names that the file browser shows."""

NO_TILT_FILE = "the TILT file that it names stays outside; link the luminaire to keep them together"


def describe(settings, reading, is_embedded: bool) -> tuple[set[str], str]:
    """Say what was loaded, as an operator reports it; ``is_embedded``: whether that was asked for."""
    text = settings.text
    words = f"{photometric_files.name_of(settings)}: {reading.flux:.4g} {reading.file.units.flux}"
    if is_embedded and text is None:
        return {"WARNING"}, f"{words}; linked, because Blender's texts cannot hold it"
    if text is not None and names_tilt_file(photometric_files.content_of(text)):
        return {"WARNING"}, f"{words}; {NO_TILT_FILE}"
    return tell(words, reading.file.remarks)


class ActiveLuminaire(FileOperator):
    """Operator on the photometric file of the active light or empty."""

    kind = photometric_files
    nobody = "Select a point, spot or area light, or an empty"
    find = staticmethod(active_settings)


class LUMENRAY_OT_load_luminaire_file(ActiveLuminaire, LoadFile, bpy.types.Operator):
    """Let the active light or empty shine as a photometric file says: IES, EULUMDAT or TM-33"""

    bl_idname = "lumenray.load_luminaire_file"
    bl_label = "Load Photometric File"

    filter_glob: StringProperty(default=FILTER, options={"HIDDEN"})
    use_embed: BoolProperty(
        name="Embed",
        description=(
            "Keep the file's content in the Blender file; else only its path. Default on: the file can be given "
            "away alone"
        ),
        default=True,
    )

    def work(self, context, settings):
        reading = photometric_files.load(settings, self.filepath, self.use_embed)
        owner = settings.id_data
        if isinstance(owner, bpy.types.Object) and placing.has_body(owner):
            placing.add_body(context, owner, reading.file)
        return describe(settings, reading, self.use_embed)


class LUMENRAY_OT_pack_luminaire_file(ActiveLuminaire, PackFile, bpy.types.Operator):
    """Keep the content of the linked photometric file in the Blender file"""

    bl_idname = "lumenray.pack_luminaire_file"
    bl_label = "Embed Photometric File"


class LUMENRAY_OT_unpack_luminaire_file(ActiveLuminaire, UnpackFile, bpy.types.Operator):
    """Link the photometric file by its path; where it is not on disk, it is written beside the Blender file"""

    bl_idname = "lumenray.unpack_luminaire_file"
    bl_label = "Link Photometric File"


class LUMENRAY_OT_reload_luminaire_file(ActiveLuminaire, ReloadFile, bpy.types.Operator):
    """Read the photometric file anew from where it was read"""

    bl_idname = "lumenray.reload_luminaire_file"
    bl_label = "Reload Photometric File"

    def work(self, context, settings):
        is_embedded = settings.text is not None
        return describe(settings, photometric_files.reload(settings), is_embedded)


class LUMENRAY_OT_clear_luminaire_file(ActiveLuminaire, WithFile, bpy.types.Operator):
    """Take the photometric file off the active light or empty"""

    bl_idname = "lumenray.clear_luminaire_file"
    bl_label = "Remove Photometric File"

    def work(self, context, settings):
        name, owner = photometric_files.name_of(settings), settings.id_data
        photometric_files.clear(settings)
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
