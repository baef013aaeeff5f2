"""Diffuse surfaces whose facets lie aslant: Oren and Nayar's model by Fujii, with the light that passes between facets.

With the diffuse roughness sigma, the cosines c_i and c_o of both directions and s = cos(i, o) - c_i c_o,

    f = rho / pi * (A (1 + sigma t) + rho^2 k (1 - E(c_i)) (1 - E(c_o))),    t = s / max(c_i, c_o) where s > 0, else s
    A = 1 / (1 + sigma (1/2 - 2/(3 pi))),    E(c) = A (1 + sigma G(c) / pi)
    k = E_mean / ((1 - E_mean) (1 - rho (1 - E_mean)))

E is what white facets reflect once, E_mean its mean over the hemisphere. It is reciprocal, with rho = 1 it reflects
everything, and with sigma = 0 it is Lambert's law. The power of rho is Cycles'.

References
----------
Y. Fujii: A tiny improvement of Oren-Nayar reflectance model, 2012.
J. Portsmouth, P. Kutz, S. Hill: EON: A Practical Energy-Preserving Rough Diffuse BRDF, JCGT 14(1), 2025.
"""

import numpy as np

NARROW = 0.5 - 2.0 / (3.0 * np.pi)
"""By how much 1 / A grows with sigma. [-]"""

MEAN = (2.0 * np.pi - 5.6) / (3.0 * np.pi)
"""Mean of G / pi over the hemisphere. [-]"""


def aslant(cos_i, cos_o, cosine, sigma, reflectance):
    """Factor on Lambert's law.

    Parameters
    ----------
    cos_i, cos_o : Float    To the normal, positive. [-]
    cosine : Float    Between both directions. [-]
    sigma : Float    Diffuse roughness, 0 to 1. [-]
    reflectance : Spectrum    rho. [-]

    Returns
    -------
    Spectrum    [-]
    """
    import drjit as dr

    scale = 1.0 / (1.0 + NARROW * sigma)
    s = cosine - cos_i * cos_o
    t = dr.select(s > 0.0, s / dr.maximum(dr.maximum(cos_i, cos_o), 1e-6), s)
    mean = scale * (1.0 + MEAN * sigma)
    lost_i, lost_o = (1.0 - scale * (1.0 + sigma * _g(c)) for c in (cos_i, cos_o))
    lost = lost_i * lost_o * mean / dr.maximum(1.0 - mean, 1e-6)
    often = dr.square(reflectance) * lost / dr.maximum(1.0 - reflectance * (1.0 - mean), 1e-6)
    return scale * (1.0 + sigma * t) + often


def _g(cosine):
    """G / pi of a cosine to the normal, by which E grows with sigma."""
    import drjit as dr

    cosine = dr.maximum(cosine, 1e-4)
    sine = dr.safe_sqrt(1.0 - dr.square(cosine))
    single = sine * (dr.safe_acos(cosine) - 2.0 / 3.0 - sine * cosine)
    # (2/3) tan (1 - sin^3) without cancellation: 1 - sin^3 = cos^2 (1 + sin + sin^2) / (1 + sin).
    rest = 2.0 / 3.0 * sine * cosine * (1.0 + sine + dr.square(sine)) / (1.0 + sine)
    return (single + rest) * dr.inv_pi
