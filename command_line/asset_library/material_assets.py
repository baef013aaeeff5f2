"""Makes Blender assets of a folder of materials: one file with all of them, and the catalogues they are sorted into.

A material of ours names its scattering file as ``library:NAME``, one of a user's folder by the path from the asset file.
"""

import os
from functools import partial
from pathlib import Path

import bpy

from ...blender_addon.scattering.files import MEASURED, scattering_files
from ...blender_addon.scattering.look_nodes import wear_look
from ...engine.errors import LumenrayError
from ...libraries.materials import PREFIX, Entry, Library
from .build import Built, catalogue_id, set_preview, write_assets

ASSETS = "materials.blend"
"""File of the assets, in the library's folder."""

ROOT = "Materials"
"""Catalogue above all others."""

PREVIEW = 160
"""Side of the preview pictures. [pixel]"""

METAL_LOOKS = {
    "Ag": (0.95, 0.93, 0.88),
    "Al": (0.91, 0.92, 0.92),
    "Au": (1.00, 0.77, 0.31),
    "Cr": (0.55, 0.56, 0.55),
    "Cu": (0.95, 0.64, 0.54),
    "Ni_palik": (0.66, 0.61, 0.53),
    "W": (0.50, 0.48, 0.45),
}
"""Linear colours by which metals are shown where our engine does not draw. [-]"""


def build_material_assets(library: Library, folder: Path | None = None) -> Built:
    """Write the assets of a library and its catalogues; the open Blender file makes room for an empty one.

    Parameters
    ----------
    library : Library
    folder : Path or None    Where to; None: the library's own folder.

    Raises
    ------
    LumenrayError    Nothing can be written there, or there is nothing to write.
    """
    folder = folder or library.folder
    make = partial(_make_asset, folder=folder)
    return write_assets(library, library.entries, make, folder / ASSETS, ROOT, "material")


def _make_asset(entry: Entry, folder: Path) -> None:
    """Make what is dragged from the Asset Browser onto an object."""
    material = bpy.data.materials.new(entry.title)
    try:
        apply_settings(material, entry)
        if entry.model == MEASURED:
            wear_look(material, scattering_files.obtain(material.lumenray.measured).look)
            _relate(material.lumenray.measured, folder)
        else:
            _show(material, entry.settings)
    except LumenrayError:
        bpy.data.materials.remove(material)
        raise
    material.asset_mark()
    _describe(material.asset_data, entry)
    set_preview(material, entry.thumbnail, PREVIEW)


def apply_settings(material, entry: Entry) -> None:
    """Set the physical override of a material."""
    override = material.lumenray
    override.use_override = True
    for name, value in entry.settings.items():
        if isinstance(value, dict):
            group = getattr(override, name)
            for own, each in value.items():
                setattr(group, own, each)
        else:
            setattr(override, name, value)


def _relate(settings, folder: Path) -> None:
    """Name a file of the user's by its way from the asset file, so that the folder may be moved."""
    if not settings.filepath.startswith(PREFIX):
        way = os.path.relpath(settings.filepath, folder.resolve())
        settings.filepath = "//" + way.replace(os.sep, "/")


def _show(material, settings: dict) -> None:
    """Give a material without a file a look for solid shading, EEVEE and Cycles."""
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    shader = next(
        node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled"
    )
    roughness = settings.get("roughness", 0.0)
    colour, metallic, transmission = (1.0, 1.0, 1.0), 0.0, 0.0
    match settings["model"]:
        case "CONDUCTOR":
            colour, metallic = METAL_LOOKS.get(settings["metal"], (0.6, 0.6, 0.6)), 1.0
        case "DIELECTRIC" | "THIN_GLASS":
            transmission = 1.0
        case _:
            grey = settings.get("reflectance", 0.5)
            is_coloured = settings.get("reflectance_source") == "COLOR"
            colour = settings["reflectance_color"] if is_coloured else (grey, grey, grey)
    values = {
        "Base Color": (*colour, 1.0),
        "Metallic": metallic,
        "Roughness": roughness,
        "IOR": settings.get("ior", 1.5),
        "Transmission Weight": transmission,
    }
    for name, value in values.items():
        shader.inputs[name].default_value = value
    material.diffuse_color = (*colour, 1.0)
    material.metallic, material.roughness = metallic, roughness


def _describe(metadata, entry: Entry) -> None:
    shares = (("Reflects", entry.reflectance), ("Lets through", entry.transmittance))
    facts = [f"{words} {100.0 * share:.3g} %." for words, share in shares if share is not None]
    source = [f"Made from: {entry.source}."] if entry.source else []
    metadata.description = " ".join([entry.description, *facts, *source]).strip()
    metadata.author = entry.author
    metadata.license = entry.licence
    metadata.catalog_id = catalogue_id(entry.category, ROOT)
    for tag in entry.tags:
        metadata.tags.new(tag, skip_if_exists=True)
