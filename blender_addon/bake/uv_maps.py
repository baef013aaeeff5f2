"""The atlas on the objects: UV maps of their own meshes by which its pages lie on them."""

from dataclasses import dataclass

import numpy as np

from ...engine.baking.order import BakeResult, Layout
from ..foundation.report import ConversionReport
from ..sync.meshes import BAKED_MAP

UV_MAP = BAKED_MAP
"""Name of the UV map that the atlas lies on."""

BACK = f"{BAKED_MAP} Back"
"""That of the back sides."""

MOST_MAPS = 8
"""UV maps that a mesh of Blender can hold."""

COLUMNS = 10
"""Pages of an atlas with several lie in rows of so many, as tiles of UDIM do."""


@dataclass(frozen=True)
class Corners:
    """Texture coordinates of a mesh's corners.

    Parameters
    ----------
    uv : (n, 2) float32 array    One row for each corner of the mesh's polygons.
    split : int    Polygons whose triangles lie in different places, so that one UV map cannot hold both.
    """

    uv: np.ndarray
    split: int


def tile_number(page: int) -> int:
    """Return the UDIM number of a page."""
    return 1001 + page


def shift(layout: Layout, pages: int) -> np.ndarray:
    """Texture coordinates with every page in its own unit square, if there are several. (t, 3, 2)"""
    if pages < 2:
        return layout.uv
    page = np.maximum(layout.page, 0)
    offset = np.stack([page % COLUMNS, page // COLUMNS], axis=1).astype(np.float32)
    return layout.uv + offset[:, None]


def store_layouts(result: BakeResult, sources: dict, report: ConversionReport) -> list:
    """Write the layouts into UV maps of the objects.

    Parameters
    ----------
    result : BakeResult
    sources : dict    Objects by engine id, None where one is gone.
    report : ConversionReport    Gets a row for every object whose mesh cannot hold its layout.

    Returns
    -------
    list of bpy.types.Object    Those that the atlas lies on now.
    """
    placed, fronts = {}, set()
    for made in result.maps:
        source = sources.get(made.id)
        if source is None:
            continue
        # The back of an object comes after its front.
        is_back = made.id in fronts
        fronts.add(made.id)
        if is_back and made.id not in placed:
            continue
        name = name_map(source, BACK if is_back else UV_MAP)
        if not place_layout(source, made.layout, len(result.pages), name, report):
            continue
        if is_back:
            source.lumenray.baked_back_uv = name
        else:
            source.lumenray.baked_uv, source.lumenray.baked_back_uv = name, ""
            placed[made.id] = source
    return list(placed.values())


def match_corners(mesh, layout: Layout, uv: np.ndarray) -> Corners | None:
    """Bring texture coordinates of triangles onto the corners of a mesh; None where its faces are others.

    Parameters
    ----------
    mesh : bpy.types.Mesh
    layout : Layout
    uv : (t, 3, 2) array    Of the layout's triangles.
    """
    if layout.polygon is None or layout.vertex_count != len(mesh.vertices):
        return None
    keys = layout.polygon[:, None].astype(np.int64) * layout.vertex_count + layout.triangles
    # Triangles without a place come last, so that they lend their corners to nobody.
    order = np.argsort(np.repeat(layout.page < 0, 3), kind="stable")
    keys, values = keys.ravel()[order], uv.reshape(-1, 2)[order]
    lies = np.repeat(layout.page >= 0, 3)[order]
    known, first, back = np.unique(keys, return_index=True, return_inverse=True)
    if len(known) != len(mesh.loops):
        return None
    vertex = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", vertex)
    total = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_total", total)
    polygon = np.repeat(np.arange(len(mesh.polygons), dtype=np.int64), total)
    wanted = polygon * layout.vertex_count + vertex
    found = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
    if not np.array_equal(known[found], wanted):
        return None
    differs = lies & (np.abs(values - values[first[back]]).max(axis=1) > 1e-5)
    split = len(np.unique(keys[differs] // layout.vertex_count))
    return Corners(np.ascontiguousarray(values[first[found]], dtype=np.float32), split)


def place_layout(
    source,
    layout: Layout,
    pages: int,
    name: str,
    report: ConversionReport,
    remedy: str = "its lux map is only written to disk",
) -> bool:
    """Write a layout into a UV map of an object.

    Parameters
    ----------
    source : bpy.types.Object
    layout : Layout
    pages : int    Of the whole atlas.
    name : str    Of the UV map.
    report : ConversionReport    Gets a row where the mesh cannot hold it.
    remedy : str    What becomes of the map then.

    Returns
    -------
    bool    Whether it lies on the object now.
    """
    if source.library is not None or source.data.library is not None:
        report.warn(source.name, "it is linked from another file", f"{remedy}; make it local")
        return False
    matched = None
    if source.type == "MESH":
        matched = match_corners(source.data, layout, shift(layout, pages))
    if matched is None:
        report.warn(
            source.name,
            "modifiers or its kind change the object's faces, so that its own UV maps cannot hold the layout",
            f"{remedy}; apply the modifiers to see it on the object",
        )
        return False
    data = source.data
    layer = data.uv_layers.get(name) or data.uv_layers.new(name=name, do_init=False)
    if layer is None:
        report.warn(
            source.name,
            f"its mesh holds {MOST_MAPS} UV maps already, the most that Blender allows",
            f"{remedy}; remove one, or give the object a mesh of its own",
        )
        return False
    if matched.split:
        report.warn(
            source.name,
            f"{matched.split} faces with more than three corners lie in several charts, which a UV map cannot hold",
            "they show wrong light in Blender, the files are right; triangulate the mesh",
        )
    layer.uv.foreach_set("vector", matched.uv.ravel())
    data.update()
    return True


def name_map(source, name: str) -> str:
    """Return the name of an object's own UV map; ``name``: that of all."""
    # Objects that share one mesh are baked one by one, so each needs a layout of its own.
    return name if source.data.users == 1 else f"{name} {source.name}"[:60]
