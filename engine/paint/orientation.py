"""How flakes lie: the spread of their normals, what they scatter from direction to direction, and what they intercept.

Normals have Gaussian slopes with the standard deviation s per axis, so their density by solid angle is

    D(theta) = exp(-tan2 theta / (2 s2)) / (2 pi s2 cos3 theta)

A face with the normal h half between both directions reflects: a area of faces by volume, r their reflectance, scatter

    S(w', w) = a r(c) D(h) / 4,    c = sqrt((1 - w . w') / 2)

by length and solid angle, and intercept a E[|w . n| (1 - t(|w . n|))] by length, since light that passes them goes on.

References
----------
J. Heitz et al.: The SGGX microflake distribution, ACM Trans. Graph. 34 (4), 2015, for the frame of such media.
"""

from functools import lru_cache

import numpy as np

from .flake_optics import polynomials

SLOPES = 32
"""Slopes along each axis by which interception is averaged."""

AZIMUTHS = 4
"""Azimuths for each Fourier mode, at which scattering is integrated."""

FEWEST_AZIMUTHS = 64
"""Azimuths at least."""

DIFFRACTION = 0.21
"""Standard deviation of a disc's diffraction lobe as one of slopes, times diameter over wavelength in the binder. [-]"""

DIFFRACTED_BELOW = 10.0
"""Diameter from which on diffraction does not count. [um]"""


def slope_with_diffraction(slope: float, diameter_um: float | None, binder_index: float) -> float:
    """Slopes that blur as much as those of flakes and the light bent at their edges, taken at 550 nm for all bands."""
    if diameter_um is None or diameter_um >= DIFFRACTED_BELOW:
        return slope
    return float(np.hypot(slope, DIFFRACTION * 0.55 / (binder_index * diameter_um)))


def density(cosine, slope: float) -> np.ndarray:
    """Density of normals by solid angle at a cosine to that of the surface. (...) [1/sr]"""
    cosine = np.maximum(cosine, 1e-9)
    tangent = np.maximum(0.0, 1.0 / cosine**2 - 1.0)
    return np.exp(-tangent / (2.0 * slope**2)) / (2.0 * np.pi * slope**2 * cosine**3)


@lru_cache(maxsize=64)
def _normals(slope: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    places, weights = np.polynomial.hermite_e.hermegauss(SLOPES)
    weights = weights / weights.sum()
    half = places > 0.0  # across, both sides are alike
    along, across = np.meshgrid(places * slope, places[half] * slope, indexing="ij")
    weight = np.outer(weights, 2.0 * weights[half]).ravel()
    upright = 1.0 / np.sqrt(1.0 + along.ravel() ** 2 + across.ravel() ** 2)
    return upright, along.ravel() * upright, weight


def interception(cosines, slope: float, terms: int) -> np.ndarray:
    """Mean of |w . n| times each Chebyshev polynomial of it over the normals. (n,) -> (n, q)"""
    return _interception(tuple(cosines), slope, terms)


@lru_cache(maxsize=64)
def _interception(cosines: tuple, slope: float, terms: int) -> np.ndarray:
    upright, along, weight = _normals(slope)
    cosines = np.asarray(cosines, np.float64)
    sine = np.sqrt(np.maximum(0.0, 1.0 - cosines**2))
    met = np.minimum(np.abs(cosines[:, None] * upright - sine[:, None] * along), 1.0)
    made = np.empty((len(cosines), terms))
    for k in range(len(cosines)):
        made[k] = (weight * met[k]) @ polynomials(met[k], terms)
    return made


@lru_cache(maxsize=24)
def scattering_modes(cosines: tuple, slope: float, modes: int, terms: int) -> np.ndarray:
    """Fourier modes of pi S / a of flakes that reflect as each Chebyshev polynomial.

    Parameters
    ----------
    cosines : tuple of float    Of the directions in the binder.
    slope : float
    modes, terms : int

    Returns
    -------
    (q, 2, m, p) float64 array
        For light that turns back, then for light that goes on downwards; of the pairs i <= j as of `numpy.triu_indices`.
        With the azimuth phi from forward, S = S_0 + 2 sum S_m cos(m phi). [1]
    """
    cosines = np.array(cosines)
    i, j = np.triu_indices(len(cosines))
    sine = np.sqrt(np.maximum(0.0, 1.0 - cosines**2))
    # The nearer to grazing, the narrower is the lobe about the azimuth 0.
    places, weights = np.polynomial.legendre.leggauss(max(FEWEST_AZIMUTHS, AZIMUTHS * modes))
    places, weights = 0.5 * (places + 1.0), 0.5 * weights
    azimuths = np.pi * places**2
    waves = np.cos(np.outer(np.arange(modes), azimuths)) * (2.0 * places * weights)
    made = np.empty((terms, 2, modes, len(i)))
    level = (sine[i] * sine[j])[:, None] * np.cos(azimuths)
    for side, sign in enumerate((1.0, -1.0)):
        product = level - sign * (cosines[i] * cosines[j])[:, None]
        gap = np.sqrt(np.maximum(2.0 * (1.0 - product), 1e-24))
        tilt = np.abs(cosines[i] + sign * cosines[j])[:, None] / gap
        lobe = 0.25 * np.pi * density(np.minimum(tilt, 1.0), slope)
        x = np.minimum(gap, 2.0) - 1.0
        before, now = np.zeros_like(x), lobe
        for term in range(terms):
            made[term, side] = waves @ now.T
            # Chebyshev's recurrence, with the lobe in it from the beginning.
            before, now = now, (x * lobe if term == 0 else 2.0 * x * now - before)
    return made
