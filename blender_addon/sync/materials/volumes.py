"""Volumes of materials: what a solid body absorbs is taken over, all else is told."""

from dataclasses import dataclass, replace

import numpy as np

from ....engine.scene.material import Dielectric, Mix, Raised, Surface
from ....engine.scene.spectrum import Spectrum
from ...foundation.report import Severity
from ..nodes.evaluation import Inputs
from ..nodes.fields import as_colour, constant, luminance
from ..nodes.graph import trace

LEFT_OUT = "it is left out"


@dataclass(frozen=True)
class Body:
    """What a solid lets through: ``internal`` [-] of ``thickness`` [m]."""

    internal: Spectrum
    thickness: float


def with_volume(surface: Surface | None, output, context) -> Surface | None:
    """Return the surface of a body with what is inside.

    Parameters
    ----------
    surface : Surface or None    Of the body.
    output : bpy.types.Node    Material output, whose volume is linked.
    context : nodes.Context    The conversion that it belongs to.
    """
    if surface is None or surface.is_opaque:
        # No light gets in.
        return surface
    body = _convert(output, context)
    if body is not None and not _is_solid(surface):
        message = "Absorption is computed within solids of glass alone"
        context.add(Severity.ERROR, output.name, message, LEFT_OUT)
        return surface
    return surface if body is None else _filled(surface, body)


def _is_solid(surface) -> bool:
    """Whether all of a surface is the boundary of a solid."""
    if isinstance(surface, Mix):
        return _is_solid(surface.first) and _is_solid(surface.second)
    if isinstance(surface, Raised):
        return _is_solid(surface.surface)
    return isinstance(surface, Dielectric)


def _filled(surface, body: Body):
    if isinstance(surface, Mix):
        return replace(
            surface, first=_filled(surface.first, body), second=_filled(surface.second, body)
        )
    if isinstance(surface, Raised):
        return replace(surface, surface=_filled(surface.surface, body))
    return replace(surface, internal=body.internal, thickness=body.thickness)


def _convert(output, context) -> Body | None:
    """Convert what arrives at the volume of an output, None if that is nothing, or nothing that can be taken over."""
    origin = trace(output.inputs["Volume"], ())
    if not origin.is_output:
        return None
    node = origin.socket.node
    at = Inputs(node, origin.socket, context, origin.groups)
    if node.bl_idname not in _ABSORPTIONS:
        _tell_medium(at)
        return None
    absorption = _ABSORPTIONS[node.bl_idname](at)
    if absorption is None:
        return None
    # Of a depth at which much of the light is absorbed the colour is exact.
    absorption = np.maximum(np.broadcast_to(absorption, 3), 0.0) / context.metres
    largest = float(absorption.max())
    if not largest > 0.0:
        return None
    return Body(as_colour(constant(*np.exp(-absorption / largest))), 1.0 / largest)


def _tell_medium(at) -> None:
    message = "A volume that scatters or emits light is not supported"
    at.context.report.medium(at.context.datablock, message, LEFT_OUT, at.node.name)


def _colour_of(at, name: str) -> np.ndarray:
    """A colour, the mean where it varies. (3,)"""
    field = at(name).settled()
    if not field.is_constant:
        at.note(f"{name} varies within the body", "its mean is used")
    return np.broadcast_to(field.mean(), 3)


def _absorption(at) -> np.ndarray:
    return (1.0 - _colour_of(at, "Color")) * max(at.plain("Density"), 0.0)


def _coefficients(at) -> np.ndarray | None:
    if _scatters(at, "Scatter Coefficients") or _scatters(at, "Emission Coefficients"):
        _tell_medium(at)
        return None
    return _colour_of(at, "Absorption Coefficients")


def _scatters(at, name: str) -> bool:
    return float(luminance(_colour_of(at, name))[0]) > 0.0


_ABSORPTIONS = {
    "ShaderNodeVolumeAbsorption": _absorption,
    "ShaderNodeVolumeCoefficients": _coefficients,
}
"""Absorption coefficients by node: linear Rec. 709. (3,) [1 / Blender unit]"""
