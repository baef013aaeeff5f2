"""Layers of a Principled BSDF over what lies below them."""

from dataclasses import replace

import numpy as np

from ....engine.materials.facets import directional_reflectance, mean_reflectance
from ....engine.materials.fibres import sent_on
from ....engine.materials.layering import even_shares, slant
from ....engine.scene.material import Black, Mix, Sheen, Surface, Varnish
from ..nodes.fields import Field, as_colour, as_scalar
from ..nodes.graph import find_socket
from .closures import reflectance_of
from .relief import find_relief


def varnished(at, surface: Surface | None, radiance: Field | None):
    """Put the coat of a Principled BSDF over its other parts and its light.

    Returns
    -------
    (Surface or None, Field or None)    As they came where there is no coat.
    """
    if find_socket(at.node.inputs, "Coat Weight") is None:
        return surface, radiance
    weight = at("Coat Weight").clipped()
    if weight.is_everywhere(0):
        return surface, radiance
    tint = reflectance_of(at, at("Coat Tint"))
    ior = max(at.plain("Coat IOR"), 1.0)
    roughness = min(max(at.plain("Coat Roughness"), 0.0), 1.0)
    coat = Varnish(Black(), as_scalar(weight), ior, roughness, as_colour(tint))
    if radiance is not None:
        at.remark(
            "Blender's coat dims the light of a surface by the viewing angle",
            "it is dimmed by the mean over all angles",
        )
        radiance = _dimmed(at, radiance, weight, tint, ior, roughness)
    return _over(coat, surface), radiance


def with_sheen(at, surface: Surface | None, radiance: Field | None):
    """Put the sheen of a Principled BSDF over its other parts, coat included, and its light.

    Returns
    -------
    (Surface or None, Field or None)    As they came where there is no sheen.
    """
    weight = at("Sheen Weight").clipped()
    if weight.is_everywhere(0):
        return surface, radiance
    tint = at("Sheen Tint").settled()
    if not tint.is_constant:
        at.note("The tint of the sheen varies over the surface", "its mean is used")
        tint = Field(tint.mean())
    tint = reflectance_of(at, tint)
    if find_relief(at) is not None:
        at.note("A sheen with a bent normal is not supported", "it has the mesh's own normal")
    roughness = min(max(at.plain("Sheen Roughness"), 0.0), 1.0)
    sheen = Sheen(Black(), as_scalar(weight), as_colour(tint), roughness)
    if radiance is not None:
        at.remark(
            "Blender's sheen dims the light of a surface by the viewing angle",
            "it is dimmed by the mean over all angles",
        )
        most = mean_reflectance(sent_on(round(roughness, 4), False)) * tint.limits()[1]
        radiance = at.map(lambda light, w: light * (1.0 - w * most), radiance, weight)
    return _over(sheen, surface), radiance


def _over(layer: Varnish | Sheen, surface: Surface | None) -> Surface:
    """Put a layer over each part of a mixture, which is the same as over the whole."""
    if isinstance(surface, Mix):
        first, second = _over(layer, surface.first), _over(layer, surface.second)
        return replace(surface, first=first, second=second)
    return replace(layer, base=surface or Black())


def _dimmed(at, radiance, weight, tint, ior, roughness):
    reflected = mean_reflectance(directional_reflectance(max(roughness**2, 1e-3), max(ior, 1.0001)))
    length = float(even_shares() @ slant(max(ior, 1.0001)))
    passed = at.map(
        lambda w, t: (1.0 - w * reflected) * (1.0 - w + w * np.maximum(t, 0.0) ** length),
        weight,
        tint,
    )
    return at.map(lambda light, share: light * share, radiance, passed)
