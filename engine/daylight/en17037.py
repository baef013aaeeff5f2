"""Daylight in buildings by EN 17037: provision by both of its methods, exposure to sunlight, and levels.

Provision asks for a target illuminance over half of a plane and for a least one over 95 % of it, in half of the daylight
hours of the year, through windows in walls; through openings above, for the target over 95 %. Method 1 asks for the daylight
factors that give these illuminances under the median sky of the place, method 2 for the illuminances themselves, hour by
hour: a point has an illuminance where it has it in half of the daylight hours. Daylight hours are the half of the year in
which the sky gives most.

Exposure to sunlight asks for hours of sun on one cloudless day between 1 February and 21 March. The standard states the
least elevation of the sun that counts for capital cities; it has to be given here.

References
----------
EN 17037:2018+A1:2021, Daylight in buildings, 5.1, 5.3, annex A (tables A.1, A.2, A.6), annex B and annex D
"""

from dataclasses import dataclass
from datetime import date

import numpy as np

from ..errors import SceneError
from . import metrics
from .replicated import MetricEstimate, over_area

TARGET_AREA, LEAST_AREA = 0.5, 0.95
"""Shares of the plane that need the target and the least illuminance. [-]"""

SHARE_OF_HOURS = 0.5
"""Of the daylight hours. [-]"""

FIRST_DAY, LAST_DAY = (2, 1), (3, 21)
"""Month and day between which exposure to sunlight is judged."""


@dataclass(frozen=True)
class Level:
    """What a level of the standard asks for.

    Parameters
    ----------
    name : str
    target, least : float    Illuminances. [lx]
    sunlight : float    Of one day. [h]
    """

    name: str
    target: float
    least: float
    sunlight: float


LEVELS = (
    Level("minimum", 300.0, 100.0, 1.5),
    Level("medium", 500.0, 300.0, 3.0),
    Level("high", 750.0, 500.0, 4.0),
)
"""From low to high."""

NONE = "none"
"""Where not even the lowest is reached."""


@dataclass(frozen=True, eq=False)
class Provision:
    """Daylight provision of a plane.

    Parameters
    ----------
    target_areas, least_areas : MetricEstimate    Share of the plane that has each level's target, and its least
        illuminance. (3,) [-]
    level : str    That is reached.
    lowest, highest : str    Levels that the replicates reach: where they are not the same, the noise leaves it open.
    """

    target_areas: MetricEstimate
    least_areas: MetricEstimate
    level: str
    lowest: str
    highest: str


