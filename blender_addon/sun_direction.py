"""Directions towards a sun, as vectors and as angles."""

import math

import numpy as np

UPWARDS = np.array([0.0, 0.0, 1.0])
"""Towards the zenith."""


def towards_lamp(matrix) -> np.ndarray | None:
    """Return the unit vector to where a light with this world matrix shines from, None if it is squeezed flat. (3,)"""
    axis = np.array(matrix, dtype=np.float64)[:3, 2]
    length = np.linalg.norm(axis)
    return axis / length if length > 0.0 else None


def onto_horizon(towards_sun: np.ndarray) -> np.ndarray:
    """Lift a direction that points below the horizon up to it; straight below is north. (3,)"""
    if towards_sun[2] >= 0.0:
        return towards_sun
    length = np.hypot(towards_sun[0], towards_sun[1])
    if length < 1e-6:
        return np.array([0.0, 1.0, 0.0])
    return np.array([towards_sun[0] / length, towards_sun[1] / length, 0.0])


def angles(towards_sun: np.ndarray) -> tuple[float, float]:
    """Elevation, and azimuth from +y (north) towards +x (east), 0 to 2 pi, of a unit vector. [rad]"""
    x, y, z = (float(value) for value in towards_sun)
    return math.asin(min(max(z, -1.0), 1.0)), math.atan2(x, y) % (2.0 * math.pi)
