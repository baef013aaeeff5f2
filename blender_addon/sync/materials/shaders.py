"""Conversion of shader nodes other than the Principled BSDF."""

from dataclasses import replace

from ....engine.scene.material import (
    Black,
    Cauchy,
    Coated,
    Dielectric,
    Diffuse,
    Glossy,
    Holdout,
    Raised,
    Sheen,
    Toon,
    Transparent,
    raise_surface,
)
from ....engine.scene.spectrum import Blackbody
from ...foundation.report import Severity
from ..nodes.angles import course_of, over_angles
from ..nodes.evaluation import Inputs
from ..nodes.fields import as_colour, as_scalar, constant
from ..nodes.graph import find_socket, node_key, trace
from .closures import Closure, add, blend, diffuse, emitting, mix, reflectance_of
from .film import find_film, index_of_metal, mean_below_film, tell_film_on_glass
from .grain import find_glossy_grain, find_grain
from .principled import aslant, convert_principled, report_facets
from .relief import find_relief


def convert_shader(socket, context, groups=()) -> Closure:
    """Convert what arrives at a shader input.

    Parameters
    ----------
    socket : bpy.types.NodeSocket    An input of type SHADER.
    context : nodes.Context    The conversion that it belongs to.
    groups : tuple of bpy.types.Node    Group nodes around it, outermost first.

    Returns
    -------
    Closure    Empty, which is black, if nothing is linked; so does Blender.
    """
    origin = trace(socket, groups)
    if origin.problem:
        context.add(Severity.ERROR, socket.node.name, origin.problem, "black is used")
    if not origin.is_output:
        return Closure()
    node = origin.socket.node
    at = Inputs(node, origin.socket, context, origin.groups)
    key = (*node_key(node, origin.groups), "shader")
    if key in context.active:
        at.fail("The links run in a circle", "black is used")
        return Closure()
    context.active.add(key)
    convert = _SHADERS.get(node.bl_idname, _unsupported)
    try:
        course = None if convert is _emission else course_of(node, context, origin.groups)
        if course is not None:
            ends = (convert(Inputs(node, origin.socket, end, origin.groups)) for end in course.ends)
            return blend(at, *ends, course.share)
        return convert(at)
    finally:
        context.active.discard(key)


def _colour(at, *names):
    return reflectance_of(at, at(*(names or ("Color",))))


def _roughness(at):
    return min(max(at.plain("Roughness"), 0.0), 1.0)


def _diffuse(at):
    return _raised(at, Diffuse(as_colour(_colour(at)), None, aslant(at, "Roughness")))


def _raised(at, surface) -> Closure:
    """Return a surface with the relief that the node's normal asks for."""
    return Closure(raise_surface(surface, find_relief(at)))


def _translucent(at):
    return _raised(at, diffuse(at, constant(0.0), _colour(at)))


def _glossy(at):
    report_facets(at)
    grain = find_glossy_grain(at)
    return _raised(at, Glossy(as_colour(_colour(at)), as_scalar(at("Roughness")), None, grain))


def _metallic(at):
    film = find_film(at)
    if at.node.fresnel_type == "PHYSICAL_CONDUCTOR":
        if film is None:
            at.remark(
                "A metal by its refractive index", "its reflectance at normal incidence is used"
            )
        else:
            film = replace(film, base=index_of_metal(at))
        colour, edge = at.map(_normal_reflectance, at("IOR"), at("Extinction")), None
    else:
        colour = _colour(at, "Base Color")
        edge = as_colour(mean_below_film(at, _colour(at, "Edge Tint"), film))
    report_facets(at)
    grain = find_grain(at, "Anisotropy", "Rotation")
    colour = mean_below_film(at, colour, film)
    surface = Glossy(as_colour(colour), as_scalar(at("Roughness")), edge, grain, film)
    return _raised(at, surface)


def _normal_reflectance(n, k):
    return ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)


def _glass(at):
    colour = _colour(at)
    _report_beckmann(at)
    tint = as_colour(colour)
    # Blender tints what is reflected too.
    mirror = None if colour.is_everywhere(1) else tint
    ior = Cauchy(at.plain("IOR"), 0.0)
    film = find_film(at)
    tell_film_on_glass(at, film)
    return _raised(at, Dielectric(ior, _roughness(at), tint, mirror_tint=mirror, film=film))


def _report_beckmann(at):
    """Glass is of GGX; what light passes from facet to facet is lost, which the engine says."""
    if at.node.distribution == "BECKMANN" and not at("Roughness").is_everywhere(0):
        at.note("Facets are distributed as by Beckmann", "GGX is used")


def _refraction(at):
    _report_beckmann(at)
    ior = Cauchy(at.plain("IOR"), 0.0)
    return _raised(at, Dielectric(ior, _roughness(at), as_colour(_colour(at)), reflects=False))


def _transparent(at):
    return Closure(Transparent(as_colour(_colour(at))))


def _portal(at):
    at.note("A ray portal is not supported", "light passes straight on")
    return _transparent(at)


def _holdout(at):
    return Closure(Holdout() if at.context.is_camera else Black())


def _emission(at):
    radiance = at.map(lambda c, s: c * s, at("Color"), at("Strength"))
    return emitting(radiance, _stated_spectrum(at))


