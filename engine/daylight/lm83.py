"""Spatial daylight autonomy and annual sunlight exposure, with the blinds that the method closes (IES LM-83-12).

Hours are those from 8 to 18 h by the clocks of the place, daylight saving time with them, on every day: 3650 of a year
(`occupancy.occupied_hours`). Spatial daylight autonomy (sDA 300/50 %) is the share of the area that has 300 lx in at least
half of these hours, blinds in use. Annual sunlight exposure (ASE 1000, 250 h) is the share of the area that the sun alone,
without a reflection, lights with more than 1000 lx for more than 250 of these hours, blinds open.

Blinds belong to groups of windows: windows in one plane with the same shading. In each hour those of a group are closed
where the sun through it lights more than 2 % of the area with more than 1000 lx.

The edition of 2023 (ANSI/IES LM-83-22) is not followed where it differs.

References
----------
IES LM-83-12, Approved method: IES spatial daylight autonomy (sDA) and annual sunlight exposure (ASE), 2.2 and 3.2
"""

import numpy as np

from ..errors import SceneError
from . import metrics

TARGET, SHARE_OF_HOURS = 300.0, 0.5
"""Illuminance [lx] that a sensor needs, and the share of the hours [-] in which it has to have it."""

SUNLIGHT, SUNLIT_HOURS = 1000.0, 250.0
"""Illuminance by the sun alone [lx] that is too much, and for how long [h]."""

TRIGGER = 0.02
"""Share of the area in sunlight above which blinds are closed. [-]"""


class SunlitAreas:
    """Share of an area that the sun lights through each group of windows, hour by hour, added up block by block of sensors.

    Parameters
    ----------
    groups, hours : int
    bound : float    Illuminance by the sun alone above which a sensor is in sunlight. [lx]
    """

    def __init__(self, groups: int, hours: int, bound: float = SUNLIGHT):
        self.bound = bound
        self._lit = np.zeros((groups, hours))
        self._area = 0.0

    def add(self, direct, areas=None) -> None:
        """Add sensors.

        Parameters
        ----------
        direct : (groups, sensors, hours) array    Illuminance by the sun through each group, blinds open, without
            reflections. [lx]
        areas : (sensors,) array or None    That they stand for; None: 1 each. [m2]

        Raises
        ------
        SceneError    The shapes do not fit, or an illuminance is missing.
        """
        direct = np.asarray(direct)
        if direct.ndim != 3 or (len(direct), direct.shape[2]) != self._lit.shape:
            raise SceneError(
                f"sunlight of the shape {direct.shape} does not fit {self._lit.shape[0]} groups of windows and "
                f"{self._lit.shape[1]} hours"
            )
        if not np.isfinite(direct).all():
            raise SceneError("an illuminance by the sun is missing")
        _, areas = metrics.check_areas(np.zeros(direct.shape[1]), areas)
        self._lit += np.einsum("gsh,s->gh", direct > self.bound, areas)
        self._area += float(areas.sum())

    @property
    def shares(self) -> np.ndarray:
        """Of the area. (groups, hours) [-]"""
        if self._area <= 0.0:
            raise SceneError("there is no area whose sunlight could close blinds")
        return self._lit / self._area


def close_blinds(shares, trigger: float = TRIGGER) -> np.ndarray:
    """Return when the blinds of each group of windows are closed.

    Parameters
    ----------
    shares : (groups, hours) array    Share of the area in sunlight through each group. [-]
    trigger : float    Share above which they are closed. [-]

    Returns
    -------
    (groups, hours) bool array
    """
    return np.asarray(shares) > trigger + metrics.CLOSE


def combine_groups(with_open, with_closed, is_closed) -> np.ndarray:
    """Return the illuminances with the blinds of each hour.

    Parameters
    ----------
    with_open, with_closed : (groups, sensors, hours) arrays    What comes in through each group, with its blinds open and
        closed. [lx]
    is_closed : (groups, hours) bool array

    Returns
    -------
    (sensors, hours) array    [lx]
    """
    with_open, with_closed = np.asarray(with_open), np.asarray(with_closed)
    is_closed = np.asarray(is_closed, dtype=bool)
    if with_open.shape != with_closed.shape or is_closed.shape != with_open.shape[::2]:
        raise SceneError(
            f"illuminances of the shapes {with_open.shape} and {with_closed.shape} do not fit the states of "
            f"{is_closed.shape} groups and hours"
        )
    return np.where(is_closed[:, None], with_closed, with_open).sum(axis=0)


def spatial_autonomy(autonomy, areas=None, share: float = SHARE_OF_HOURS) -> float:
    """Share of the area whose sensors have their target in a share of the hours.

    Parameters
    ----------
    autonomy : (sensors,) array    `metrics.daylight_autonomy` for `TARGET`, blinds in use. [-]
    areas : (sensors,) array or None    [m2]
    share : float    [-]

    Returns
    -------
    float    [-]
    """
    return metrics.area_share(autonomy, share, areas)


def sunlit_hours(direct, hours) -> np.ndarray:
    """Time in which sensors have too much sunlight; ``direct``: (sensors, hours), blinds open. (sensors,) [lx -> h]"""
    return metrics.hours_above(direct, hours, SUNLIGHT)


def sunlight_exposure(sunlit, areas=None) -> float:
    """Share of the area with too much sunlight for too long, from `sunlit_hours`. (sensors,) [h -> -]"""
    return metrics.area_share_above(sunlit, SUNLIT_HOURS, areas)
