"""Maps of a year as images of the file: which they are, and on what they lie."""

import bpy

from ...engine.errors import SceneError
from ..sync.meshes import BAKED_MAP
from .uv_maps import name_map

FACTS = "lumenray_year"
"""Custom property of an image that tells what it holds."""

UV_MAP = f"{BAKED_MAP} Year"
"""Name of the UV map that the maps lie on."""


def find_image(figure: str):
    """Return the image with the map of a figure, None if there is none."""
    for image in bpy.data.images:
        if FACTS in image and image[FACTS].get("figure") == figure:
            return image
    return None


def facts_of(figure: str) -> dict:
    """Return unit and upper end of the scale of a figure's map.

    Raises
    ------
    SceneError    There is no such map.
    """
    image = find_image(figure)
    if image is None:
        raise SceneError("nothing to show: compute a year with maps first")
    return image[FACTS].to_dict()


def find_objects(scene) -> list:
    """Return the objects of a scene on which maps lie."""
    return [
        source
        for source in scene.objects
        if source.type == "MESH" and source.data.uv_layers.get(name_map(source, UV_MAP)) is not None
    ]


def remove_maps() -> None:
    """Take the images and UV maps of an earlier year out of the file."""
    for image in list(bpy.data.images):
        if FACTS in image:
            bpy.data.images.remove(image)
    for mesh in bpy.data.meshes:
        for layer in [each for each in mesh.uv_layers if f"{each.name} ".startswith(f"{UV_MAP} ")]:
            if mesh.library is None:
                mesh.uv_layers.remove(layer)
