"""The sky of Preetham: formulas of Perez for luminance and chromaticity, with coefficients linear in turbidity.

References
----------
A. J. Preetham, P. Shirley, B. Smits: A Practical Analytic Model for Daylight, SIGGRAPH 1999, 91-100,
doi:10.1145/311535.311545
"""

import numpy as np

from .directions import angle_to

LEVEL = 0.06
"""What Blender multiplies the luminance with. [1/(kcd/m2)]"""

HORIZON = 0.001
"""Directions are taken as at least this high. [rad]"""

_FORMULA = np.array(
    [
        [(0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771), (-0.0670, 0.3703)],
        [(-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)],
        [(-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529)],
    ]
)  # fmt: skip
"""Slope over turbidity and value at none of the coefficients a to e, for the luminance Y and the chromaticities x and y."""

_ZENITH = np.array(
    [
        [
            (0.00166, -0.00375, 0.00209, 0.0),
            (-0.02903, 0.06377, -0.03202, 0.00394),
            (0.11693, -0.21196, 0.06052, 0.25886),
        ],
        [
            (0.00275, -0.00610, 0.00317, 0.0),
            (-0.04214, 0.08970, -0.04153, 0.00516),
            (0.15346, -0.26756, 0.06670, 0.26688),
        ],
    ]
)
"""Chromaticities x and y of the zenith: polynomials in the sun's zenith angle for the powers 2, 1, 0 of the turbidity."""


def find_light(directions, towards_sun, turbidity: float) -> np.ndarray:
    """Return X, Y and Z as Blender has them.

    Parameters
    ----------
    directions : (..., 3) array    Unit vectors.
    towards_sun : (3,) array    Unit vector.
    turbidity : float    [-]

    Returns
    -------
    (..., 3) float64 array
    """
    sun = float(np.arccos(np.clip(towards_sun[2], -1.0, 1.0)))
    coefficients = _FORMULA @ (turbidity, 1.0)
    zenith = np.array([_zenith_luminance(sun, turbidity), *_zenith_chromaticity(sun, turbidity)])
    angle = angle_to(directions, towards_sun)
    polar = np.arccos(np.clip(directions[..., 2], -1.0, 1.0))
    cosine = np.cos(np.minimum(polar, 0.5 * np.pi - HORIZON))
    level, x, y = (
        amount * _perez(row, cosine, angle) / _perez(row, 1.0, sun)
        for amount, row in zip(zenith, coefficients, strict=True)
    )
    # Where the chromaticity has no meaning Blender shows black.
    scale = np.divide(level, y, out=np.zeros_like(level), where=y != 0.0)
    return np.stack([scale * x, np.where(y != 0.0, level, 0.0), scale * (1.0 - x - y)], axis=-1)


def _zenith_luminance(sun: float, turbidity: float) -> float:
    angle = (4.0 / 9.0 - turbidity / 120.0) * (np.pi - 2.0 * sun)
    bright = (4.0453 * turbidity - 4.9710) * np.tan(angle) - 0.2155 * turbidity + 2.4192
    return LEVEL * float(bright)


def _zenith_chromaticity(sun: float, turbidity: float) -> np.ndarray:
    return _ZENITH @ (sun**3, sun**2, sun, 1.0) @ (turbidity**2, turbidity, 1.0)


def _perez(coefficients, cosine, angle):
    a, b, c, d, e = coefficients
    return (1.0 + a * np.exp(b / cosine)) * (1.0 + c * np.exp(d * angle) + e * np.cos(angle) ** 2)
