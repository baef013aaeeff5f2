"""What scatters and absorbs in a thread, by wavelength: from its scatterers and its dye to numbers for a walk."""

import numpy as np

from ..paint.mie import scatter_spheres
from .composition import Yarn
from .thread_walk import ThreadOptics

WAVELENGTHS = np.arange(390.0, 711.0, 10.0)
"""Bands of tables. [nm]"""

ANCHORS = (430.0, 550.0, 670.0)
"""Wavelengths at which photons are followed; between them shares are linear, beyond them they hold. [nm]"""

CHANCES = 1024
"""Even chances between which the cosine of the angle of scattering is linear."""

ANGLES = 3600
"""Angles between which a phase function is integrated."""


def thread_optics(yarn: Yarn, wavelength: float) -> ThreadOptics:
    """A yarn as photons of a wavelength in nm see it."""
    total, phase = 0.0, 0.0
    angles = np.linspace(0.0, np.pi, ANGLES + 1)
    for each in yarn.scatterers:
        spheres = _scatter(each, yarn, [wavelength])
        strength = each.volume_fraction * spheres.scattering[0] * 1e3
        terms = spheres.series[0] * (2 * np.arange(spheres.series.shape[1]) + 1)
        total += strength
        phase = phase + strength * np.maximum(
            np.polynomial.legendre.legval(np.cos(angles), terms), 0.0
        )
    cosines = 2.0 * np.linspace(1.0, 0.0, CHANCES + 1) - 1.0
    if total > 0.0:
        weight = phase * np.sin(angles)
        chance = np.concatenate([[0.0], np.cumsum(0.5 * (weight[1:] + weight[:-1]))])
        cosines = np.cos(np.interp(np.linspace(0.0, chance[-1], CHANCES + 1), chance, angles))
    return ThreadOptics(yarn.index, total * yarn.radius_mm, cosines, yarn.roughness)


def absorption(yarn: Yarn, wavelengths) -> np.ndarray:
    """Absorption of the matter, its dye and its scatterers along the way of light. (w,) [nm] -> (w,) [1/mm]"""
    made = yarn.absorption.at(wavelengths)
    for each in yarn.scatterers:
        spheres = _scatter(each, yarn, wavelengths)
        made = made + each.volume_fraction * (spheres.extinction - spheres.scattering) * 1e3
    return np.maximum(made, 0.0)


def _scatter(scatterers, yarn: Yarn, wavelengths):
    wavelengths = np.asarray(wavelengths, np.float64)
    index = scatterers.index.at(wavelengths)
    return scatter_spheres(
        index, scatterers.diameters, np.full(len(wavelengths), yarn.index), wavelengths
    )


def anchor_weights(anchors, wavelengths) -> np.ndarray:
    """How much each anchor counts at wavelengths. (a,), (w,) [nm] -> (a, w)"""
    anchors = np.asarray(anchors, np.float64)
    return np.array([np.interp(wavelengths, anchors, row) for row in np.eye(len(anchors))])
