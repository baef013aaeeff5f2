"""Evaluation of values that depend on the side and the angle that a surface is seen from: a grid of both for a UV map."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ....engine.scene.material import BLEND_STEPS, blend_cosines
from ...foundation.report import ConversionReport
from .evaluation import Context, evaluate_field
from .fields import Field, Layout, luminance
from .graph import find_socket, node_key, trace
from .stand_ins import fresnel

LINEAR = {"Metallic", "Alpha", "Coat Weight", "Transmission Weight"}
"""Inputs of shaders with which what is reflected goes in proportion."""

COLOURS = {"Color", "Base Color"}
"""Those with which it does so where light meets one facet only."""

SMOOTH = 0.3
"""Roughness of a metal up to which next to no light passes from facet to facet."""

STRAIGHT = 2e-3
"""How far inputs may be from the line between two angles. [-]"""

LAYOUT = Layout("angles", np.eye(3), name="angles")
"""Layout of what depends on the angle; it lies on no surface."""


def over_angles(socket, context: Context, groups: tuple) -> np.ndarray | None:
    """Return a factor by side and angle, within 0 and 1, and report what it leaves out.

    Parameters
    ----------
    socket : bpy.types.NodeSocket    An input.
    context : Context    The conversion that it belongs to.
    groups : tuple of bpy.types.Node    Group nodes around it, outermost first.

    Returns
    -------
    (2, n) array or None    Of the front and the back; None: it does not depend on them, or on the place too.
    """
    if not _depends(socket, groups, set()):
        return None
    angles = _from_all_angles(context)
    field = evaluate_field(socket, angles, groups)
    if field.layout is None or field.layout.uv_map != LAYOUT.uv_map:
        return None
    context.report.include(angles.report)
    context.needs |= angles.needs
    values = np.broadcast_to(luminance(field.values), (2, BLEND_STEPS, 1))[..., 0]
    return np.clip(values, 0.0, 1.0).astype(np.float64)


@dataclass(frozen=True)
class Course:
    """How the inputs of a shader go with the angle: on a straight line from ones at one angle to ones at another.

    Parameters
    ----------
    share : (2, n) array    Of the second by side and angle, 0 to 1.
    ends : pair of Context    Conversions as seen from where the share is 0 and 1.
    """

    share: np.ndarray
    ends: tuple[Context, Context]


def course_of(node, context: Context, groups: tuple) -> Course | None:
    """Return how a shader's inputs go with the angle; None: they do not, or in a way that two surfaces cannot show."""
    sockets = [each for each in node.inputs if each.enabled and each.type != "SHADER"]
    sockets = [each for each in sockets if _depends(each, groups, set())]
    names = {each.identifier for each in sockets}
    if not names or not (names <= LINEAR or (names <= LINEAR | COLOURS and _is_linear(node))):
        return None
    fields = []
    for socket in sockets:
        field = evaluate_field(socket, _from_all_angles(context), groups)
        if field.layout is None or field.layout.uv_map != LAYOUT.uv_map:
            return None
        fields.append(field.values.reshape(2 * BLEND_STEPS, -1))
    points = np.concatenate(fields, axis=1).astype(np.float64)
    last = int(np.argmax(np.linalg.norm(points - points[0], axis=1)))
    first = int(np.argmax(np.linalg.norm(points - points[last], axis=1)))
    way = points[last] - points[first]
    length = float(way @ way)
    share = (points - points[first]) @ way / max(length, 1e-30)
    if np.abs(points - points[first] - share[:, None] * way).max() > STRAIGHT:
        return None
    ends = tuple(_from_one_angle(context, divmod(place, BLEND_STEPS)) for place in (first, last))
    return Course(np.clip(share, 0.0, 1.0).reshape(2, BLEND_STEPS), ends)


