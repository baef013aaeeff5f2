"""Baked scenes as glTF 2.0, for walking through them in viewers that compute no light.

Every surface shows a colour that light does not change any more (``KHR_materials_unlit``): that of the baked light, or the
illuminance in false colours. Both can be in one file, to be switched (``KHR_materials_variants``).

References
----------
Khronos Group: glTF 2.0 Specification (ISO/IEC 12113:2022); extensions KHR_materials_unlit, KHR_materials_variants.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import VERSION
from ..errors import FileFormatError, SceneError
from ..scene.material import Material
from ..scene.mesh import Mesh
from .gltf_file import Buffer, write_container
from .gltf_geometry import make_part, turn_upright, unit_normals
from .gltf_materials import LOOKS, Light, Palette, Textures
from .gltf_pages import TexturePlan, plan_textures
from .gltf_scene import NOWHERE, ShownObject, ShownScene, Side
from .report import known

UNSEEN = 0.999
"""A surface that lets more than this share of the light pass straight is nothing to be seen."""

LINEAR, MIPMAPPED, CLAMPED = 9729, 9987, 33071
"""How textures are looked up. Charts have rims, so smaller copies may be mixed in."""


@dataclass(frozen=True)
class GltfLimits:
    """What the file may ask of a viewer.

    Parameters
    ----------
    textures : int    Most textures, of all looks together.
    size : int    Largest side of one. [texel]
    """

    textures: int = 16
    size: int = 2048


def write_gltf(
    path,
    meshes: list[Mesh],
    materials: dict[str, Material],
    result,
    *,
    white: float,
    limits: GltfLimits = GltfLimits(),
    look: str = "light",
    variants: bool = True,
    top: float | None = None,
) -> list[Path]:
    """Write meshes with their baked light.

    Parameters
    ----------
    path : str or Path    ``.glb`` puts all in one file, ``.gltf`` the buffer and the textures into files beside it.
    meshes : list of Mesh    What is to be seen. What is neither baked nor glowing nor see-through is left out, for its light
        is not known, and named in the file.
    materials : dict of str to Material    By id.
    result : BakeResult    With the pages' arrays. If it has the exitance the light is in colour and pictures on surfaces
        are seen as far as the lumels resolve them; else the light is neutral, and a surface has one colour.
    white : float    Luminance that is shown as white. [cd/m2]
    limits : GltfLimits    Pages are put together and halved to keep to it.
    look : str    What is seen first: ``light`` or ``false_colour``.
    variants : bool    Whether the other look is in the file too, as the variant ``light`` or ``illuminance``.
    top : float or None    Top of the scale of false colours; None: a round number that nearly all lumels lie under. [lx]

    Returns
    -------
    list of Path    What was written, the named file first.

    Raises
    ------
    SceneError    There is nothing to show, the pages' arrays are not there, or they do not fit the limits.
    FileFormatError    The name ends otherwise, or the file cannot be written.

    Notes
    -----
    Codes are those of sRGB. Luminances up to white are shown in proportion; brighter ones are white, in their hue. Without
    exitance, surfaces darker than the brightest one reach their limit at the illuminance that turns that one white.
    """
    path = Path(path)
    _check(path, white, limits, look, top)
    scene = ShownScene(meshes, materials, result)
    looks = [look, *(other for other in LOOKS if variants and other != look)]
    if limits.textures < len(looks) and scene.pages:
        raise SceneError(
            f"{len(looks)} looks need as many textures at least, {limits.textures} is the limit; "
            f"leave out the variants or allow more textures"
        )
    plan = plan_textures(scene.pages, limits.textures // len(looks), limits.size)
    light = Light(scene, white)
    top = scene.find_top() if top is None else float(top)
    textures = Textures(scene, plan, looks, light, top)
    palette = Palette(textures, light)
    buffer = Buffer()
    nodes, drawn = [], []
    for shown in scene.objects:
        part = _write_object(buffer, palette, plan, scene, shown)
        if part is not None:
            node, mesh = part
            nodes.append({**node, "mesh": len(drawn)})
            drawn.append(mesh)
    if not nodes:
        raise SceneError("no object has a surface to be shown, so there is nothing to write")
    content = {
        "asset": {
            "version": "2.0",
            "generator": f"Lumenray {VERSION}",
            "extras": _describe(scene, white, plan),
        },
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": drawn,
        "materials": palette.materials,
        "extensionsUsed": ["KHR_materials_unlit"],
    }
    if textures.entries:
        content["samplers"] = [
            {"magFilter": LINEAR, "minFilter": MIPMAPPED, "wrapS": CLAMPED, "wrapT": CLAMPED}
        ]
        content["textures"] = textures.entries
    if palette.has_variants:
        content["extensionsUsed"].append("KHR_materials_variants")
        names = [{"name": LOOKS[name]} for name in looks]
        content["extensions"] = {"KHR_materials_variants": {"variants": names}}
    return write_container(path, content, buffer, textures.pictures)


def _check(path: Path, white: float, limits: GltfLimits, look: str, top: float | None) -> None:
    if path.suffix.lower() not in {".glb", ".gltf"}:
        raise FileFormatError(path, "the name of a glTF file ends in .glb or .gltf")
    if not (math.isfinite(white) and white > 0.0):
        raise SceneError(f"the luminance of white must be above 0 cd/m2, found {white:g}")
    if top is not None and not (math.isfinite(top) and top > 0.0):
        raise SceneError(f"the top of the scale must be above 0 lx, found {top:g}")
    if look not in LOOKS:
        raise SceneError(f"unknown look '{look}', expected one of {', '.join(LOOKS)}")
    if limits.textures < 1 or limits.size < 1:
        raise SceneError(
            f"a file needs a texture of at least one texel, the limits are {limits.textures} textures of "
            f"{limits.size} texels"
        )


def _write_object(
    buffer: Buffer, palette: Palette, plan: TexturePlan, scene: ShownScene, shown: ShownObject
) -> tuple[dict, dict] | None:
    """Write an object's triangles and return its node and its mesh, None if nothing of it is to be seen."""
    mesh = shown.mesh
    found = [_find_places(plan, shown, side) for side in shown.sides]
    texture, uv, is_kept = (np.concatenate(parts) for parts in zip(*found, strict=True))
    slot = np.concatenate([mesh.material_index[side.rows] for side in shown.sides]).astype(np.int64)
    triangles = np.concatenate([side.triangles for side in shown.sides])
    is_unknown = (
        is_kept
        & (texture == NOWHERE)
        & np.array([colour.needs_light for colour in shown.colours])[slot]
    )
    if is_unknown.any():
        scene.left_out.append(mesh.name)
    is_kept &= ~is_unknown
    if not is_kept.any():
        return None
    vertices = turn_upright(np.asarray(mesh.vertices, dtype=np.float64))
    normals = None
    if mesh.corner_normals is not None:
        given = turn_upright(np.concatenate([side.normals for side in shown.sides]))
        normals = unit_normals(given, vertices, triangles)
    seen = vertices[np.unique(triangles[is_kept])]
    # A place that single precision holds exactly, so that no viewer adds an error of its own.
    origin = (0.5 * (seen.min(axis=0) + seen.max(axis=0))).astype(np.float32)
    vertices = vertices - origin
    mean = sum(made.mean * made.area for made in shown.maps) / max(
        sum(made.area for made in shown.maps), 1e-30
    )
    rows = np.flatnonzero(is_kept)
    group = (texture[rows] + 1) * len(shown.colours) + slot[rows]
    rows, group = rows[np.argsort(group, kind="stable")], np.sort(group)
    primitives = []
    for part in np.split(rows, np.flatnonzero(np.diff(group)) + 1):
        number, kind = int(texture[part[0]]), int(slot[part[0]])
        primitives.append(
            {
                **_write_part(
                    buffer,
                    vertices,
                    triangles[part],
                    None if normals is None else normals[part],
                    None if number == NOWHERE else uv[part],
                ),
                **palette.fields(shown.colours[kind], number, mean, shown.is_double),
            }
        )
    node = {
        "name": mesh.name,
        "translation": [float(v) for v in origin],
        "extras": _describe_object(shown),
    }
    return node, {"name": mesh.name, "primitives": primitives}


