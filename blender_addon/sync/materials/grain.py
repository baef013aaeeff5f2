"""Facets that lie along a direction: anisotropy and tangents of shader nodes."""

import math

from ....engine.scene.material import Grain
from ..nodes.evaluation import Inputs
from ..nodes.fields import as_scalar
from ..nodes.graph import find_socket, trace

_USUAL = 2
"""Axis of the object about which tangents go round where nothing is linked."""

_ASPECT = 0.9
"""Share of the anisotropy that counts for the ratio of the widths."""

_LARGEST = 0.99
"""Anisotropy of the Glossy BSDF up to which it counts, either way."""

_SLIGHT = 1e-4
"""Anisotropy that counts as none."""

_WIDE = 0.35
"""Width across facets from which on what Blender makes of light that meets several of them differs by more than 1 %."""

_AXES = {"X": 0, "Y": 1, "Z": 2}


def find_grain(at, name: str, rotation: str) -> Grain | None:
    """Return how facets lie of a shader whose ratio of widths is 1 - 0.9 times its anisotropy; None: along nothing.

    Parameters
    ----------
    at : Inputs
    name, rotation : str    Of its inputs for the anisotropy and its rotation.
    """
    if at(name).is_everywhere(0):
        return None
    amount = min(max(at.plain(name), 0.0), 1.0)
    return _along(at, (1.0 - _ASPECT * amount) ** -0.5, rotation) if amount > _SLIGHT else None


def find_glossy_grain(at) -> Grain | None:
    """Return how facets of a Glossy BSDF lie, which are narrower along the tangent the more anisotropic they are."""
    if at("Anisotropy").is_everywhere(0):
        return None
    amount = min(max(at.plain("Anisotropy"), -_LARGEST), _LARGEST)
    stretch = 1.0 - amount if amount > 0.0 else 1.0 / (1.0 + amount)
    return _along(at, stretch, "Rotation") if abs(amount) > _SLIGHT else None


def _along(at, stretch: float, rotation: str) -> Grain | None:
    widest = at("Roughness").limits()[1] ** 2 * max(stretch, 1.0 / stretch)
    if widest > _WIDE and getattr(at.node, "distribution", "MULTI_GGX") == "MULTI_GGX":
        at.remark(
            "Blender takes light that passes from facet to facet as of facets that lie along nothing, and loses some",
            "all of it is kept",
        )
    turns = at(rotation).settled()
    if turns.is_constant:
        # Whole turns change nothing, and numbers stay small.
        turns = math.fmod(float(turns.values.flat[0]), 1.0)
    else:
        turns = as_scalar(turns)
    origin = trace(find_socket(at.node.inputs, "Tangent"), at.groups)
    if not origin.is_output:
        return Grain(stretch, turns, _USUAL)
    node = origin.socket.node
    if node.bl_idname == "ShaderNodeTangent":
        if node.direction_type == "RADIAL":
            return Grain(stretch, turns, _AXES[node.axis])
        if at.context.has_texels:
            at.note(
                "A tangent along a UV map, beside textures that lie on none, is not supported",
                "anisotropy is left out",
            )
            return None
        return Grain(stretch, turns, None, node.uv_map)
    if (node.bl_idname, origin.socket.identifier) != ("ShaderNodeNewGeometry", "Tangent"):
        inner = Inputs(node, origin.socket, at.context, origin.groups)
        inner.note(
            f"A tangent that {node.bl_label or node.bl_idname} ({origin.socket.name}) gives is not supported",
            "it goes round the object's Z axis",
        )
    return Grain(stretch, turns, _USUAL)
