"""Cameras as pure data."""

from dataclasses import dataclass
from enum import Enum

import numpy as np


class Projection(Enum):
    """How directions map to the film."""

    PERSPECTIVE = "perspective"
    ORTHOGRAPHIC = "orthographic"
    EQUIRECTANGULAR = "equirectangular"


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera looking along its local -z with +y up (Blender's convention).

    Parameters
    ----------
    frame : (4, 4) float64 array    Rigid camera-to-world matrix. [m]
    projection : Projection
    width, height : int    Film size. [pixel]
    extent_x, extent_y : float
        Full film extent: at unit distance for perspective [-], in the plane for orthographic [m].
    shift_x, shift_y : float    Film shift in units of the extents' own measure (same unit as `extent_x`).
    aperture_radius : float    Thin lens; 0 is a pinhole. [m]
    focus_distance : float    Distance of the plane in focus, along the view axis. [m]
    clip_start : float    Nothing nearer along the view axis is seen. [m]
    longitude, latitude : (float, float)    Range of an equirectangular film. [rad]
    """

    frame: np.ndarray
    projection: Projection
    width: int
    height: int
    extent_x: float = 1.0
    extent_y: float = 1.0
    shift_x: float = 0.0
    shift_y: float = 0.0
    aperture_radius: float = 0.0
    focus_distance: float = 1.0
    clip_start: float = 0.0
    longitude: tuple[float, float] = (-np.pi, np.pi)
    latitude: tuple[float, float] = (-np.pi / 2, np.pi / 2)
