"""Conversion of the Principled BSDF."""

import math

import numpy as np

from ....engine.scene.material import (
    Cauchy,
    Coated,
    Dielectric,
    Diffuse,
    Glossy,
    ThinGlass,
    Transparent,
    raise_surface,
)
from ....engine.scene.memo import recall
from ..nodes.fields import Field, as_colour, as_scalar
from ..nodes.graph import find_socket
from .closures import Closure, is_dark, mix_surfaces, reflectance_of, scaled
from .film import find_film, mean_below_film, tell_film_on_glass
from .grain import find_grain
from .layers import varnished, with_sheen
from .relief import find_relief

ROUGH = 0.1
"""Roughness from which on light that passes is spread too widely for a pane."""

EVEN = 1e-5
"""Diffuse roughness below which a surface is plainly matt, in Cycles too."""

_AS_DIFFUSE = {
    "Subsurface Weight": (0.0, "Subsurface scattering"),
}


def convert_principled(at) -> Closure:
    """Return what a Principled BSDF stands for.

    A coated diffuse base, a metal by ``Metallic``, a solid dielectric by ``Transmission Weight``,
    all below the ``Coat`` and that below the ``Sheen``, and seen through ``Alpha``.
    """
    _report_unsupported(at)
    base = reflectance_of(at, at("Base Color"))
    roughness = at("Roughness")
    metallic = at("Metallic").clipped()
    transmission = at("Transmission Weight").clipped()
    alpha = at("Alpha").clipped()

    if not metallic.is_everywhere(0):
        report_facets(at)
    film = find_film(at)
    surface = None
    if not metallic.is_everywhere(1) and not transmission.is_everywhere(1):
        surface = _coated(at, base, film)
    if not transmission.is_everywhere(0) and not metallic.is_everywhere(1):
        if not at("Specular Tint").is_everywhere(1):
            at.note("The tint of the highlight is not supported for glass", "it is left out")
        pane = _pane if _is_thin_wall(at) else _glass
        surface = mix_surfaces(surface, pane(at, base, film), transmission)
    if not metallic.is_everywhere(0):
        edge = as_colour(mean_below_film(at, reflectance_of(at, at("Specular Tint")), film))
        colour = as_colour(mean_below_film(at, base, film))
        metal = Glossy(colour, as_scalar(roughness), edge, _grain(at), film)
        surface = mix_surfaces(surface, metal, metallic)
    surface = raise_surface(surface, find_relief(at))
    surface, radiance = with_sheen(at, *varnished(at, surface, _radiance(at)))
    if not alpha.is_everywhere(1):
        surface = mix_surfaces(Transparent(), surface, alpha)
        radiance = scaled(at, radiance, alpha)
    return Closure(surface, radiance)


def _coated(at, base, film):
    """Return the base; Cycles reads ``Specular IOR Level`` as a factor on F0, 0.5 being 1."""
    ior = at.plain("IOR")
    normal_reflectance = ((ior - 1) / (ior + 1)) ** 2 * 2 * at.plain("Specular IOR Level")
    amplitude = math.sqrt(min(max(normal_reflectance, 0.0), 0.98))
    if film is not None:
        at.remark(
            "Blender takes more light from what lies below a thin film than the film reflects",
            "nothing is lost below it",
        )
    if amplitude < 1e-4 and film is None:
        return Diffuse(as_colour(base), None, aslant(at, "Diffuse Roughness"))
    ior = (1 + amplitude) / (1 - amplitude)
    roughness = min(max(at.plain("Roughness"), 0.0), 1.0)
    sigma = aslant(at, "Diffuse Roughness")
    return Coated(as_colour(base), ior, roughness, 1.0, sigma, _tint(at), _grain(at), film)


def _grain(at):
    return find_grain(at, "Anisotropic", "Anisotropic Rotation")


def _tint(at):
    """Return the tint of the highlight, the mean where it varies; None: it has none."""
    field = at("Specular Tint").settled()
    if field.is_everywhere(1):
        return None
    if not field.is_constant:
        at.note("The tint of the highlight varies over the surface", "its mean is used")
        field = Field(field.mean())
    return as_colour(reflectance_of(at, field))


def aslant(at, name: str) -> float:
    """Return a diffuse roughness as Cycles has it, 0 where this version of Blender lacks it."""
    if find_socket(at.node.inputs, name) is None:
        return 0.0
    roughness = min(max(at.plain(name), 0.0), 1.0)
    return roughness if roughness >= EVEN else 0.0


def _is_thin_wall(at) -> bool:
    """Whether the surface is a sheet with air on both sides, which Blender has from 5.2 on."""
    socket = find_socket(at.node.inputs, "Thin Wall")
    if socket is not None:
        return not at.field(socket).is_everywhere(0)
    return bool(getattr(at.node, "thin_wall", False))


def _pane(at, base, film):
    if film is not None:
        at.note("A thin film on a thin wall is not supported", "it is left out")
    if find_relief(at) is not None:
        at.note("A thin wall with a bent normal is not supported", "it is flat")
    if not at("Roughness").is_everywhere(0) and at.plain("Roughness") > ROUGH:
        at.fail("A thin wall that scatters is not supported", "a clear pane is used")
    return ThinGlass(max(at.plain("IOR"), 1.0), as_colour(base))


def _glass(at, base, film):
    tell_film_on_glass(at, film)
    # Cycles takes the root because light crosses the boundary twice.
    tint = Field(recall(base.values, "root", np.sqrt), base.layout)
    roughness = min(max(at.plain("Roughness"), 0.0), 1.0)
    return Dielectric(Cauchy(at.plain("IOR"), 0.0), roughness, as_colour(tint), film=film)


def _radiance(at):
    strength = at("Emission Strength")
    if is_dark(strength):
        return None
    radiance = at.map(lambda c, s: c * s, at("Emission Color"), strength)
    return None if is_dark(radiance) else radiance


def _report_unsupported(at):
    for name, (neutral, subject) in _AS_DIFFUSE.items():
        socket = find_socket(at.node.inputs, name)
        if socket is not None and not at.field(socket).is_everywhere(neutral):
            at.note(f"{subject} is not supported", "plain diffuse is used")
    if not at("Coat Weight").is_everywhere(0) and find_relief(at, "Coat Normal") is not None:
        at.note("A normal of the coat's own is not supported", "the coat is left out")


_FACETS = {"BECKMANN": "Beckmann", "ASHIKHMIN_SHIRLEY": "Ashikhmin and Shirley"}


def report_facets(at) -> None:
    """Report a distribution of a metal's facets that is not Blender's usual one."""
    chosen = getattr(at.node, "distribution", "MULTI_GGX")
    if chosen == "MULTI_GGX" or at("Roughness").is_everywhere(0):
        return
    if chosen in _FACETS:
        at.note(f"Facets are distributed as by {_FACETS[chosen]}", "GGX is used")
    else:
        at.remark(
            "Blender loses the light that passes from facet to facet by this distribution",
            "it is kept",
        )
