"""Correlated colour temperature: the blackbody whose colour comes nearest."""

from functools import lru_cache

import numpy as np

from .spectra import GRID, observer, planck

COLDEST, HOTTEST = 1000.0, 25_000.0
"""Blackbodies that are compared. [K]"""

FARTHEST = 0.05
"""Distance from the Planckian locus up to which a colour temperature has a meaning. [-] (CIE 15:2018, 9.5)"""

_STEPS = 1000
"""Blackbodies that are tried, evenly over the reciprocal temperature, before the parabola through the nearest three."""


def colour_temperature(tristimulus) -> tuple[float, float] | None:
    """Correlated colour temperature [K] and Duv, the signed distance from the locus, above it positive. [-]

    Parameters
    ----------
    tristimulus : (3,) array    X, Y, Z on any scale.

    Returns
    -------
    (float, float) or None    None of a colour that is farther from the locus than `FARTHEST`, or beyond its ends.

    References
    ----------
    CIE 15:2018, 9.5; ANSI C78.377 for Duv. Distances are those of the CIE 1960 (u, v) diagram.
    """
    place = _uv(np.asarray(tristimulus, dtype=np.float64))
    if not np.isfinite(place).all():
        return None
    mireds, locus = _locus()
    distance = np.hypot(*(locus - place).T)
    near = int(np.argmin(distance))
    if near in {0, _STEPS - 1}:
        return None
    before, here, after = distance[near - 1 : near + 2] ** 2
    mired = mireds[near] + 0.5 * (mireds[1] - mireds[0]) * (before - after) / (
        before - 2.0 * here + after
    )
    nearest = _uv(planck(GRID, 1e6 / mired) @ observer())
    apart = place - nearest
    if np.hypot(*apart) > FARTHEST:
        return None
    return 1e6 / float(mired), float(np.copysign(np.hypot(*apart), apart[1]))


@lru_cache
def _locus() -> tuple[np.ndarray, np.ndarray]:
    """Reciprocal temperatures of the blackbodies that are tried [1e6/K], and their u, v. (n,), (n, 2)"""
    mireds = np.linspace(1e6 / HOTTEST, 1e6 / COLDEST, _STEPS)
    return mireds, _uv(np.stack([planck(GRID, 1e6 / mired) for mired in mireds]) @ observer())


def _uv(tristimulus: np.ndarray) -> np.ndarray:
    """Chromaticity u, v of CIE 1960. (..., 3) -> (..., 2)"""
    with np.errstate(invalid="ignore", divide="ignore"):
        total = tristimulus @ np.array([1.0, 15.0, 3.0])
        return tristimulus[..., :2] * np.array([4.0, 6.0]) / np.asarray(total)[..., None]
