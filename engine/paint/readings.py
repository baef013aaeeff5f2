"""Colours of a paint as hand instruments read them: at several angles, from one direction of light.

Angles are counted from where a mirror would reflect, towards the light (aspecular); a reflectance is that of the perfect
diffuser under the same light, pi f. Instruments tell L*, a*, b* under D65 by the observer of 10 degrees.

References
----------
ASTM E2194 and E2539 for the angles. CIE 15:2018 for the colours.
"""

from functools import lru_cache

import numpy as np

from ...libraries import spectra
from ..photometry.colour import cie_lab
from ..photometry.spectra import GRID, illuminant
from .orange_peel import evaluate
from .solution import Solution

INCIDENCE = 45.0
"""Angle of the light. [deg]"""

ASPECULAR = (15.0, 25.0, 45.0, 75.0, 110.0)
"""Angles of instruments with five. [deg]"""

SIX = (-15.0, *ASPECULAR)
"""Angles of instruments with six. [deg]"""


@lru_cache(maxsize=8)
def _weights(wavelengths: tuple) -> np.ndarray:
    """What makes X, Y, Z of reflectances under D65 and the 10-degree observer, Y of the perfect diffuser 1. (w, 3)"""
    own, values = spectra.observer_1964()
    seen = np.stack([np.interp(GRID, own, values[:, k]) for k in range(3)], axis=1)
    seen = illuminant(GRID, "D65")[:, None] * seen
    tents = np.array([np.interp(GRID, wavelengths, row) for row in np.eye(len(wavelengths))])
    return tents @ seen / seen[:, 1].sum()


def lab_of(reflectances, wavelengths) -> np.ndarray:
    """L*, a*, b* of reflectances under D65 and the 10-degree observer. (..., w) -> (..., 3)"""
    weights = _weights(tuple(np.asarray(wavelengths, np.float64)))
    return cie_lab(np.asarray(reflectances) @ weights, weights.sum(axis=0))


def directions(angles, incidence: float = INCIDENCE) -> tuple[np.ndarray, np.ndarray]:
    """Directions of the light and of the eye for aspecular angles. (n,) [deg] -> two (n, 3) arrays"""
    first = np.radians(incidence)
    last = np.radians(incidence - np.asarray(angles, np.float64))
    zero = np.zeros_like(last)
    wi = np.stack([np.sin(first) + zero, zero, np.cos(first) + zero], axis=1)
    return wi, np.stack([-np.sin(last), zero, np.cos(last)], axis=1)


def reflectances(solution: Solution, angles=ASPECULAR, incidence: float = INCIDENCE) -> np.ndarray:
    """Reflectances of a paint at aspecular angles in degrees. (n,) -> (n, w) [-]"""
    return np.pi * evaluate(solution, *directions(angles, incidence))


def read_lab(solution: Solution, angles=ASPECULAR, incidence: float = INCIDENCE) -> np.ndarray:
    """L*, a*, b* of a paint at aspecular angles in degrees. (n,) -> (n, 3)"""
    return lab_of(reflectances(solution, angles, incidence), solution.wavelengths)
