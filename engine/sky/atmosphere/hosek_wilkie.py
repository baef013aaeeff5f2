"""The sky of Hosek and Wilkie: a formula fitted to simulated skies, by turbidity, the ground's albedo and the sun's height.

References
----------
L. Hosek, A. Wilkie: An Analytic Model for Full Spectral Sky-Dome Radiance, ACM Transactions on Graphics 31(4), 2012, 95,
doi:10.1145/2185520.2185591
"""

import numpy as np

from ....libraries import skies
from .directions import angle_to
from .preetham import HORIZON

LEVEL = 2.0 * np.pi / 683.0
"""What Blender multiplies the model's values with. [-]"""

_BINOMIAL = np.array([1.0, 5.0, 10.0, 10.0, 5.0, 1.0])


def find_light(directions, towards_sun, turbidity: float, albedo: float) -> np.ndarray:
    """Return X, Y and Z as Blender has them.

    Parameters
    ----------
    directions : (..., 3) array    Unit vectors.
    towards_sun : (3,) array    Unit vector; below the horizon it is taken at it.
    turbidity : float    1 to 10; beyond, the nearest counts. [-]
    albedo : float    Of the ground. [-]

    Returns
    -------
    (..., 3) float64 array
    """
    elevation = np.arcsin(np.clip(towards_sun[2], 0.0, 1.0))
    coefficients, radiance = (
        _between(table, np.clip(turbidity, 1.0, 10.0), albedo, elevation)
        for table in skies.hosek_wilkie()
    )
    # The formula sees the sun where it is put, its coefficients where it can be.
    polar = np.arccos(np.clip(directions[..., 2], -1.0, 1.0))
    cosine = np.cos(np.minimum(polar, 0.5 * np.pi - HORIZON))
    angle = angle_to(directions, towards_sun)
    values = [
        level * _formula(row, cosine, angle)
        for row, level in zip(coefficients, radiance, strict=True)
    ]
    return LEVEL * np.stack(values, axis=-1)


def find_radiance(directions, towards_sun, turbidity: float, albedo: float) -> np.ndarray:
    """Return spectral radiance at the model's wavelengths, `skies.WAVELENGTHS`.

    Parameters
    ----------
    directions : (..., 3) array    Unit vectors above the horizon.
    towards_sun : (3,) array    Unit vector above the horizon.
    turbidity : float    1 to 10. [-]
    albedo : float    Of the ground, 0 to 1. [-]

    Returns
    -------
    (11, ...) float64 array    [W/(m2 sr nm)]
    """
    elevation = np.arcsin(np.clip(towards_sun[2], 0.0, 1.0))
    coefficients, radiance = (
        _between(table, turbidity, albedo, elevation) for table in skies.spectral_hosek_wilkie()
    )
    cosine = np.clip(directions[..., 2], 0.0, 1.0)
    angle = angle_to(directions, towards_sun)
    return np.stack(
        [
            level * _formula(row, cosine, angle)
            for row, level in zip(coefficients, radiance, strict=True)
        ]
    )


def _between(table, turbidity: float, albedo: float, elevation: float) -> np.ndarray:
    """Interpolate the control points, linear in turbidity and albedo. (n, 2, 10, 6, ...) -> (n, ...)"""
    place = np.cbrt(elevation / (0.5 * np.pi))
    powers = np.arange(len(_BINOMIAL))
    weights = _BINOMIAL * (1.0 - place) ** powers[::-1] * place**powers
    low = min(int(turbidity), table.shape[2] - 1)
    rest = turbidity - low
    points = table[:, :, low - 1] * (1.0 - rest) + table[:, :, low] * rest
    points = points[:, 0] * (1.0 - albedo) + points[:, 1] * albedo
    return np.tensordot(points, weights, axes=(1, 0))


def _formula(coefficients, cosine, angle) -> np.ndarray:
    a, b, c, d, e, f, g, i, h = coefficients
    near = np.cos(angle)
    forward = (1.0 + near**2) / (1.0 + h**2 - 2.0 * h * near) ** 1.5
    glow = c + d * np.exp(e * angle) + f * near**2 + g * forward + i * np.sqrt(cosine)
    return (1.0 + a * np.exp(b / (cosine + 0.01))) * glow
