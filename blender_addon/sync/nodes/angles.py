"""Evaluation of values that depend on the side and the angle that a surface is seen from: a grid of both for a UV map."""

from functools import lru_cache

import numpy as np

from ....engine.scene.material import BLEND_STEPS, blend_cosines
from ...foundation.report import ConversionReport
from .evaluation import Context, evaluate_field
from .fields import Field, Layout, luminance
from .graph import find_socket, node_key, trace
from .stand_ins import fresnel

LAYOUT = Layout("angles", np.eye(3), name="angles")
"""Layout of what depends on the angle; it lies on no surface."""


class AngleContext(Context):
    """The conversion of a value by the side (rows: front, back) and the angle (columns: `blend_cosines`)."""

    def take_output(self, at) -> Field | None:
        """Return what a node gives from every angle; None: it gives the same as on a surface."""
        if not _is_source(at.output):
            return None
        return _SOURCES[at.node.bl_idname](at)


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
    report = ConversionReport()
    angles = AngleContext(context.datablock, report, context.images)
    field = evaluate_field(socket, angles, groups)
    if field.layout is None or field.layout.uv_map != LAYOUT.uv_map:
        return None
    context.report.include(report)
    values = np.broadcast_to(luminance(field.values), (2, BLEND_STEPS, 1))[..., 0]
    return np.clip(values, 0.0, 1.0).astype(np.float64)


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
