"""What shader sockets stand for, and how two of them are mixed or added."""

from dataclasses import dataclass, replace

import numpy as np

from ....engine.materials.albedo import most_sent_out
from ....engine.scene.material import (
    BLEND_STEPS,
    Black,
    Blend,
    Diffuse,
    Mix,
    Surface,
    blend_cosines,
)
from ....engine.scene.memo import recall
from ....engine.scene.spectrum import Spectrum
from ..nodes.fields import Field, as_colour, as_scalar, constant, from_colour

MUCH = 1.001
"""Share of light that a sum sends out from which on it is worth a row that it is scaled down."""


@dataclass(frozen=True, eq=False)
class Closure:
    """Something that scatters and something that emits; either may be absent.

    Attributes
    ----------
    surface : Surface or None    None reflects nothing, and transmits nothing either.
    radiance : Field or None    Blender's radiance as a linear colour. [W/(m2 sr)]
    spectrum : Spectrum or None    Exact spectrum of the emission where the nodes state one.
    two_sided : bool    Whether both sides emit.
    """

    surface: Surface | None = None
    radiance: Field | None = None
    spectrum: Spectrum | None = None
    two_sided: bool = True


def emitting(radiance: Field, spectrum: Spectrum | None = None) -> Closure:
    """Return a closure that only emits; nothing at all if the radiance is plainly 0."""
    return Closure() if is_dark(radiance) else Closure(None, radiance, spectrum)


def is_dark(radiance: Field) -> bool:
    """Tell whether a radiance is 0 because the nodes say so, and not because one of them was replaced."""
    return radiance.is_everywhere(0) and not radiance.is_stand_in


def reflectance_of(at, field: Field) -> Field:
    """Hold a colour within 0..1, with a report if that changes it."""
    low, high = field.limits()
    if low >= 0 and high <= 1 + 1e-5:
        return field
    at.note("A colour lies outside 0..1 and would create light", "it is held within 0..1")
    return field.clipped()


def diffuse(at, reflectance: Field, transmittance: Field | None = None) -> Diffuse:
    """Return a matt surface that does not scatter more than arrives."""
    if transmittance is None or transmittance.is_everywhere(0):
        return Diffuse(as_colour(reflectance))
    total = at.map(lambda r, t: r + t, reflectance, transmittance)
    if total.limits()[1] > 1 + 1e-5:
        at.note(
            "Diffuse reflectance and transmittance add up to more than 1",
            "both are reduced in proportion",
        )
        reflectance, transmittance = (
            at.map(lambda part, whole: part / np.maximum(whole, 1), part, total)
            for part in (reflectance, transmittance)
        )
    return Diffuse(as_colour(reflectance), as_colour(transmittance))


def mix(at, first: Closure, second: Closure, factor: Field) -> Closure:
    """Return the mixture that a Mix Shader node makes; factor 0 gives `first`."""
    factor = factor.clipped()
    if factor.is_everywhere(0):
        return first
    if factor.is_everywhere(1):
        return second
    rest = replace(factor, values=recall(factor.values, "rest", lambda v: 1 - v))
    return _joined(
        at,
        Closure(None, scaled(at, first.radiance, rest), first.spectrum, first.two_sided),
        Closure(None, scaled(at, second.radiance, factor), second.spectrum, second.two_sided),
        mix_surfaces(first.surface, second.surface, factor),
    )


def blend(at, first: Closure, second: Closure, weights: np.ndarray) -> Closure:
    """Return the mixture that a Mix Shader node makes whose factor depends on the side and the angle.

    Parameters
    ----------
    first, second : Closure
    weights : (2, n) array    Of the second: from the front and from the back, by `blend_cosines`.
    """
    if not weights.any():
        return first
    if weights.min() >= 1.0:
        return second
    parts = np.stack([1.0 - weights, weights], axis=1)
    surface = first.surface
    if surface is not second.surface:
        surface = Blend(first.surface or Black(), second.surface or Black(), parts)
    if not weights[0].any() and weights[1].min() >= 1.0:
        return _two_sides(at, first, second, surface)
    lights = [replace(each, surface=None) for each in (first, second)]
    if all(each.radiance is None for each in lights):
        return Closure(surface)
    if _are_same(*(each.radiance for each in lights)):
        return replace(first, surface=surface)
    cosine = blend_cosines()
    # Cosines are even in their root, of which even light has the third power.
    mean = float(np.average(weights[0], weights=cosine**1.5))
    at.note(
        "Light that a surface gives depends on the viewing angle",
        f"the factor's mean for diffuse light, {mean:.3f}, is used for it",
    )
    light = mix(at, *lights, constant(mean))
    return replace(light, surface=surface)


def _are_same(first: Field | None, second: Field | None) -> bool:
    if first is None or second is None or first.layout is not second.layout:
        return False
    return np.array_equal(first.values, second.values)


def _two_sides(at, front: Closure, back: Closure, surface: Surface | None) -> Closure:
    """Return a front and a back, whose light is that of the front, or of none."""
    if back.radiance is None:
        return replace(front, surface=surface, two_sided=False)
    if front.radiance is None:
        at.fail("Only the back of its faces gives light", "they give none")
        return Closure(surface)
    at.note("Front and back of its faces give light", "the front's is used for both sides")
    return replace(front, surface=surface, two_sided=True)


def mix_surfaces(first, second, factor: Field):
    """Return a mixture of two surfaces, collapsed where the factor is 0 or 1."""
    if factor.is_everywhere(0) or first is second:
        return first
    if factor.is_everywhere(1):
        return second
    return Mix(first or Black(), second or Black(), as_scalar(factor))


def add(at, first: Closure, second: Closure) -> Closure:
    """Return the sum that an Add Shader node makes."""
    return _joined(at, first, second, _sum_of_surfaces(at, first.surface, second.surface))


def scaled(at, radiance: Field | None, factor: Field) -> Field | None:
    """Return a radiance times a factor."""
    return None if radiance is None else at.map(lambda r, f: r * f, radiance, factor)


def _joined(at, first, second, surface):
    """Put the emissions of two closures together over a surface."""
    emitters = [closure for closure in (first, second) if closure.radiance is not None]
    if not emitters:
        return Closure(surface)
    if len(emitters) == 1:
        only = emitters[0]
        return Closure(surface, only.radiance, only.spectrum, only.two_sided)
    if first.two_sided != second.two_sided:
        at.note("One- and two-sided emission are combined", "both sides emit")
    radiance = at.map(lambda a, b: a + b, first.radiance, second.radiance)
    return Closure(surface, radiance, None, first.two_sided or second.two_sided)


def _sum_of_surfaces(at, first, second):
    if first is None or second is None:
        return first or second
    if all(isinstance(part, Diffuse) and part.roughness == 0.0 for part in (first, second)):
        return _sum_of_diffuse(at, first, second)
    total = (most_sent_out(first) + most_sent_out(second)).max()
    if total > MUCH:
        at.note(
            f"Two shaders are added that send out up to {total:.0%} of the light that comes",
            "both are scaled down for the angles and colours where it is more than all",
        )
    return Blend(first, second, np.ones((2, 2, BLEND_STEPS)))


def _sum_of_diffuse(at, first, second):
    parts = []
    for name in ("reflectance", "transmittance"):
        colours = [getattr(surface, name) for surface in (first, second)]
        fields = [from_colour(colour) for colour in colours if colour is not None]
        total = at.map(lambda *values: sum(values), *fields) if fields else constant(0.0)
        parts.append(reflectance_of(at, total))
    return diffuse(at, *parts)