def _is_linear(node) -> bool:
    """Whether what a shader reflects goes in proportion to its colour."""
    kind = node.bl_idname
    if kind == "ShaderNodeBsdfDiffuse":
        return _is_at_most(node, "Roughness", 0.0)
    if kind in {"ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfGlossy", "ShaderNodeBsdfMetallic"}:
        return _is_at_most(node, "Roughness", SMOOTH)
    if kind == "ShaderNodeBsdfPrincipled":
        is_smooth = _is_at_most(node, "Metallic", 0.0) or _is_at_most(node, "Roughness", SMOOTH)
        names = "Transmission Weight", "Diffuse Roughness"
        return is_smooth and all(_is_at_most(node, name, 0.0) for name in names)
    return True


def _is_at_most(node, name: str, largest: float) -> bool:
    socket = find_socket(node.inputs, name)
    return socket is None or (not socket.is_linked and socket.default_value <= largest)


def _from_all_angles(context: Context) -> Context:
    """Return a conversion by the side (rows: front, back) and the angle (columns: `blend_cosines`), to be tried."""
    made = context.branch(ConversionReport())
    made.needs, made.has_angles, made.take_angle = set(), True, _by_angle
    return made


def _from_one_angle(context: Context, place: tuple[int, int]) -> Context:
    """Return a conversion as seen from one side and angle; ``place``: their numbers in the grid."""

    def take_angle(at) -> Field | None:
        field = _by_angle(at)
        return None if field is None else Field(field.values[place])

    made = context.branch()
    made.take_angle = take_angle
    return made


def _by_angle(at) -> Field | None:
    """Return what a node gives from every angle; None: it gives the same as on a surface."""
    return _SOURCES[at.node.bl_idname](at) if _is_source(at.output) else None


def _depends(socket, groups, seen: set) -> bool:
    """Whether something that depends on the angle feeds an input."""
    origin = trace(socket, groups)
    if not origin.is_output:
        return False
    if _is_source(origin.socket):
        return True
    key = node_key(origin.socket.node, origin.groups)
    if key in seen:
        return False
    seen.add(key)
    inputs = [each for each in origin.socket.node.inputs if each.type != "SHADER"]
    return any(_depends(each, origin.groups, seen) for each in inputs)


def _is_source(output) -> bool:
    kind = output.node.bl_idname
    return kind in _SOURCES and (kind != "ShaderNodeNewGeometry" or output.name == "Backfacing")


@lru_cache(maxsize=1)
def _cosines() -> np.ndarray:
    return np.maximum(blend_cosines(), 1e-6)


def _sided(front, back) -> Field:
    sides = np.broadcast_to(front, BLEND_STEPS), np.broadcast_to(back, BLEND_STEPS)
    values = np.stack(sides)[..., None].astype(np.float32)
    values.flags.writeable = False
    return Field(values, LAYOUT)


def _fresnel(at) -> Field:
    _report_normal(at)
    return _of_boundary(max(at.plain("IOR"), 1e-5))


def _of_boundary(ior: float) -> Field:
    """From the back Blender takes the inside of the body."""
    return _sided(fresnel(_cosines(), ior), fresnel(_cosines(), 1.0 / ior))


def _layer_weight(at) -> Field:
    _report_normal(at)
    blend = at.plain("Blend")
    if at.output.identifier == "Fresnel":
        return _of_boundary(1.0 / max(1.0 - blend, 1e-5))
    blend = min(max(blend, 0.0), 1.0 - 1e-5)
    exponent = 2.0 * blend if blend < 0.5 else 0.5 / (1.0 - blend)
    facing = 1.0 - _cosines() ** exponent
    return _sided(facing, facing)


def _report_normal(at) -> None:
    socket = find_socket(at.node.inputs, "Normal")
    if socket is not None and trace(socket, at.groups).is_output:
        at.remark("The angle is that to a normal of its own", "the mesh's own normal is used")


def _backfacing(_at) -> Field:
    return _sided(0.0, 1.0)


_SOURCES = {
    "ShaderNodeFresnel": _fresnel,
    "ShaderNodeLayerWeight": _layer_weight,
    "ShaderNodeNewGeometry": _backfacing,
}
"""What nodes give by the angle, by their ``bl_idname``."""
