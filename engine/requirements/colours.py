"""Whether light needs wavelengths.

Photometric transport has one reflectance for each surface, weighed by the lights and the eye. That is exact of one
reflection; of several it is wrong by what the spectra of the surfaces have in common (theory 15.1).
"""

import numpy as np

from ..photometry.spectra import GRID, evaluate_emission, evaluate_reflectance, luminous_efficiency
from ..scene.material import ROUNDING, Blend, Coated, Diffuse, Mix, Raised, Surface
from ..scene.modelling import Switch
from ..scene.spectrum import Constant
from ..scene.texture import ImageTexture
from .decision import Asked, Decision, Late, Outcome, accepts
from .facts import Facts

NAME = "colours"

SAVING = 0.25
"""Share of the time of a spectral sample that a photometric one saves. [-]"""

MOST_LEFT = 0.98
"""Share of light that may be left by each reflection at the wavelength that is reflected best; of more no bound is found."""

LEAST = 1e-12
"""Share of light that is left when the series is broken off."""

ALREADY = 2
"""Coloured surfaces that light has met before it reaches those who are worst off. Of fewer the bound is smaller."""

ALREADY_IN_MAPS = 64
"""The same of lumels, of which none is asked whether its light comes late: as many as sensors are asked for at most."""

LATER = (8, 16, 32, 64)
"""Coloured surfaces that it may have met where sensors find that it comes late, see `Outcome`."""


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
    already = ALREADY_IN_MAPS if asked.objects else ALREADY
    bound = np.inf if asked.has_colour else find_bound(facts, already)
    if accepts(bound, allowance, switch):
        told = (
            f"the spectra are so alike that light is right within {100.0 * bound:.2g} %"
            if bound > 0.0
            else "all surfaces are neutral: photometric transport is exact where no colours are wanted"
        )
        made = Decision(NAME, "photometric", told, bound, SAVING, switch)
        return Outcome(made, is_spectral=False, late=find_late(facts) if bound > 0.0 else ())
    if np.isfinite(bound) and switch is not Switch.OFF:
        told += f"; without wavelengths light could be wrong by {100.0 * bound:.2g} %"
    elif switch is Switch.FORCE:
        told += "; what light without wavelengths would be wrong by is not known"
    return Outcome(Decision(NAME, "spectral", told, switch=switch), {}, True, dispersive)


def find_late(facts: Facts) -> tuple[Late, ...]:
    """What the bound is where light has met more surfaces before it comes than `find_bound` takes for granted."""
    found = _find(facts)
    if not isinstance(found, tuple):
        return ()
    share, own = found[-1], _sum_up(*found, ALREADY)
    return tuple(
        Late(met, share ** (met - last), _sum_up(*found, met) - own)
        for last, met in zip((ALREADY, *LATER), LATER, strict=False)
    )


def find_bound(facts: Facts, already: int = ALREADY) -> float:
    """Largest relative error of photometric transport, infinite where it is not known. [-]

    Light of a lamp that has met k coloured surfaces, whose reflectances differ from their photometric ones by the factors
    1 + d_i, is right but for ``E[(1 + d_1) ... (1 + d_k)] - 1``, E being the mean over the wavelengths by the lamp and the
    eye. With m the largest mean of a d, that is at most ``k m`` and the mean of what the product differs from
    ``1 + d_1 + ... + d_k``, which `_sum_up` bounds. Of light that has met k surfaces no more than the largest reflectance is
    left to meet another, so that the mean over all light is at most that of a geometric series from ``already`` on.
    """
    found = _find(facts)
    return _sum_up(*found, already) if isinstance(found, tuple) else found


def _find(facts: Facts):
    """What `_sum_up` sums up; or a bound, where it follows from less."""
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
    above, below = np.maximum(apart.max(axis=(0, 1)), 0.0), np.maximum(-apart.min(axis=(0, 1)), 0.0)
    return lamps, above, below, float(means.max()), float(shares.max())


def _sum_up(lamps, above, below, offset: float, reflectance: float, already: int) -> float:
    """Mean of the errors of light by how many coloured surfaces it has met, of the lamp that is worst off. [-]

    With all d between -b and a, a product of k factors 1 + d differs from 1 plus their sum by most where each is at one of
    its ends: by ``(1 + a)^k - 1 - k a``, by ``(1 - b)^k - 1 + k b``, or where some are here and others there by less than
    ``((1 + a)^k - 1) k b / 4``.
    """
    left = reflectance * (1.0 + above.max())
    if not np.isfinite(offset) or left > MOST_LEFT:
        return np.inf
    more = np.arange(max(int(np.log(LEAST) / np.log(left)), 1))[:, None]
    met, share = already + more, reflectance**more
    # With the share of light, or powers of dark saturated colours would be too large for numbers.
    up, down = (
        (reflectance * factor) ** more * factor**already - share
        for factor in (1.0 + above, 1.0 - below)
    )
    apart = np.maximum(up - share * met * above, down + share * met * below)
    apart = np.maximum(apart, np.minimum(0.25 * met * below, 1.0) * up)
    errors = (met * share * offset + apart @ lamps.T).sum(axis=0)
    return float(errors.max() / share.sum())


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
    ((2, 471), float, float)    Least and largest relative deviations by wavelength, the largest mean of one over a lamp,
        and the largest share of light that leaves by a spectrum of the surface, of that which meets one. Infinite where no
        bound is known. [-]
    """
    if isinstance(surface, Mix | Raised) or _is_even(surface):
        is_mixed = not isinstance(surface, Raised)
        for each in (surface.first, surface.second) if is_mixed else (surface.surface,):
            yield from _deviations(each, lamps)
        return
    colours = [each for each in surface.colours if not isinstance(each, Constant)]
    if not colours and not surface.has_own_colour:
        return
    if not _is_linear(surface) or any(isinstance(each, ImageTexture) for each in colours):
        yield np.zeros((2, len(GRID))), np.inf, 1.0
        return
    # What a sheet reflects and what it lets through both go on.
    spread = surface.colours if isinstance(surface, Diffuse) else (surface.reflectance,)
    share = sum(float((lamps @ _values(each)).max(initial=0.0)) for each in spread)
    for colour in colours:
        values = _values(colour)
        means = lamps @ values
        if not len(means) or means.min() <= 0.0:
            yield np.zeros((2, len(GRID))), np.inf, 1.0
            continue
        # Photometric reflectances are by the mean of all lamps, so between those by single ones.
        apart = np.stack([values / means.max(), values / means.min()]) - 1.0
        mean = np.abs(means[:, None] / means[None] - 1.0).max()
        yield apart, float(mean), share


def _values(colour) -> np.ndarray:
    return np.clip(evaluate_reflectance(colour, GRID), 0.0, 1.0)


def _is_even(surface: Surface) -> bool:
    """Whether a surface is a blend by weights that are the same for light and eye, and that nothing holds down."""
    if not isinstance(surface, Blend) or not surface.is_reciprocal:
        return False
    return np.asarray(surface.weights).sum(axis=1).max() <= 1.0 + ROUNDING


def _is_linear(surface: Surface) -> bool:
    """Whether what a surface sends on is in proportion to its spectra, or has no wavelength.

    Bases whose facets lie aslant light each other, and what a tinted coat leaves to its base follows from its largest tint.
    """
    match surface:
        case Diffuse():
            return surface.roughness <= 0.0
        case Coated():
            is_clear = surface.tint is None or isinstance(surface.tint, Constant)
            return is_clear and surface.film is None and surface.base_roughness <= 0.0
    return False
