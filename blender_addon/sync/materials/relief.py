"""Normals that node trees bend: normal maps, bumps, and displacement that is no more than a bump."""

from dataclasses import replace

import numpy as np

from ....engine.scene.memo import recall
from ....engine.scene.mesh import CHART_MAP
from ....engine.scene.relief import Axes, Heights, Normals, Relief
from ....engine.scene.texture import ImageTexture
from ..nodes.evaluation import Inputs
from ..nodes.fields import Field, Layout, as_texture, rgb
from ..nodes.graph import find_socket, trace

_SLIGHT = 1e-7
"""Slopes, and parts of a normal along the surface, up to which there is no relief."""

_OWN = {("ShaderNodeNewGeometry", "Normal"), ("ShaderNodeTexCoord", "Normal")}
"""Outputs that are the mesh's own normal."""

_OWN_NORMAL = "the mesh's own normal is used"

_AXES = {
    "TANGENT": Axes.TANGENT,
    "OBJECT": Axes.OBJECT,
    "WORLD": Axes.WORLD,
    "BLENDER_OBJECT": Axes.OBJECT,
    "BLENDER_WORLD": Axes.WORLD,
}

_FILTER = 0.1
"""Width of Blender's filter in new files; as the normal does not depend on pixels here, narrower ones change nothing."""


def find_relief(at, *names) -> Relief | None:
    """Return the relief that a shader's ``Normal`` input, or the first of ``names``, asks for; None: there is none."""
    socket = find_socket(at.node.inputs, *(names or ("Normal",)))
    return at.context.relief if socket is None else _relief_of(socket, at)


def relief_of_displacement(output, context, displaces: bool) -> Relief | None:
    """Return the relief that stands for a material's displacement.

    Parameters
    ----------
    output : bpy.types.Node    The material's output.
    context : nodes.Context
    displaces : bool    Whether the mesh itself is displaced too.
    """
    socket = output.inputs["Displacement"]
    origin = trace(socket)
    if not origin.is_output:
        return None
    node = origin.socket.node
    at = Inputs(node, origin.socket, context, origin.groups)
    height = height_of_displacement(at)
    if height is None:
        return None
    in_object = displaces or getattr(node, "space", "OBJECT") != "WORLD"
    made = _raise(at, height, 1.0, in_object, None)
    return None if made is None else replace(made, is_shape=True)


def height_of_displacement(at) -> Field | None:
    """Return how far the node behind a material's displacement moves places along the normal; None: it is not known. [BU]"""
    kind = at.node.bl_idname
    if kind == "ShaderNodeDisplacement":
        if _relief_of(find_socket(at.node.inputs, "Normal"), at, is_bare=True) is not None:
            at.note("Displacement along another normal is not supported", _OWN_NORMAL)
        height = at("Height")
    elif kind == "ShaderNodeVectorDisplacement" and at.node.space == "TANGENT":
        height = at.map(lambda vector: rgb(vector)[..., 1:2], at("Vector"))
    else:
        at.note("Displacement by a vector is not supported as a bump", "it is left out")
        return None
    if not _is_usable(at, height):
        return None
    return at.map(lambda h, m, s: (h - m) * s, height, at("Midlevel"), at("Scale"))


def _relief_of(socket, at, is_bare: bool = False) -> Relief | None:
    """Relief behind an input for a normal; what lies below the nodes is that of the displacement unless ``is_bare``."""
    below = None if is_bare else at.context.relief
    origin = trace(socket, at.groups)
    if not origin.is_output:
        return below
    node = origin.socket.node
    if (node.bl_idname, origin.socket.identifier) in _OWN:
        return below
    inner = Inputs(node, origin.socket, at.context, origin.groups)
    if node.bl_idname == "ShaderNodeNormalMap":
        return _mapped(inner, below)
    if node.bl_idname == "ShaderNodeBump":
        return _bumped(inner, _relief_of(find_socket(node.inputs, "Normal"), inner, is_bare))
    label = node.bl_label or node.bl_idname
    at.note(f"A normal that {label} ({origin.socket.name}) gives is not supported", _OWN_NORMAL)
    return below


