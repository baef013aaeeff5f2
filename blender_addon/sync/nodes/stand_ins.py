"""What stands for nodes whose value depends on more than the place on a UV map: samples or a constant.

What other nodes make of samples is calculated for each of them, and the mean counts where they end, in a surface or in
its light; so a ramp behind a texture shows as much of each of its colours as the texture has of its greys.
"""

import zlib
from dataclasses import replace as changed

import numpy as np

from .fields import SAMPLES, constant, spread
from .graph import node_key

_EVEN = "values spread evenly over 0..1 are taken, and the mean of what comes of them is used"

_COSINES = np.sqrt((np.arange(SAMPLES) + 0.5) / SAMPLES)
"""Equally likely cosines of diffuse light."""

_PROCEDURAL = ("Environment", "Sky", "PointDensity")

_ZERO = {
    "ShaderNodeLightPath": "Rays are not told apart in a light calculation",
    "ShaderNodeCameraData": "A reflectance cannot depend on the camera",
    "ShaderNodeParticleInfo": "Particle data are not available to materials",
    "ShaderNodeHairInfo": "Hair data are not available to materials",
    "ShaderNodeVolumeInfo": "Volume data are not available to materials",
    "ShaderNodeWireframe": "The wireframe of the mesh is not drawn",
}


def replace(at):
    """Return the stand-in of a node that cannot be evaluated, and report it."""
    kind, output = at.node.bl_idname, at.output.identifier
    if kind == "ShaderNodeFresnel":
        return _fresnel(at, at.plain("IOR"))
    if kind == "ShaderNodeLayerWeight":
        return _layer_weight(at, output)
    if kind == "ShaderNodeNewGeometry" and output == "Backfacing":
        at.note("The two sides of a face differ", "the front is used for both")
        return _given(0.0)
    if kind in _ZERO:
        at.note(f"{at.output.name}: {_ZERO[kind]}", "0 is used")
        return _given(0.0)
    if (
        kind == "ShaderNodeObjectInfo"
        and output in {"Color", "Alpha"}
        and not at.context.is_material
    ):
        at.note("The object's colour is not available to materials", "white is used")
        return _given(1.0)
    at.note(_reason(at), _EVEN)
    return _spread_evenly(at)


def _given(value: float):
    return changed(constant(value), is_stand_in=True)


def _spread_evenly(at):
    """Return samples of each channel; those of other channels and nodes have nothing to do with them."""
    place = repr((*node_key(at.node, at.groups), at.output.identifier))
    random = np.random.default_rng(zlib.crc32(place.encode()))
    channels = 1 if at.output.type in {"VALUE", "INT", "BOOLEAN"} else 3
    return spread(
        np.stack([(random.permutation(SAMPLES) + 0.5) / SAMPLES for _ in range(channels)], -1)
    )


def _reason(at):
    kind = at.node.bl_idname
    if kind in {"ShaderNodeVertexColor", "ShaderNodeAttribute"}:
        name = getattr(at.node, "layer_name", "") or getattr(at.node, "attribute_name", "")
        return f"Attribute {name!r} of the mesh is not available to materials"
    if kind in {f"ShaderNodeTex{name}" for name in _PROCEDURAL}:
        return "A procedural texture cannot be taken over"
    if kind == "NodeUndefined":
        return "A node of an unknown type"
    return (
        f"{at.node.bl_label or kind} ({at.output.name}) varies in a way that cannot be taken over"
    )


def _layer_weight(at, output):
    blend = min(max(at.plain("Blend"), 0.0), 1.0 - 1e-5)
    if output == "Fresnel":
        return _fresnel(at, 1.0 / (1.0 - blend))
    exponent = 2 * blend if blend < 0.5 else 0.5 / (1.0 - blend)
    return _over_angles(at, 1.0 - _COSINES**exponent)


def _fresnel(at, ior):
    return _over_angles(at, fresnel(_COSINES, ior))


def _over_angles(at, values):
    mean = values.mean()
    at.note("The value depends on the viewing angle", f"its mean for diffuse light, {mean:.3f}")
    return spread(values[:, None])


def fresnel(cosine: np.ndarray, ior: float) -> np.ndarray:
    """Return the reflectance of a smooth dielectric from outside by the cosine to its normal."""
    ior = max(ior, 1e-3)
    squared = 1.0 - (1.0 - cosine**2) / ior**2
    inner = np.sqrt(np.maximum(squared, 0.0))
    parallel = (ior * cosine - inner) / (ior * cosine + inner)
    crossed = (cosine - ior * inner) / (cosine + ior * inner)
    return np.where(squared > 0, (parallel**2 + crossed**2) / 2, 1.0)
