"""What a year of illuminances is judged by, sensor by sensor, and what is made of it over an area.

Figures of sensors take illuminances (sensors, hours) and which hours count: a mask of them, or `CountedHours` where the
hours are those with light alone. Figures of areas take those of sensors and the areas that they stand for. Shares are of 1.
Illuminances below 0 are those of a replicate (`replicated`) and counted as they are, so that linear figures stay linear.

References
----------
C. F. Reinhart, J. Mardaljevic, Z. Rogers: Dynamic daylight performance metrics for sustainable building design, Leukos 3(1),
2006, 7-31, doi:10.1582/LEUKOS.2006.03.01.001 (daylight autonomy)
Z. Rogers: Daylighting metric development using daylight autonomy calculations in the sensor placement optimization tool,
Architectural Energy Corporation, 2006 (continuous daylight autonomy)
A. Nabil, J. Mardaljevic: Useful daylight illuminance: a new paradigm for assessing daylight in buildings, Lighting Research
and Technology 37(1), 2005, 41-59, doi:10.1191/1365782805li128oa
"""

import numpy as np

from ..errors import SceneError
from .occupancy import CountedHours

TARGET = 300.0
"""Illuminance that a place of work needs. [lx]"""

USEFUL = (100.0, 300.0, 3000.0)
"""Where daylight begins to be useful, where it suffices by itself, and where it is too much. [lx]"""

CLOSE = 1e-9
"""By which shares of an area may miss a bound through the rounding of sums. [-]"""


# ---- of sensors ----


def select_hours(illuminance, hours) -> tuple[np.ndarray, CountedHours]:
    """Return the illuminances that count, and all hours that do.

    Parameters
    ----------
    illuminance : (sensors, h) array    [lx]
    hours : (h,) bool array or CountedHours    Which count; a mask: all hours of 1 h that are judged are among the ``h``.

    Returns
    -------
    (sensors, counted) float array and CountedHours    [lx]

    Raises
    ------
    SceneError    No hour counts, the shapes do not fit, or an illuminance that counts is missing.
    """
    if not isinstance(hours, CountedHours):
        hours = CountedHours(np.asarray(hours, dtype=bool))
    illuminance = np.asarray(illuminance)
    if illuminance.ndim != 2 or hours.lit.shape != illuminance.shape[1:]:
        raise SceneError(
            f"illuminances of the shape {illuminance.shape} do not fit {hours.lit.size} hours, expected sensors by hours"
        )
    if not hours.count:
        raise SceneError("no hour of the year counts, so there is nothing to judge")
    counted = illuminance[:, hours.lit]
    if not np.isfinite(counted).all():
        raise SceneError(
            "an illuminance of an hour that counts is missing, as the weather file has no value for it"
        )
    return counted, hours


def count_at_least(illuminance, hours, bound: float) -> np.ndarray:
    """Share of the hours with a bound at least. (sensors,) [-]

    Raises
    ------
    SceneError    The bound is not above 0, which dark hours have too; or as `select_hours`.
    """
    if not bound > 0.0:
        raise SceneError(f"the illuminance that is asked for is {bound} lx, expected above 0")
    counted, hours = select_hours(illuminance, hours)
    return np.count_nonzero(counted >= bound, axis=1) / hours.count


def daylight_autonomy(illuminance, hours, target: float = TARGET) -> np.ndarray:
    """Share of the hours in which a sensor has the target at least. (sensors,) [-]"""
    return count_at_least(illuminance, hours, target)


def continuous_autonomy(illuminance, hours, target: float = TARGET) -> np.ndarray:
    """Daylight autonomy in which an hour below the target counts by the part of it that it has. (sensors,) [-]"""
    counted, hours = select_hours(illuminance, hours)
    return np.minimum(counted / target, 1.0).sum(axis=1, dtype=np.float64) / hours.count