def _mapped(at, below) -> Relief | None:
    colour, strength = at("Color"), max(at.plain("Strength"), 0.0)
    if not _is_usable(at, colour) or strength == 0.0:
        return None if strength == 0.0 else below
    space = at.node.space
    if space == "TANGENT" and at.context.has_texels:
        return _on_object(at, colour, strength, below)
    if space == "TANGENT" and not colour.is_constant and colour.layout.uv_map != at.node.uv_map:
        at.remark(
            f"The tangents of a normal map follow UV map {at.node.uv_map!r}",
            f"they follow that of its picture, {colour.layout.uv_map or 'the default one'!r}",
        )
    vectors = at.map(lambda colour: _vectors_of(colour, space, strength), colour)
    if space == "TANGENT" and not _is_bent(vectors):
        return None
    texture = _texture_of(vectors, at.node.uv_map)
    return Normals(texture, _AXES[space], 1.0 if space == "TANGENT" else strength)


def _on_object(at, colour, strength: float, below) -> Relief | None:
    """Relief of a tangent-space normal map whose material lies on the object's own charts: normals by the object's axes."""
    tangents = at.context.tangents(at.node.uv_map)
    if tangents is None:
        at.note(f"A normal map follows UV map {at.node.uv_map!r}, which is not there", _OWN_NORMAL)
        return below
    vectors = at.map(lambda colour: _vectors_of(colour, "TANGENT", strength), colour)
    if not _is_bent(vectors):
        return None

    def turn(vectors, tangents, normals):
        # The second axis lies across the first one, on the side to which V grows.
        along = tangents[..., :3] - normals * (tangents[..., :3] * normals).sum(-1, keepdims=True)
        length = np.linalg.norm(along, axis=-1, keepdims=True)
        along = along / np.maximum(length, 1e-30)
        across = np.cross(normals, along) * tangents[..., 3:]
        made = vectors[..., :1] * along + vectors[..., 1:2] * across + vectors[..., 2:] * normals
        return np.where(length > 0.0, made, normals)

    turned = at.map(turn, vectors, tangents, at.context.normals())
    return Normals(_texture_of(turned, CHART_MAP), Axes.OBJECT)


def _vectors_of(colour, space: str, strength: float) -> np.ndarray:
    """Vectors that colours of a normal map stand for, as Blender reads them."""
    vectors = 2.0 * rgb(colour) - 1.0
    if space == "TANGENT":
        upright = 1.0 + (vectors[..., 2:] - 1.0) * min(strength, 1.0)
        return np.concatenate([vectors[..., :2] * np.float32(strength), upright], axis=-1)
    return vectors * np.array([1, -1, -1] if space.startswith("BLENDER") else [1, 1, 1], np.float32)


def _is_bent(vectors: Field) -> bool:
    return bool((np.abs(vectors.values[..., :2]) > _SLIGHT).any())


def _bumped(at, below) -> Relief | None:
    strength = max(at.plain("Strength"), 0.0)
    distance = at.plain("Distance") * (-1.0 if at.node.invert else 1.0)
    height = at("Height")
    width = find_socket(at.node.inputs, "Filter Width")
    if width is not None and abs(at.plain("Filter Width") - _FILTER) > 1e-6:
        at.remark("Blender takes slopes over a part of a pixel", "they are those at every place")
    if strength == 0.0 or distance == 0.0 or not _is_usable(at, height):
        return below
    height = at.map(lambda h, d: h * d, height, Field(np.array([distance], np.float32)))
    return _raise(at, height, strength, False, below)


def _raise(at, height: Field, strength: float, in_object: bool, below) -> Relief | None:
    """Heights over what lies below; the same alone where they are even. ``height``: [BU]"""
    if height.is_constant:
        return below
    if height.layout.interpolation == "closest":
        at.note("Heights in steps have no slope", "they are left out")
        return below
    low, high = height.limits()
    if high - low <= _SLIGHT:
        return below
    texture = as_texture(height)
    if not in_object:
        metres = at.context.metres
        pixels = recall(texture.pixels, ("metres", metres), lambda v: v * np.float32(metres))
        texture = replace(texture, pixels=pixels)
    return Heights(texture, strength, in_object, below=below)


def _is_usable(at, field: Field) -> bool:
    """Tell whether a field lies on a UV map, and note where it does not."""
    if field.is_spread or field.is_stand_in:
        at.note("A bump or normal that does not lie on a UV map is not supported", _OWN_NORMAL)
        return False
    return True


def _texture_of(vectors: Field, uv_map: str) -> ImageTexture:
    if vectors.is_constant:
        vectors = Field(vectors.values[None, None], Layout(uv_map, np.eye(3), name="normal"))
    return as_texture(vectors)
