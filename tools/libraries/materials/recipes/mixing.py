"""Matter of a stated luminous reflectance or transmittance: the amount of some pigments is chosen for it."""

import numpy as np

from ..coats import Coat, Paint, Slab
from ..colour import WAVELENGTHS, luminous, solve
from ..grains import Grains
from ..pigments import layer, mixture, thick_reflectance

SMOOTH, SILK, MATT, POWDER = Coat(1.5), Coat(1.5, 0.28), Coat(1.5, 0.6), Coat(1.5, 0.42)
"""Boundaries of paints by their gloss."""

WHITE = {"titanium white": 1.0}

CHALK = {"chalk": 1.0}


def paint(target: float, fixed: dict, varied: dict, coat: Coat) -> Paint:
    """Paint of a luminous reflectance, which the amount of some pigments is chosen for."""

    def body(amount):
        parts = fixed | {name: part * 10.0**amount for name, part in varied.items()}
        return thick_reflectance(*mixture(parts))

    amount = solve(lambda x: luminous(coat.reflectance_over(body(x))), target, -6.0, 2.0)
    return Paint(coat, body(amount))


def grains(target: float, fixed: dict, varied: dict, roughness: float) -> Grains:
    """Rough matt matter of a luminous reflectance, which the amount of some pigments is chosen for."""

    def made(amount):
        parts = fixed | {name: part * 10.0**amount for name, part in varied.items()}
        return Grains(thick_reflectance(*mixture(parts)), roughness)

    return made(solve(lambda x: luminous(made(x).total()), target, -6.0, 2.0))


def slab(transmittance: float, absorption: dict, coat: Coat) -> Slab:
    """A sheet that scatters, of a luminous transmittance, which the amount of white is chosen for."""
    k, s = mixture({**absorption, "titanium white": 1.0})[0], np.ones(len(WAVELENGTHS))

    def made(amount):
        return Slab(coat, *layer(0.004 + 0.004 * amount * k, amount * s))

    return made(solve(lambda x: luminous(made(x).totals()[1]), transmittance, 0.01, 30.0))