def _find_places(
    plan: TexturePlan, shown: ShownObject, side: Side
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Texture (t,) and coordinates (t, 3, 2) of a side's triangles, and which are to be seen (t,)."""
    slot = shown.mesh.material_index[side.rows]
    is_seen = np.array([colour.passing < UNSEEN for colour in shown.colours])[slot]
    if side.uv is None:
        return side.page.astype(np.int64), np.zeros((len(slot), 3, 2), np.float32), is_seen
    texture, uv = plan.place(side.uv, side.page)
    # Light is to be seen neither on clear glass nor in an opening.
    is_lit = np.array([c.needs_light or bool(c.emitted.any()) for c in shown.colours])[slot]
    return np.where(is_lit, texture, NOWHERE), uv, is_seen


def _write_part(buffer: Buffer, vertices, triangles, normals, uv) -> dict:
    """Write triangles that are drawn together and return their fields of a primitive."""
    part = make_part(vertices, triangles, normals, uv)
    attributes = {"POSITION": buffer.add_vertices(part.positions, with_bounds=True)}
    if part.normals is not None:
        attributes["NORMAL"] = buffer.add_vertices(part.normals)
    if part.uv is not None:
        attributes["TEXCOORD_0"] = buffer.add_vertices(part.uv)
    return {
        "attributes": attributes,
        "indices": buffer.add_indices(part.indices, len(part.positions)),
    }


def _describe_object(shown: ShownObject) -> dict:
    """What is known of an object, for viewers that show it."""
    sides = [_describe_map(made) for made in shown.maps]
    return {
        "id": shown.mesh.id,
        "is_baked": bool(sides),
        **({"sides": sides} if len(sides) > 1 else dict(*sides)),
    }


def _describe_map(made) -> dict:
    return {
        "mean_lux": known(made.mean),
        "minimum_lux": known(made.least.value),
        "minimum_lux_range": [known(made.least.low), known(made.least.high)],
        "maximum_lux": known(made.largest.value),
        "maximum_lux_range": [known(made.largest.low), known(made.largest.high)],
        "relative_standard_error": known(made.relative_standard_error),
        "mean_standard_error_lux": known(made.mean_standard_error),
        "lumels": int(made.lumels),
        "lumels_per_metre": known(made.density),
        "area_m2": known(made.area),
    }


def _describe(scene: ShownScene, white: float, plan: TexturePlan) -> dict:
    """Where the light comes from and how right it is, for the whole file."""
    result = scene.result
    extras = {
        "white_candela_per_square_metre": float(white),
        "mean_lux": known(result.mean),
        "relative_standard_error": known(result.relative_standard_error),
        "pages": len(scene.pages),
        "is_denoised": any(page.is_denoised for page in scene.pages),
        "lumels_per_texel": plan.factor,
        "not_baked": scene.left_out,
    }
    if result.maps:
        source = result.maps[0].provenance
        extras |= {
            "scene_hash": source.scene_hash,
            "seed": int(source.seed),
            "samples": int(source.samples),
            "engine_version": source.engine_version,
            "variant": source.variant,
            "simplifications_at_most": float(source.simplified),
            "decisions": list(source.decisions),
            "notes": list(source.notes),
        }
    return extras