def useful_illuminance(illuminance, hours, bounds=USEFUL) -> np.ndarray:
    """Shares of the hours by useful daylight illuminance.

    Parameters
    ----------
    illuminance, hours    As of `select_hours`.
    bounds : (float, float, float)    Ascending, above 0. [lx]

    Returns
    -------
    (sensors, 4) array    Below the first; from it up to the second, which lamps have to supplement; from there up to and
        with the third, which suffices; above. The sum is 1. [-]

    Raises
    ------
    SceneError    The bounds do not ascend; or as `select_hours`.
    """
    low, middle, high = bounds
    if not 0.0 < low < middle < high:
        raise SceneError(f"the bounds of useful illuminances, {bounds} lx, do not ascend from 0")
    counted, hours = select_hours(illuminance, hours)
    is_enough, is_much = counted >= middle, counted > high
    kinds = ((counted >= low) & ~is_enough, is_enough & ~is_much, is_much)
    numbers = [np.count_nonzero(kind, axis=1) for kind in kinds]
    return np.stack([hours.count - sum(numbers), *numbers], axis=1) / hours.count


def mean_illuminance(illuminance, hours) -> np.ndarray:
    """Mean over the hours. (sensors,) [lx]"""
    counted, hours = select_hours(illuminance, hours)
    return counted.sum(axis=1, dtype=np.float64) / hours.count


def light_exposure(illuminance, hours) -> np.ndarray:
    """Sum over the hours. (sensors,) [lx h]"""
    counted, hours = select_hours(illuminance, hours)
    return counted.sum(axis=1, dtype=np.float64) * hours.interval


def hours_above(illuminance, hours, bound: float) -> np.ndarray:
    """Time above a bound. (sensors,) [h]"""
    counted, hours = select_hours(illuminance, hours)
    dark = hours.dark if bound < 0.0 else 0
    return (np.count_nonzero(counted > bound, axis=1) + dark) * hours.interval


# ---- of areas ----


def check_areas(values, areas) -> tuple[np.ndarray, np.ndarray]:
    """Return figures (sensors,) and the areas that they stand for, all alike where ``areas`` is None. [m2]

    Raises
    ------
    SceneError    There is no sensor, or areas are negative, all 0 or not as many.
    """
    values = np.asarray(values, dtype=np.float64)
    areas = np.ones(values.shape) if areas is None else np.asarray(areas, dtype=np.float64)
    if values.ndim != 1 or not len(values) or areas.shape != values.shape:
        raise SceneError(f"{values.size} sensors have {areas.size} areas, expected one of each")
    if not (np.isfinite(areas).all() and (areas >= 0.0).all() and areas.sum() > 0.0):
        raise SceneError("the areas of sensors are not numbers of at least 0, or all 0")
    return values, areas


def area_share(values, bound: float, areas=None) -> float:
    """Share of the area whose sensors have the bound at least. [-]"""
    values, areas = check_areas(values, areas)
    return float(areas[values >= bound - CLOSE * max(abs(bound), 1.0)].sum() / areas.sum())


def area_share_above(values, bound: float, areas=None) -> float:
    """Share of the area whose sensors have more than the bound. [-]"""
    values, areas = check_areas(values, areas)
    return float(areas[values > bound].sum() / areas.sum())


def area_mean(values, areas=None) -> float:
    """Mean over the area."""
    values, areas = check_areas(values, areas)
    return float(values @ areas / areas.sum())


def area_exceeded(values, share: float, areas=None) -> float:
    """Value that a share of the area has at least; that of a half is the median.

    Where the area above is just the share, it is the middle between the two values about the place.
    """
    values, areas = check_areas(values, areas)
    order = np.argsort(-values, kind="stable")
    ordered, above = values[order], np.cumsum(areas[order]) / areas.sum()
    i = min(int(np.searchsorted(above, share - CLOSE)), len(ordered) - 1)
    if above[i] < share + CLOSE and i + 1 < len(ordered):
        return float(0.5 * (ordered[i] + ordered[i + 1]))
    return float(ordered[i])


def area_median(values, areas=None) -> float:
    """Value that half of the area has at least."""
    return area_exceeded(values, 0.5, areas)


def area_least(values, areas=None) -> float:
    """Least value of sensors that stand for an area."""
    values, areas = check_areas(values, areas)
    return float(values[areas > 0.0].min())


def uniformity(values, areas=None) -> float:
    """Least value over the mean; 0 where there is no light. [-]"""
    mean = area_mean(values, areas)
    return area_least(values, areas) / mean if mean > 0.0 else 0.0
