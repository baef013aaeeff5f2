"""What readers find odd about scattering, and say to people."""

import numpy as np

from ...reading.remarks import Remark
from ...scene.scattering import Scatter
from ..data.evaluation import incidences_of, totals

MOST_LIGHT = 1.02
"""Share of light that may leave a surface before it is told: measurements are not better."""

TOTAL_TOLERANCE = 0.1
"""Relative difference of a stated total and that of the values before it is told."""

LIMIT_POLAR = np.radians(85.0)
"""Values are expected up to it."""


def shares_of(scatter: Scatter) -> list[tuple[float, float]]:
    """Angles of incidence with the largest share of light that is sent away, of all rotations and bands. [rad, -]"""
    rotations = getattr(scatter, "rotations", np.zeros(1))
    incidences = incidences_of(scatter)
    made = totals(scatter, incidences, rotations).max(axis=(0, 2))
    return list(zip(incidences, made, strict=True))


def tell_excess(side: str, shares: list[tuple[float, float]]) -> list[Remark]:
    """A remark where more light is sent away than comes. ``shares`` as of `shares_of`."""
    incidence, share = max(shares, key=lambda each: each[1])
    if share <= MOST_LIGHT:
        return []
    return [
        Remark(
            f"{side.replace('_', ' ')} sends away {share:.3g} times the light that comes at "
            f"{np.degrees(incidence):.3g} degrees; values look like luminance factors (divide by pi) or "
            "per cent"
        )
    ]


def tell_scaling(side: str, factors: list[tuple[float, float]]) -> list[Remark]:
    """A remark where values did not sum up to what is stated.

    Parameters
    ----------
    side : str    Of `record.SIDES`.
    factors : list of (incidence, factor)    That values were scaled with. [rad, -]
    """
    off = [each for each in factors if abs(each[1] - 1.0) > TOTAL_TOLERANCE]
    if not off:
        return []
    incidence, factor = max(off, key=lambda each: abs(np.log(each[1])))
    return [
        Remark(
            f"values of {side.replace('_', ' ')} do not sum up to the stated totals and were scaled "
            f"to them, by {factor:.4g} at {np.degrees(incidence):.3g} degrees"
        )
    ]


def tell_negative(side: str, count: int, size: int) -> list[Remark]:
    """A remark on negative values that were taken as 0."""
    if not count:
        return []
    return [
        Remark(
            f"{count} of {size} values of {side.replace('_', ' ')} are negative and were taken as 0"
        )
    ]


def tell_missing(side: str, steepest: float) -> list[Remark]:
    """A remark where values end well before the horizon. ``steepest`` [rad]"""
    if steepest >= LIMIT_POLAR - 1e-6:
        return []
    return [
        Remark(
            f"{side.replace('_', ' ')} has no values beyond {np.degrees(steepest):.3g} degrees; the last "
            "ones hold"
        )
    ]
