"""Constants in place of nodes whose value depends on more than the place on a UV map."""

import numpy as np

from .fields import constant

_HALF = "the middle of its range, 0.5, is used"

_PROCEDURAL = (
    *("Noise", "Voronoi", "Wave", "Musgrave", "Magic", "Gradient", "WhiteNoise", "Gabor"),
    *("Environment", "Sky", "PointDensity"),
)

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
        return _mean_fresnel(at, at.plain("IOR"))
    if kind == "ShaderNodeLayerWeight":
        return _layer_weight(at, output)
    if kind == "ShaderNodeNewGeometry" and output == "Backfacing":
        at.note("The two sides of a face differ", "the front is used for both")
        return constant(0.0)
    if kind in _ZERO:
        at.note(f"{at.output.name}: {_ZERO[kind]}", "0 is used")
        return constant(0.0)
    if kind == "ShaderNodeObjectInfo" and output in {"Color", "Alpha"}:
        at.note("The object's colour is not available to materials", "white is used")
        return constant(1.0)
    at.note(_reason(at), _HALF)
    return constant(0.5)


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
        return _mean_fresnel(at, 1.0 / (1.0 - blend))
    exponent = 2 * blend if blend < 0.5 else 0.5 / (1.0 - blend)
    return _mean_over_angles(at, 1.0 - 2.0 / (exponent + 2.0))


def _mean_fresnel(at, ior):
    return _mean_over_angles(at, hemispherical_fresnel(ior))


def _mean_over_angles(at, value):
    at.note("The value depends on the viewing angle", f"its mean for diffuse light, {value:.3f}")
    return constant(value)


def hemispherical_fresnel(ior: float) -> float:
    """Return the reflectance of a smooth dielectric for diffuse light from outside."""
    cosine = (np.arange(1000) + 0.5) / 1000
    ior = max(ior, 1e-3)
    squared = 1.0 - (1.0 - cosine**2) / ior**2
    inner = np.sqrt(np.maximum(squared, 0.0))
    parallel = (ior * cosine - inner) / (ior * cosine + inner)
    crossed = (cosine - ior * inner) / (cosine + ior * inner)
    reflectance = np.where(squared > 0, (parallel**2 + crossed**2) / 2, 1.0)
    return float(np.mean(2 * cosine * reflectance))
