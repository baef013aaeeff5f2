"""Cameras as pure data."""

from dataclasses import dataclass
from enum import Enum

import numpy as np


class Projection(Enum):
    """How directions map to the film."""

    PERSPECTIVE = "perspective"
    ORTHOGRAPHIC = "orthographic"
    EQUIRECTANGULAR = "equirectangular"
    CENTRAL_CYLINDRICAL = "central cylindrical"
    CUBE_FACE = "cube face"
    EQUIDISTANT = "equidistant fisheye"
    EQUISOLID = "equisolid fisheye"
    POLYNOMIAL = "polynomial fisheye"
    MIRROR_BALL = "mirror ball"

    @property
    def is_panoramic(self) -> bool:
        """Whether rays go out from one point all around, and distances count from there."""
        return self not in (Projection.PERSPECTIVE, Projection.ORTHOGRAPHIC)


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera looking along its local -z with +y up (Blender's convention).

    Parameters
    ----------
    frame : (4, 4) float64 array    Rigid camera-to-world matrix. [m]
    projection : Projection
    width, height : int    Film size. [pixel]
    extent_x, extent_y : float
        Full film extent: at unit distance for perspective [-], in the plane for orthographic [m], longitude and
        latitude for equirectangular [rad], longitude [rad] and tangent of the latitude [-] for cylinders, angles for cube
        faces and equidistant [rad], over the focal length for equisolid [-], in the measure of the polynomial, over the
        radius of the mirror ball [-].
    shift_x, shift_y : float    Film shift in units of the extents' own measure (same unit as `extent_x`).
    aperture_radius : float    Thin lens; 0 is a pinhole. Of a polygon that of its corners. [m]
    aperture_blades : int    Sides of the aperture; fewer than three: it is round.
    aperture_rotation : float    Of the middle of one of its sides against +x. [rad]
    aperture_ratio : float    Height of the aperture over its width, which it is made narrower by. [-]
    focus_distance : float    Distance of what is in focus, along the view axis, of panoramas all around. [m]
    clip_start, clip_end : float
        Nothing nearer and nothing farther is seen, along the view axis, of panoramas all around; None: no end. [m]
    field : float    Full angle of what a fisheye sees. [rad]
    polynomial : (float, ...)
        Coefficients of the powers 0 to 4 of the distance from the film's centre, whose negative sum is the angle to the
        view axis. [rad]
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
    aperture_blades: int = 0
    aperture_rotation: float = 0.0
    aperture_ratio: float = 1.0
    focus_distance: float = 1.0
    clip_start: float = 0.0
    clip_end: float | None = None
    field: float = 2.0 * np.pi
    polynomial: tuple[float, ...] = (0.0, -1.0, 0.0, 0.0, 0.0)
