"""Weather of a year in the terms of daylight coefficients: luminances of the sky's nodes and the sun, hour by hour."""

from dataclasses import dataclass

import numpy as np

from ..reading.remarks import Remark
from ..sky.hour import find_daylight_hours
from ..sky.nodes import Projection, find_projection
from ..sky.perez import LOWEST, coefficients
from ..sky.weather import Weather, WeatherHours, find_hours, find_middles

HOURS = 256
"""Hours of which skies are evaluated at a time."""

SHARE_OF_DOUBT = 0.5
"""What a sky's values at nodes may be off by, relative to their difference from means around the nodes. [-]"""

GROUND_REFLECTANCE = 0.2
"""Of the ground around, below the horizon: grass and earth. [-]"""


@dataclass(frozen=True, eq=False)
class Year:
    """Light of the hours of a weather file that have any.

    ``h`` lit hours of ``n`` records, ``k`` of them with a sun.

    Parameters
    ----------
    weather : Weather
    hours : WeatherHours
    lit : (h,) int array    Their records.
    sky : (h, nodes + 1) float32 array    Luminances of the nodes, and of the ground last. [cd/m2]
    doubt : (h, nodes + 1) float32 array    By how much they may be off. [cd/m2]
    direct_normal : (h,) array    Illuminance by the sun of a plane that faces it. [lx]
    diffuse_horizontal : (h,) array    Illuminance of an unobstructed horizontal plane by the sky. [lx]
    sun : (h,) int array    Which of ``suns`` it is, -1: none.
    suns : (k, 3) array    Unit vectors in the scene.
    steps : int    Rows of the sky.
    calendar : int or None    Year in which the records were taken; None: each in its own.
    remarks : tuple of Remark
    """

    weather: Weather
    hours: WeatherHours
    lit: np.ndarray
    sky: np.ndarray
    doubt: np.ndarray
    direct_normal: np.ndarray
    diffuse_horizontal: np.ndarray
    sun: np.ndarray
    suns: np.ndarray
    steps: int
    calendar: int | None
    remarks: tuple[Remark, ...]

    @property
    def count(self) -> int:
        """Records of the weather."""
        return len(self.weather)

    @property
    def middles(self) -> np.ndarray:
        """Middles of the records' intervals, universal time since 1970. (n,) [s]"""
        return find_middles(self.weather, self.calendar)


def make_year(
    weather: Weather,
    north: float | None = None,
    ground_reflectance: float = GROUND_REFLECTANCE,
    steps: int = 15,
    year: int | None = None,
) -> Year:
    """Return the light of a weather file's hours.

    Parameters
    ----------
    weather : Weather
    north : float or None    Compass direction of the scene's +y axis, as of `Place`; None: that of the weather's place.
        [degree]
    ground_reflectance : float    Every direction below the horizon is as bright as a matt ground of this reflectance under
        sun and sky. [-]
    steps : int    Rows of the sky, as of `SkyNodes`.
    year : int or None    As of `find_hours`.
    """
    north = weather.place.north if north is None else north
    hours = find_hours(weather, year)
    daylight = find_daylight_hours(weather, hours)
    direct = np.nan_to_num(daylight.direct_normal)
    diffuse = np.nan_to_num(daylight.diffuse_horizontal)
    missing = int(np.isnan(daylight.diffuse_horizontal).sum())
    lit = np.flatnonzero((direct > 0.0) | (diffuse > 0.0))
    towards = np.asarray(hours.sun.directions(north))[lit]
    has_sun = direct[lit] > 0.0
    sun = np.where(has_sun, np.cumsum(has_sun) - 1, -1)
    projection = find_projection(steps)
    level = np.stack([*towards[:, :2].T, np.maximum(towards[:, 2], 0.0)], axis=1)
    level /= np.linalg.norm(level, axis=1, keepdims=True)
    nodes = len(projection.node_areas)
    sky, doubt = (np.zeros((len(lit), nodes + 1), dtype=np.float32) for _ in range(2))
    zenith = np.arccos(np.clip(level[:, 2], 0.0, 1.0))
    clearness = np.maximum(daylight.clearness[lit], 1.0)
    patterns = np.stack(coefficients(clearness, daylight.brightness[lit], zenith))
    for first in range(0, len(lit), HOURS):
        part = slice(first, first + HOURS)
        found = _skies(projection, patterns[:, part], level[part], diffuse[lit][part])
        sky[part, :nodes], doubt[part, :nodes] = found
    beam = direct[lit] * np.maximum(towards[:, 2], 0.0)
    sky[:, nodes] = ground_reflectance / np.pi * (diffuse[lit] + beam)
    remarks = (*weather.remarks, *hours.remarks)
    if missing:
        remarks += (Remark(f"{missing} hours have no irradiance and count as dark"),)
    return Year(
        weather,
        hours,
        lit,
        sky,
        doubt,
        direct[lit],
        diffuse[lit],
        sun,
        towards[has_sun],
        steps,
        year,
        remarks,
    )


def _skies(projection: Projection, numbers, towards, illuminance):
    """Luminances of nodes and their doubt, of some hours. (h, nodes) each [cd/m2]"""
    directions = projection.directions.astype(np.float32)
    a, b, c, d, e = (x.astype(np.float32)[:, None] for x in numbers)
    cosine = np.clip(towards.astype(np.float32) @ directions.T, -1.0, 1.0)
    # Single precision loses an angle next to the sun, but not more than its disk is wide.
    angle = np.arccos(cosine)
    gradation = 1.0 + a * np.exp(b / np.maximum(directions[:, 2], np.float32(LOWEST)))
    value = gradation * (1.0 + c * np.exp(d * angle) + e * cosine**2)
    value = np.maximum(value, 0.0)
    # The same directions for level and shape: what they do not resolve next to the sun is not lost, but spread.
    own = value @ (projection.areas * projection.directions[:, 2]).astype(np.float32)
    value *= (illuminance / np.maximum(own, 1e-30)).astype(np.float32)[:, None]
    best, means = projection.project(value)
    return best, SHARE_OF_DOUBT * (best - means)