def _stated_spectrum(at):
    """Return the Planck spectrum if the colour is plainly that of a Blackbody node."""
    origin = trace(find_socket(at.node.inputs, "Color"), at.groups)
    if not origin.is_output or origin.socket.node.bl_idname != "ShaderNodeBlackbody":
        return None
    node = origin.socket.node
    temperature = Inputs(node, origin.socket, at.context, origin.groups)("Temperature")
    return Blackbody(float(temperature.values[0])) if temperature.is_constant else None


def _add(at):
    first, second = (convert_shader(s, at.context, at.groups) for s in at.node.inputs[:2])
    return add(at, first, second)


def _mix(at):
    origin = trace(at.node.inputs[0], at.groups)
    kind = origin.socket.node.bl_idname if origin.is_output else ""
    if kind == "ShaderNodeFresnel" or (
        kind == "ShaderNodeLayerWeight" and origin.socket.identifier == "Fresnel"
    ):
        closure = _by_fresnel(
            at, Inputs(origin.socket.node, origin.socket, at.context, origin.groups)
        )
        if closure is not None:
            return closure
    weights = over_angles(at.node.inputs[0], at.context, at.groups)
    if weights is not None:
        return blend(at, _branch(at, 1), _branch(at, 2), weights)
    factor = at.field(at.node.inputs[0])
    # A branch that never shows must not fill the report.
    first = Closure() if factor.is_everywhere(1) else _branch(at, 1)
    second = Closure() if factor.is_everywhere(0) else _branch(at, 2)
    return mix(at, first, second, factor)


def _branch(at, index):
    return convert_shader(at.node.inputs[index], at.context, at.groups)


def _by_fresnel(at, weight):
    """Return one surface for "gloss over a matt one by Fresnel", None if it is not that."""
    under, over = _branch(at, 1), _branch(at, 2)
    (base, relief), (gloss, upper) = map(_flat, (under.surface, over.surface))
    if not isinstance(gloss, Glossy) or over.radiance is not None:
        return None
    if not isinstance(base, Diffuse) or base.transmittance is not None:
        return None
    if gloss.film is not None:
        return None
    ior = _index_of(weight)
    roughness = gloss.roughness
    if not isinstance(roughness, float):
        roughness = float(roughness.mean().mean())
    roughness = min(max(roughness, 0.0), 1.0)
    surface = Coated(base.reflectance, ior, roughness, 1.0, base.roughness, None, gloss.grain)
    at.remark(
        "A gloss is mixed over a matt shader by Fresnel",
        "a diffuse base under a clear coat is used",
    )
    if (relief is None) != (upper is None):
        at.note("The shaders have different normals", "both have the one that is bent")
    surface = raise_surface(surface, relief or upper)
    return Closure(surface, under.radiance, under.spectrum, under.two_sided)


def _flat(surface):
    """Return a surface without its relief, and that."""
    return (surface.surface, surface.relief) if isinstance(surface, Raised) else (surface, None)


def _index_of(weight):
    if weight.node.bl_idname == "ShaderNodeFresnel":
        return max(weight.plain("IOR"), 1.0)
    return 1.0 / (1.0 - min(max(weight.plain("Blend"), 0.0), 0.99))


def _toon(at):
    size, edge = at.plain("Size"), at.plain("Smooth")
    is_glossy = at.node.component == "GLOSSY"
    return _raised(at, Toon(as_colour(_colour(at)), size, edge, is_glossy))


def _sheen(at):
    if find_relief(at) is not None:
        at.note("A sheen with a bent normal is not supported", "it has the mesh's own normal")
    is_velvet = at.node.distribution == "ASHIKHMIN"
    return Closure(Sheen(Black(), 1.0, as_colour(_colour(at)), _roughness(at), is_velvet))


def _as_diffuse(at):
    at.note(f"{at.node.bl_label} is not supported", "a diffuse surface of its colour is used")
    return _raised(at, Diffuse(as_colour(_colour(at, "Color", "Base Color"))))


def _unsupported(at):
    if find_socket(at.node.inputs, "Color", "Base Color") is not None:
        return _as_diffuse(at)
    at.fail(f"{at.node.bl_label or at.node.bl_idname} is not supported", "black is used")
    return Closure(Black())


_SHADERS = {
    "ShaderNodeBsdfPrincipled": convert_principled,
    "ShaderNodeBsdfDiffuse": _diffuse,
    "ShaderNodeBsdfTranslucent": _translucent,
    "ShaderNodeBsdfGlossy": _glossy,
    "ShaderNodeBsdfAnisotropic": _glossy,
    "ShaderNodeBsdfMetallic": _metallic,
    "ShaderNodeBsdfGlass": _glass,
    "ShaderNodeBsdfRefraction": _refraction,
    "ShaderNodeBsdfTransparent": _transparent,
    "ShaderNodeBsdfRayPortal": _portal,
    "ShaderNodeHoldout": _holdout,
    "ShaderNodeBsdfToon": _toon,
    "ShaderNodeBsdfSheen": _sheen,
    "ShaderNodeBsdfVelvet": _sheen,
    "ShaderNodeEmission": _emission,
    "ShaderNodeAddShader": _add,
    "ShaderNodeMixShader": _mix,
}
"""What each shader node becomes, by its ``bl_idname``."""
