"""Whether light needs wavelengths.

Photometric transport has one reflectance for each surface, weighed by the lights and the eye. That is exact of one
reflection; of several it is wrong by what the spectra of the surfaces have in common (theory 14.1).
"""

import numpy as np

from ..photometry.spectra import GRID, evaluate_emission, evaluate_reflectance, luminous_efficiency
from ..scene.material import Blend, Coated, Diffuse, Mix, Raised, Surface, Toon, Transparent
from ..scene.modelling import Switch
from ..scene.spectrum import Constant
from ..scene.texture import ImageTexture
from .decision import Asked, Decision, Outcome, accepts
from .facts import Facts

NAME = "colours"

SAVING = 0.4
"""Share of the time of a spectral sample that a photometric one saves. [-]"""

LINEAR = (Diffuse, Toon, Transparent)
"""Surfaces whose reflectance is in proportion to their spectra."""

MIXED = (Mix, Blend, Raised)
"""Surfaces that are made of others by weights which do not depend on the wavelength."""

INSIDE = 0.65
"""Share of diffuse light that a clear coat sends back to its base from inside, at most: of a refractive index of 1.6. [-]"""

ALREADY = 2
"""Coloured surfaces that light has met before it reaches those who are worst off. Of fewer the bound is smaller."""

MOST_MET = 400
"""Coloured surfaces of one path up to which the series is added up."""


def decide(facts: Facts, asked: Asked, allowance: float, switch: Switch) -> Outcome:
    """Choose photometric or spectral transport."""
    reasons = facts.spectral_reasons
    dispersive = facts.is_dispersive
    if not reasons:
        chosen = Decision(
            NAME,
            "photometric",
            "all surfaces are neutral and all lights share one spectrum: photometric transport is exact",
            switch=switch,
            saving=SAVING,
        )
        return Outcome(chosen, is_spectral=switch is Switch.OFF)
    told = "; ".join(reasons)
    bound = np.inf if asked.has_colour else find_bound(facts)
    if accepts(bound, allowance, switch):
        told = (
            f"the spectra are so alike that light is right within {100.0 * bound:.2g} %"
            if bound > 0.0
            else "all surfaces are neutral: photometric transport is exact where no colours are wanted"
        )
        made = Decision(NAME, "photometric", told, bound, SAVING, switch)
        return Outcome(made, is_spectral=False)
    if np.isfinite(bound) and switch is not Switch.OFF:
        told += f"; without wavelengths light could be wrong by {100.0 * bound:.2g} %"
    elif switch is Switch.FORCE:
        told += "; what light without wavelengths would be wrong by is not known"
    return Outcome(Decision(NAME, "spectral", told, switch=switch), {}, True, dispersive)


def find_bound(facts: Facts) -> float:
    """Largest relative error of photometric transport, infinite where it is not known. [-]

    Light of a lamp that has met k coloured surfaces, whose reflectances differ from their photometric ones by the factors
    1 + d_i, is right but for ``E[(1 + d_1) ... (1 + d_k)] - 1``, E being the mean over the wavelengths by the lamp and the
    eye. With the largest d of all surfaces at each wavelength and m the largest mean of one, that is at most
    ``k m + E[(1 + d)^k] - 1 - k E[d]``. Of light that has met k of them no more than the largest reflectance is left to meet
    another, so that the mean over all light is at most that of a geometric series.
    """
    if facts.is_dispersive:
        return np.inf
    lamps = _weights(facts.lamps)
    found = [each for surface in facts.surfaces for each in _deviations(surface, lamps)]
    if not found:
        # The amount of light of every lamp is right whatever its spectrum.
        return 0.0
    if facts.has_coloured_lights or not len(lamps):
        return np.inf
    apart, means, shares = map(np.array, zip(*found, strict=True))
    return _sum_up(lamps, apart.max(axis=0), float(means.max()), float(shares.max()))


def _sum_up(lamps: np.ndarray, largest: np.ndarray, offset: float, reflectance: float) -> float:
    """Mean of the errors of light by how many coloured surfaces it has met. [-]"""
    if not np.isfinite(offset):
        return np.inf
    if reflectance * (1.0 + largest.max()) >= 1.0:
        return np.inf
    met = np.arange(ALREADY, ALREADY + MOST_MET)
    share = reflectance ** (met - ALREADY)
    powers = (1.0 + largest[None]) ** met[:, None]
    means = powers @ lamps.T - 1.0 - met[:, None] * (lamps @ largest)[None]
    errors = met * offset + means.max(axis=1)
    return float((share * errors).sum() / share.sum())


def _weights(spectra) -> np.ndarray:
    """What lamps give the eye by wavelength, each of sum 1. (l, 471) [-]"""
    seen = np.array([evaluate_emission(each, GRID) for each in spectra]).reshape(-1, len(GRID))
    seen = seen * luminous_efficiency()
    total = seen.sum(axis=1)
    return seen[total > 0.0] / total[total > 0.0, None]


def _deviations(surface: Surface, lamps: np.ndarray):
    """Yield by how much each of a surface's spectra differs from what stands for it.

    Yields
    ------
    ((471,), float, float)    Largest relative deviation by wavelength, the largest mean of one over a lamp, and the largest
        photometric reflectance. Infinite where no bound is known. [-]
    """
    if isinstance(surface, MIXED):
        inner = (
            (surface.surface,) if isinstance(surface, Raised) else (surface.first, surface.second)
        )
        for each in inner:
            yield from _deviations(each, lamps)
        return
    colours = [each for each in surface.colours if not isinstance(each, Constant)]
    if not colours and not surface.has_own_colour:
        return
    is_known = isinstance(surface, LINEAR) or (
        isinstance(surface, Coated) and not surface.has_own_colour
    )
    if not is_known or any(isinstance(each, ImageTexture) for each in colours):
        yield np.zeros(len(GRID)), np.inf, 1.0
        return
    for colour in colours:
        values = evaluate_reflectance(colour, GRID)
        means = lamps @ values
        if not len(means) or means.min() <= 0.0:
            yield np.zeros(len(GRID)), np.inf, 1.0
            continue
        # Under a clear coat some of the light meets the base again and again.
        for returned in (0.0, INSIDE) if isinstance(surface, Coated) else (0.0,):
            own, stood = (x / (1.0 - returned * x) for x in (values, means))
            apart = np.abs(own[None] / stood[:, None] - 1.0).max(axis=0)
            mean = np.abs((lamps @ own)[:, None] / stood[None] - 1.0).max()
            yield apart, float(mean), float(means.max())
