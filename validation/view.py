"""The direction a set-up is looked at from, and where its points come to lie in the picture."""

from dataclasses import dataclass

import numpy as np

AZIMUTHS = (-60.0, -30.0, -120.0, -150.0, 30.0, 60.0, 120.0, 150.0)
"""From where one may look, from +x towards +y; earlier ones are preferred. [deg]"""

ELEVATIONS, COSTS = (26.0, 50.0, -26.0), (0.0, 0.15, 0.6)
"""From how high one may look [deg], and how much better it must show the sensors."""


@dataclass(frozen=True)
class View:
    """Parallel projection.

    Parameters
    ----------
    right, up, toward : (3,) array    Directions in the picture, and out of it towards the eye; unit length.
    scale : float    Pixels per metre.
    middle : (3,) array    Point that is drawn at ``place``. [m]
    place : (2,) array    [pixel]
    """

    right: np.ndarray
    up: np.ndarray
    toward: np.ndarray
    scale: float
    middle: np.ndarray
    place: np.ndarray

    def project(self, points) -> np.ndarray:
        """Places (..., 2) of points (..., 3). [pixel]"""
        away = (np.asarray(points, dtype=np.float64) - self.middle) * self.scale
        return self.place + np.stack([away @ self.right, -(away @ self.up)], axis=-1)

    def turn(self, directions) -> np.ndarray:
        """Directions (..., 3) in the picture, (..., 2)."""
        directions = np.asarray(directions, dtype=np.float64)
        return np.stack([directions @ self.right, -(directions @ self.up)], axis=-1)


def choose_view(points, sensors, normals, beams, low, high) -> View:
    """Look from where the sensors are seen best, and fit points into a window.

    Parameters
    ----------
    points : (n, 3) array    All that shall be inside the window. [m]
    sensors, normals : (m, 3) array    Normals may be NaN.
    beams : (k, 3) array    Directions of parallel light, unit length.
    low, high : (2,)    Corners of the window. [pixel]
    """
    ranked = {
        (azimuth, elevation): _score(_axes(azimuth, elevation), sensors, normals, beams)
        - 0.02 * i
        - COSTS[k]
        for i, azimuth in enumerate(AZIMUTHS)
        for k, elevation in enumerate(ELEVATIONS)
    }
    right, up, toward = _axes(*max(ranked, key=ranked.get))
    across, upwards = points @ right, points @ up
    low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    spans = np.array([np.ptp(across), np.ptp(upwards)])
    scale = float(np.min((high - low) / np.maximum(spans, 1e-12 + 1e-3 * spans.max())))
    centre = 0.5 * np.array([across.min() + across.max(), upwards.min() + upwards.max()])
    middle = centre[0] * right + centre[1] * up
    return View(right, up, toward, scale, middle, 0.5 * (low + high))


def _axes(azimuth: float, elevation: float):
    a, e = np.radians(azimuth), np.radians(elevation)
    toward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return right, np.cross(toward, right), toward


def _score(axes, sensors: np.ndarray, normals: np.ndarray, beams: np.ndarray) -> float:
    """Share of the sensors that face the eye, how well they are spread, and how little beams are foreshortened."""
    right, up, toward = axes
    aside = 0.6 * float(np.min(np.linalg.norm(np.cross(beams, toward), axis=1), initial=1.0))
    if not len(sensors):
        return aside
    facing = normals @ toward
    seen = np.mean(np.where(np.isnan(facing), 0.5, np.clip(0.5 + 1.5 * facing, 0.0, 1.0)))
    places = np.stack([sensors @ right, sensors @ up], axis=1)
    spread = np.linalg.norm(np.ptp(places, axis=0))
    span = np.linalg.norm(np.ptp(sensors, axis=0))
    return float(seen + 0.5 * (spread / span if span > 0.0 else 1.0)) + aside
