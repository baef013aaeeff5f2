"""Directions of a sky and angles between them, as Blender's Sky Texture has them."""

import numpy as np


def towards(elevation: float, rotation: float) -> np.ndarray:
    """Return the unit vector to a sun at an elevation, turned clockwise from +y about the vertical. [rad] -> (3,)"""
    plan = np.cos(elevation)
    return np.array([plan * np.sin(rotation), plan * np.cos(rotation), np.sin(elevation)])


def wrap(elevation: float, rotation: float) -> tuple[float, float]:
    """Return the same direction with an elevation within a quarter of a turn and a rotation within 0 and a turn. [rad]"""
    elevation = float(np.arctan2(np.sin(elevation), np.cos(elevation)))
    if abs(elevation) > 0.5 * np.pi:
        elevation, rotation = np.copysign(np.pi, elevation) - elevation, rotation + np.pi
    return float(elevation), float(rotation % (2.0 * np.pi))


def onto_sphere(vectors) -> np.ndarray:
    """Return unit vectors of the same azimuth whose height is the vector's z, as Blender takes vectors of any length.

    Parameters
    ----------
    vectors : (..., 3) array

    Returns
    -------
    (..., 3) float64 array
    """
    vectors = np.asarray(vectors, dtype=np.float64)
    height = np.clip(vectors[..., 2], -1.0, 1.0)
    azimuth = np.arctan2(vectors[..., 1], vectors[..., 0])
    plan = np.sqrt(1.0 - height**2)
    return np.stack([plan * np.cos(azimuth), plan * np.sin(azimuth), height], axis=-1)


def elevations(directions) -> np.ndarray:
    """Elevation of unit vectors. (..., 3) -> (...) [rad]"""
    return 0.5 * np.pi - np.arccos(np.clip(directions[..., 2], -1.0, 1.0))


def angle_to(directions, towards_sun) -> np.ndarray:
    """Angle between unit vectors and a sun, exact next to it too. (..., 3), (3,) -> (...) [rad]"""
    apart = np.linalg.norm(directions - towards_sun, axis=-1)
    return 2.0 * np.arctan2(apart, np.linalg.norm(directions + towards_sun, axis=-1))