def daylight_hours(diffuse) -> np.ndarray:
    """Return the half of a year in which the sky gives most.

    Parameters
    ----------
    diffuse : (n,) array    Horizontal illuminance by the sky in every interval of a year. [lx]

    Returns
    -------
    (n,) bool array    Half of them; of equal ones the earlier.

    Raises
    ------
    SceneError    An hour has no illuminance, or there is not even one light one.
    """
    diffuse = np.asarray(diffuse, dtype=np.float64)
    missing = int(np.count_nonzero(~np.isfinite(diffuse)))
    if missing:
        raise SceneError(
            f"the weather has no diffuse illuminance in {missing} of {diffuse.size} hours, so the daylight hours of the "
            "year are unknown"
        )
    if not (diffuse > 0.0).any():
        raise SceneError("the sky of the weather gives no light in any hour")
    chosen = np.zeros(len(diffuse), dtype=bool)
    chosen[np.argsort(-diffuse, kind="stable")[: len(diffuse) // 2]] = True
    return chosen


def median_illuminance(diffuse) -> float:
    """Return the median of the sky's horizontal illuminance over the daylight hours, E_v,d,med. (n,) [lx -> lx]"""
    return float(np.median(np.asarray(diffuse, dtype=np.float64)[daylight_hours(diffuse)]))


def target_factors(median: float) -> np.ndarray:
    """Return the daylight factors that give the levels' illuminances under the median sky.

    Parameters
    ----------
    median : float    As of `median_illuminance`. [lx]

    Returns
    -------
    (3, 2) array    Of the target and of the least illuminance, by level. [-]
    """
    if not (np.isfinite(median) and median > 0.0):
        raise SceneError(f"the median illuminance by the sky is {median} lx, expected above 0")
    return np.array([(level.target, level.least) for level in LEVELS]) / median


def judge_factors(
    versions, median: float, freedom: float, areas=None, *, is_from_above: bool = False
) -> Provision:
    """Return the daylight provision by method 1.

    Parameters
    ----------
    versions : (1 + K, sensors) array    Daylight factors, as of `replicated.perturb` or `find_by_sensor`. [-]
    median : float    As of `median_illuminance`. [lx]
    freedom : float    As of `replicated.estimate`.
    areas : (sensors,) array or None    [m2]
    is_from_above : bool    Whether the openings are in the roof.
    """
    versions = np.asarray(versions, dtype=np.float64)
    bounds = target_factors(median)
    return _judge(versions[:, :, None, None] >= bounds, freedom, areas, is_from_above)


def autonomy_by_level(illuminance, hours) -> np.ndarray:
    """Share of the daylight hours in which sensors have the levels' illuminances, for `judge_illuminances`.

    Parameters
    ----------
    illuminance, hours    As of `metrics.select_hours`, the hours those of `daylight_hours`.

    Returns
    -------
    (sensors, 6) array    Target and least illuminance of each level. [-]
    """
    bounds = [bound for level in LEVELS for bound in (level.target, level.least)]
    shares = [metrics.count_at_least(illuminance, hours, bound) for bound in bounds]
    return np.stack(shares, axis=1)


def judge_illuminances(
    versions, freedom: float, areas=None, *, is_from_above: bool = False
) -> Provision:
    """Return the daylight provision by method 2.

    Parameters
    ----------
    versions : (1 + K, sensors, 6) array    `autonomy_by_level`, as `replicated.find_by_sensor` gives it. [-]
    freedom, areas, is_from_above    As of `judge_factors`.
    """
    versions = np.asarray(versions, dtype=np.float64)
    has = versions.reshape(*versions.shape[:2], len(LEVELS), 2) >= SHARE_OF_HOURS
    return _judge(has, freedom, areas, is_from_above)


def _judge(has: np.ndarray, freedom: float, areas, is_from_above: bool) -> Provision:
    """``has``: (1 + K, sensors, levels, target and least), whether a sensor has it."""
    _, areas = metrics.check_areas(np.zeros(has.shape[1]), areas)
    weights = areas / areas.sum()
    step = float(weights[weights > 0.0].min())
    target, least = (
        over_area(lambda version: weights @ version, has[..., i], freedom, step) for i in (0, 1)
    )
    shares = np.einsum("s,ksli->kli", weights, has)
    needed = (LEAST_AREA, 0.0) if is_from_above else (TARGET_AREA, LEAST_AREA)
    reached = (shares >= np.array(needed) - metrics.CLOSE).all(axis=2)
    # A level counts where those below it are reached too.
    counts = np.cumprod(reached, axis=1).sum(axis=1)
    names = [NONE, *(level.name for level in LEVELS)]
    return Provision(
        target, least, names[counts[0]], names[int(counts.min())], names[int(counts.max())]
    )


def check_date(day: date) -> None:
    """Refuse a day on which exposure to sunlight is not judged.

    Raises
    ------
    SceneError    It is not between 1 February and 21 March.
    """
    if not FIRST_DAY <= (day.month, day.day) <= LAST_DAY:
        raise SceneError(
            f"exposure to sunlight is judged on a day between 1 February and 21 March, found {day.isoformat()}"
        )


def exposure_level(hours: float) -> str:
    """Return the level of hours of sun on the day, `sunlight.day_hours` of a space's best point. [h]"""
    reached = [level.name for level in LEVELS if hours >= level.sunlight - 1e-9]
    return reached[-1] if reached else NONE
