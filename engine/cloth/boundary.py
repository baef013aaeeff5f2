"""Where light meets the surface of a thread: Fresnel's law, or facets after Trowbridge and Reitz (GGX) that obey it.

A facet that is hit reflects, or lets light into the thread; it never loses any. What a direction is reflected of in the
mean, E(mu), is also what keeps light from leaving the thread in that direction, so that the surface is reciprocal.

References
----------
B. Walter and others: Microfacet Models for Refraction through Rough Surfaces, EGSR 2007. E. Heitz: Sampling the GGX
Distribution of Visible Normals, JCGT 7(4), 2018; Understanding the Masking-Shadowing Function, JCGT 3(2), 2014.
"""

from functools import lru_cache

import numpy as np

from ..paint.fresnel import face_reflectance

COSINES = 128
"""Intervals of the square root of the cosine, between which E(mu) is linear."""

POINTS = 64
"""Points of the quadrature over facets, along both axes."""


def reflect_share(cosine, index: float, roughness: float) -> np.ndarray:
    """Share E(mu) of light that a surface reflects once.

    Parameters
    ----------
    cosine : (n,) array    Of the angle of incidence, in air.
    index : float    Of the thread; infinite: facets that reflect all.
    roughness : float    alpha of GGX; 0: smooth.

    Returns
    -------
    (n,) float64 array    [-]
    """
    cosine = np.maximum(np.atleast_1d(np.asarray(cosine, np.float64)), 1e-4)
    if roughness <= 0.0:
        return _fresnel(cosine, index)
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    first, turn = 0.5 * (nodes + 1.0), 0.5 * np.pi * nodes
    weight = 0.25 * weights[:, None] * weights
    # Facets as an eye along the direction sees them; one half of the disk is the mirror image of the other.
    sine = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
    made = np.empty_like(cosine)
    for k, (c, s) in enumerate(zip(cosine, sine, strict=True)):
        x, _, z = visible_facet(roughness, s, c, first[:, None], turn)
        along = np.maximum(s * x + c * z, 0.0)
        out = 2.0 * along * z - c
        masking = smith(out, roughness, c)
        made[k] = (weight * np.where(out > 0.0, _fresnel(along, index) * masking, 0.0)).sum()
    return made


def visible_facet(roughness: float, sine, cosine, first, turn):
    """Normal of a facet that is seen from (sine, 0, cosine), by a number from 0 to 1 and an angle. Three arrays."""
    x, z = roughness * sine, cosine
    length = np.sqrt(x**2 + z**2)
    x, z = x / length, z / length
    radius = np.sqrt(first)
    one, two = radius * np.cos(turn), radius * np.sin(turn)
    lift = 0.5 * (1.0 + z)
    # The axes across the view are y, and the one up from it.
    bent = (1.0 - lift) * np.sqrt(np.maximum(1.0 - one**2, 0.0)) + lift * two
    up = np.sqrt(np.maximum(1.0 - one**2 - bent**2, 0.0))
    normal = np.array([-z * bent + x * up, one, np.maximum(x * bent + z * up, 1e-9)])
    normal[:2] *= roughness
    return normal / np.sqrt((normal**2).sum(axis=0))


def smith(out, roughness: float, cosine):
    """Share of what a seen facet reflects that no other facet stops: G2 over G1, heights correlated. [-]"""
    there, here = (_lambda(np.maximum(c, 1e-6), roughness) for c in (out, cosine))
    return (1.0 + here) / (1.0 + here + there)


def _lambda(cosine, roughness: float):
    return 0.5 * (np.sqrt(1.0 + roughness**2 * (1.0 / cosine**2 - 1.0)) - 1.0)


def _fresnel(cosine, index: float):
    if np.isinf(index):
        return np.ones_like(cosine)
    return face_reflectance(np.sqrt(np.maximum(1.0 - cosine**2, 0.0)), 1.0, index)


@lru_cache(maxsize=32)
def share_table(index: float, roughness: float) -> np.ndarray:
    """E(mu) where the square root of mu is k / `COSINES`. (`COSINES` + 1,) float64 [-]"""
    return reflect_share(np.linspace(0.0, 1.0, COSINES + 1) ** 2, index, roughness)
