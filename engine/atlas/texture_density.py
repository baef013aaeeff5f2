"""How dense a mesh's own pictures lie on it."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass

import numpy as np

from ..scene.material import Material
from ..scene.mesh import Mesh, find_uv_map
from ..scene.texture import ImageTexture


def texture_density(mesh: Mesh, materials: Mapping[str, Material]) -> float:
    """Find the pixels per metre of a mesh's pictures.

    Where a material has several, the densest counts; over the triangles that have any, the mean by area.

    Parameters
    ----------
    mesh : Mesh
    materials : mapping of str to Material    By id; missing ones have no pictures.

    Returns
    -------
    float    Square root of pixels per area; 0 without pictures, or where these have no extent on the surface. [1/m]
    """
    area = mesh.areas()
    pixels = np.zeros(len(area))
    for slot, key in enumerate(mesh.materials):
        rows = np.flatnonzero(np.minimum(mesh.material_index, len(mesh.materials) - 1) == slot)
        if len(rows) and key in materials:
            for picture in _find_pictures(materials[key]):
                pixels[rows] = np.maximum(pixels[rows], _count_pixels(mesh, picture, rows))
    shown = pixels > 0.0
    whole = float(area[shown].sum())
    return float(np.sqrt(pixels[shown].sum() / whole)) if whole > 0.0 else 0.0


def _find_pictures(value):
    """Yield all pictures in a material."""
    if isinstance(value, ImageTexture):
        yield value
    elif is_dataclass(value):
        for entry in fields(value):
            yield from _find_pictures(getattr(value, entry.name))


def _count_pixels(mesh: Mesh, picture: ImageTexture, rows: np.ndarray) -> np.ndarray:
    """Pixels of a picture that triangles show. (n,)"""
    uv = find_uv_map(mesh.uv_maps, picture.uv_map)
    if uv is None or isinstance(picture.pixels, str):
        return np.zeros(len(rows))
    corners = uv[rows].astype(np.float64) @ picture.transform[:2, :2].T
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    height, width = picture.pixels.shape[:2]
    if picture.tiles:
        # The finest of them counts for all.
        width, height = (max(tile[k] for tile in picture.tiles) for k in (2, 3))
    return 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) * width * height
