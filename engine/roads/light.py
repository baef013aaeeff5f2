"""What a road's luminaires give: luminances that a driver sees, illuminances, and the threshold increment.

Only light that comes straight from the luminaires counts, and the road's surface is a table, as the standard has it.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..luminaires.distribution import flux, intensity
from ..luminaires.formats.record import LUMINOUS, LuminaireFile
from .installation import DRIVER, EYE, FARTHEST, ROOF, Road
from .surface import RoadSurface

AGE = 23.0
"""Of the driver. [a] (EN 13201-3, 8.5)"""

DOWNWARDS = np.radians(1.0)
"""Slope of the line of sight below the horizontal. [rad]"""

LEAST_ANGLE, SMALL_ANGLE, LARGEST_ANGLE = 0.1, 1.5, 60.0
"""Angles to the line of sight [deg] within which luminaires dazzle, and below which another formula holds."""

BRIGHT = 5.0
"""Mean luminance from which another formula of the threshold increment holds. [cd/m2]"""

WEAKEST = 0.05
"""Mean luminance below which none holds. [cd/m2]"""


@dataclass(frozen=True, eq=False)
class DriverView:
    """What the driver in a lane sees.

    Parameters
    ----------
    luminances : (n, c) float64 array    By station and across. [cd/m2]
    mean : float    [cd/m2]
    overall : float    Least over mean of all points, Uo. [-]
    longitudinal : float    Least over largest along the middle of the lane, Ul. [-]
    veiling : float    Largest equivalent veiling luminance with new lamps. [cd/m2]
    increment : float    Largest threshold increment. [%] NaN where the mean luminance is too small for it to be defined.
    """

    luminances: np.ndarray
    mean: float
    overall: float
    longitudinal: float
    veiling: float
    increment: float


@dataclass(frozen=True, eq=False)
class RoadLight:
    """Lighting of a road.

    Parameters
    ----------
    views : tuple of DriverView    By lane, from the right.
    illuminances : (n, c) float64 array    Horizontal, by station and across. [lx]
    edge_ratios : (float, float)    Edge illuminance ratios at the right and the left. [-]
    """

    views: tuple[DriverView, ...]
    illuminances: np.ndarray
    edge_ratios: tuple[float, float]

    @property
    def mean(self) -> float:
        """Least mean luminance of all drivers. [cd/m2]"""
        return min(view.mean for view in self.views)

    @property
    def overall(self) -> float:
        """Least overall uniformity Uo of all drivers. [-]"""
        return min(view.overall for view in self.views)

    @property
    def longitudinal(self) -> float:
        """Least longitudinal uniformity Ul of all drivers. [-]"""
        return min(view.longitudinal for view in self.views)

    @property
    def increment(self) -> float:
        """Largest threshold increment of all drivers; NaN where it is not defined for one. [%]"""
        return float(np.max([view.increment for view in self.views]))

    @property
    def edge_ratio(self) -> float:
        """Lower of the edge illuminance ratios EIR. [-]"""
        return min(self.edge_ratios)


def light_road(
    file: LuminaireFile, road: Road, surface: RoadSurface, maintenance: float = 1.0
) -> RoadLight:
    """Compute the lighting of a road.

    Parameters
    ----------
    file : LuminaireFile    Of every luminaire, with the flux of the file.
    road : Road
    surface : RoadSurface
    maintenance : float    Factor on all light but that of the threshold increment, which is of new lamps. [-]

    Raises
    ------
    SceneError    The file holds no candelas or no light, or none of it comes to the road.

    References
    ----------
    EN 13201-3:2015, 7 and 8; CIE 140:2000, 5 and 6
    """
    if file.quantity != LUMINOUS:
        raise SceneError("the file states W/sr, but road lighting is computed from candelas")
    if not flux(file.distribution) > 0.0:
        raise SceneError("the luminaire gives no light")
    lamps = _Luminaires(file, *road.luminaires())
    points = road.grid()
    illuminances = maintenance * lamps.illuminances(points)
    if not illuminances.min() > 0.0:
        raise SceneError("a point of the road gets no light at all, so there are no uniformities")
    strip = road.lane_width
    edges = tuple(
        float(lamps.illuminances(road.grid(*out, 3)).mean() / lamps.illuminances(road.grid(*into, 3)).mean())
        for out, into in (
            ((-strip, 0.0), (0.0, strip)),
            ((road.width, road.width + strip), (road.width - strip, road.width)),
        )
    )  # fmt: skip
    views = tuple(
        _look(lamps, road, surface, lane, points, maintenance) for lane in range(road.lanes)
    )
    return RoadLight(views, illuminances, edges)


def veiling_of(illuminance, angle) -> np.ndarray:
    """Equivalent veiling luminance of sources. [cd/m2]

    Parameters
    ----------
    illuminance : array    At the eye, on a plane at right angles to the line of sight. [lx]
    angle : array    Between the line of sight and the source. [deg] Beyond `LEAST_ANGLE` and `LARGEST_ANGLE`: 0.

    References
    ----------
    EN 13201-3:2015, 8.5; CIE 146:2002, Equations for disability glare
    """
    illuminance, angle = np.broadcast_arrays(
        np.asarray(illuminance, float), np.asarray(angle, float)
    )
    safe = np.maximum(angle, LEAST_ANGLE)
    wide = 9.86 / safe**2 * (1.0 + (AGE / 66.4) ** 4)
    narrow = 10.0 / safe**3 + 5.0 / safe**2 * (1.0 + (AGE / 62.5) ** 4)
    factor = np.where(angle > SMALL_ANGLE, wide, narrow)
    return np.where((angle >= LEAST_ANGLE) & (angle <= LARGEST_ANGLE), factor * illuminance, 0.0)


def threshold_increment(veiling: float, mean: float) -> float:
    """Threshold increment by veiling and mean luminance [cd/m2]; NaN where the mean is below `WEAKEST`. [%]"""
    if mean <= WEAKEST:
        return float("nan")
    if mean > BRIGHT:
        return 95.0 * veiling / mean**1.05
    return 65.0 * veiling / mean**0.8


class _Luminaires:
    """Luminaires of a road, asked for their light."""

    def __init__(self, file: LuminaireFile, places: np.ndarray, axes: np.ndarray):
        self._distribution, self._axes = file.distribution, axes
        self.places = places

    def intensities(self, points: np.ndarray) -> np.ndarray:
        """Of every luminaire towards points (m, 3). (k, m) [cd]"""
        away = points[None] - self.places[:, None]
        return intensity(self._distribution, np.einsum("kmi,kij->kmj", away, self._axes))

    def illuminances(self, points: np.ndarray) -> np.ndarray:
        """Horizontal, at points (..., 3) of the road. (...) [lx]"""
        flat = points.reshape(-1, 3)
        away = flat[None] - self.places[:, None]
        squared = (away**2).sum(axis=-1)
        cosine = -away[..., 2] / np.sqrt(squared)
        total = (self.intensities(flat) * cosine / squared).sum(axis=0)
        return total.reshape(points.shape[:-1])

    def luminances(self, points: np.ndarray, eye: np.ndarray, surface: RoadSurface) -> np.ndarray:
        """Luminances of points (..., 3) of the road as an eye sees them. (...) [cd/m2]"""
        flat = points.reshape(-1, 3)
        away = self.places[:, None, :2] - flat[None, :, :2]
        heights = self.places[:, None, 2]
        tangent = np.hypot(away[..., 0], away[..., 1]) / heights
        # beta is 0 where the luminaire stands straight behind the point, as the driver sees it.
        sight = flat[:, :2] - eye[:2]
        turn = np.arctan2(away[..., 1], away[..., 0]) - np.arctan2(sight[:, 1], sight[:, 0])
        angle = np.degrees(np.arccos(np.clip(np.cos(turn), -1.0, 1.0)))
        given = self.intensities(flat) * surface.reduced_coefficient(tangent, angle) / heights**2
        return given.sum(axis=0).reshape(points.shape[:-1])

    def veiling(self, eye: np.ndarray) -> float:
        """Equivalent veiling luminance for a driver's eye at a place. (3,) [cd/m2]"""
        away = self.places - eye
        distance = np.linalg.norm(away, axis=1)
        cosine = (away[:, 0] * np.cos(DOWNWARDS) - away[:, 2] * np.sin(DOWNWARDS)) / distance
        is_seen = (away[:, 0] > 0.0) & (away[:, 2] <= away[:, 0] * np.tan(ROOF) * (1.0 + 1e-9))
        is_seen &= distance <= FARTHEST
        at_eye = self.intensities(eye[None])[:, 0] * np.maximum(cosine, 0.0) / distance**2
        angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        return float(veiling_of(at_eye, angle)[is_seen].sum())


def _look(lamps, road: Road, surface, lane: int, points, maintenance: float) -> DriverView:
    """What the driver in a lane sees."""
    middle = float(road.lane_middles[lane])
    eye = np.array([-DRIVER, middle, EYE])
    # New, as the threshold increment has it.
    new = lamps.luminances(points, eye, surface)
    if not new.min() > 0.0:
        raise SceneError(
            "a point of the road looks black to a driver, so there are no uniformities"
        )
    stations = road.stations
    line = np.column_stack([stations, np.full_like(stations, middle), np.zeros_like(stations)])
    along = lamps.luminances(line, eye, surface)
    start = -(road.height - EYE) / np.tan(ROOF)
    steps = stations - stations[0]
    veiling = max(lamps.veiling(np.array([start + step, middle, EYE])) for step in steps)
    mean = float(new.mean())
    return DriverView(
        maintenance * new,
        maintenance * mean,
        float(new.min() / mean),
        float(along.min() / along.max()),
        veiling,
        threshold_increment(veiling, mean),
    )
