"""Layers of a Principled BSDF over what lies below them."""

from dataclasses import replace

import numpy as np

from ....engine.materials.facets import directional_reflectance, mean_reflectance
from ....engine.materials.layering import even_shares, slant
from ....engine.scene.material import Black, Mix, Surface, Varnish
from ..nodes.fields import Field, as_colour, as_scalar
from ..nodes.graph import find_socket
from .closures import reflectance_of


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


def _over(coat: Varnish, surface: Surface | None) -> Surface:
    """Put a coat over each part of a mixture, which is the same as over the whole."""
    if isinstance(surface, Mix):
        first, second = _over(coat, surface.first), _over(coat, surface.second)
        return replace(surface, first=first, second=second)
    return replace(coat, base=surface or Black())


def _dimmed(at, radiance, weight, tint, ior, roughness):
    reflected = mean_reflectance(directional_reflectance(max(roughness**2, 1e-3), max(ior, 1.0001)))
    length = float(even_shares() @ slant(max(ior, 1.0001)))
    passed = at.map(
        lambda w, t: (1.0 - w * reflected) * (1.0 - w + w * np.maximum(t, 0.0) ** length),
        weight,
        tint,
    )
    return at.map(lambda light, share: light * share, radiance, passed)
