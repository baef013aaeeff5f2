"""Surfaces that are simpler ones by what they say.

A mixture of two diffuse paints is a diffuse paint, a varnish that covers nothing is not there, and a picture of one value
is a colour: that is exact (theory 15.3).
A coat is never left out for being faint: at grazing angles it outshines its base whatever its scale, so that nothing bounds
what a sensor there would lack.
"""

from dataclasses import replace

import numpy as np

from ..photometry.spectra import GRID, evaluate_reflectance
from ..scene.colour import Colour
from ..scene.material import (
    Black,
    Blend,
    Coated,
    Diffuse,
    Glossy,
    Material,
    Mix,
    Raised,
    Sheen,
    Surface,
    Varnish,
)
from ..scene.memo import recall
from ..scene.modelling import Switch
from ..scene.spectrum import Constant, Rgb, Tabulated
from ..scene.texture import ImageTexture
from .decision import Asked, Decision, Outcome
from .facts import Facts, used_materials

NAME = "surfaces"

SAVING = 0.13
"""Share of the time that is saved where a fifth of the surfaces become simpler, and a second and more for their kernel."""

FULL = "as they are stated"


def decide(facts: Facts, _asked: Asked, _allowance: float, switch: Switch) -> Outcome:
    """Put simpler surfaces in place of those that are the same; exact."""
    if switch is Switch.OFF:
        return Outcome(Decision(NAME, FULL, "as the user wants it", switch=switch))
    changes, names = {}, []
    for material in used_materials(facts.scene):
        simple = _simplify_material(material)
        if simple is not material:
            changes[material.id] = simple
            names.append(f"'{material.name}'")
    if not changes:
        return Outcome(Decision(NAME, FULL, "none is a simpler one", switch=switch))
    shown = ", ".join(names[:3]) + (f" and {len(names) - 3} others" if len(names) > 3 else "")
    reason = f"by what they say, materials are simpler ones: {shown}"
    made = Decision(NAME, "simpler ones that are the same", reason, saving=SAVING, switch=switch)
    return Outcome(made, changes)


def _simplify_material(material: Material) -> Material:
    surface = simplify(material.surface)
    seen = material.seen and _simplify_material(material.seen)
    if surface is material.surface and seen is material.seen:
        return material
    return replace(material, surface=surface, seen=seen)


def simplify(surface: Surface) -> Surface:
    """Return the simplest surface that answers light in the very same way; itself if there is none."""
    match surface:
        case Raised():
            inner = simplify(surface.surface)
            return surface if inner is surface.surface else replace(surface, surface=inner)
        case Varnish() | Sheen():
            base = simplify(surface.base)
            if _is_number(surface.weight) and surface.weight <= 0.0:
                return base
            return surface if base is surface.base else replace(surface, base=base)
        case Blend() if _is_even(surface):
            return simplify(Mix(surface.first, surface.second, float(surface.weights[0, 1, 0])))
        case Mix():
            return _simplify_mix(surface)
        case Diffuse() | Coated():
            return _even_out(surface)
        case Glossy() if surface.film is None:
            return _even_out(surface)
    return surface


def _even_out(surface: Surface) -> Surface:
    """A surface with one colour in place of pictures that are the same all over."""
    held = {name: getattr(surface, name) for name in surface.spectra}
    made = {name: _even_colour(value) for name, value in held.items()}
    changed = {name: value for name, value in made.items() if value is not held[name]}
    return replace(surface, **changed) if changed else surface


def _even_colour(colour: Colour | None) -> Colour | None:
    even = _even_pixel(colour)
    if even is None:
        return colour
    return Constant(even[0]) if min(even) == max(even) else Rgb(*even)


def _even_pixel(value) -> tuple[float, ...] | None:
    """The channels of a picture that is the same all over, within 0 and 1 as it counts; None: it is none.

    So it is beyond its edges, which repeat, go on or mirror, and where no tile is, which is one of its pixels.
    """
    if not isinstance(value, ImageTexture):
        return None
    return recall(value.pixels, "even pixel", _find_even)


def _find_even(pixels: np.ndarray) -> tuple[float, ...] | None:
    first = pixels[0, 0]
    if not np.isfinite(first).all() or (pixels[-1, -1] != first).any() or (pixels != first).any():
        return None
    return tuple(float(channel) for channel in np.clip(first, 0.0, 1.0))


def _is_even(blend: Blend) -> bool:
    """Whether the weights of a blend are the same from everywhere, and those of a mixture."""
    weights = np.asarray(blend.weights)
    return bool((weights == weights[:1, :, :1]).all() and weights[0, :, 0].sum() == 1.0)


def _simplify_mix(mix: Mix) -> Surface:
    first, second = simplify(mix.first), simplify(mix.second)
    even = _even_pixel(mix.factor)
    factor = mix.factor if even is None else sum(even) / len(even)
    if _is_number(factor):
        if factor <= 0.0:
            return first
        if factor >= 1.0:
            return second
        together = _put_together(first, second, float(factor))
        if together is not None:
            return together
    if first is mix.first and second is mix.second and factor is mix.factor:
        return mix
    return replace(mix, first=first, second=second, factor=factor)


def _put_together(first: Surface, second: Surface, factor: float) -> Surface | None:
    """One surface in place of two whose light is in proportion to their reflectances; None: there is none."""
    first, second = (
        Diffuse(Constant(0.0)) if type(each) is Black else each for each in (first, second)
    )
    if type(first) is not type(second):
        return None
    if isinstance(first, Diffuse) and max(first.roughness, second.roughness) <= 0.0:
        reflectance = _average(first.reflectance, second.reflectance, factor)
        if first.is_opaque and second.is_opaque:
            return reflectance and Diffuse(reflectance)
        passed = (each.transmittance or Constant(0.0) for each in (first, second))
        transmittance = _average(*passed, factor)
        return reflectance and transmittance and Diffuse(reflectance, transmittance)
    if isinstance(first, Coated) and _are_coated_alike(first, second):
        reflectance = _average(first.reflectance, second.reflectance, factor)
        return reflectance and replace(first, reflectance=reflectance)
    return None


def _are_coated_alike(first: Coated, second: Coated) -> bool:
    # The facets of a base that lie aslant light each other, which is in no proportion to its reflectance.
    return first.base_roughness <= 0.0 and replace(first, reflectance=second.reflectance) == second


def _average(first: Colour, second: Colour, factor: float) -> Colour | None:
    """A colour between two, None where one of them is a picture. Both are held within what a surface may reflect."""
    if isinstance(first, ImageTexture) or isinstance(second, ImageTexture):
        return None
    if isinstance(first, Constant) and isinstance(second, Constant):
        low, high = (min(max(each.value, 0.0), 1.0) for each in (first, second))
        return Constant(low + factor * (high - low))
    low, high = (np.clip(evaluate_reflectance(each, GRID), 0.0, 1.0) for each in (first, second))
    return Tabulated(GRID, low + factor * (high - low))


def _is_number(value) -> bool:
    return not isinstance(value, ImageTexture)
