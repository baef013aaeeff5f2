"""A sky computed by scattering with the disk of its sun, by the direction."""

from dataclasses import dataclass, replace

import numpy as np

from ...photometry.colour import XYZ_TO_REC709
from . import multiple_scattering, single_scattering
from .directions import angle_to, elevations, towards, wrap
from .table import columns_of, look_up, rows_of

NISHITA, SINGLE, MULTIPLE = "NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING"
"""Models by Blender's names: scattered once as before version 5 and since then, and scattered many times."""

LEAST_SUN = 0.0005
"""Angular diameter that a smaller sun is taken to have. [rad]"""

LIMB = 0.6
"""Darkening at the sun's limb. [-]"""


@dataclass(frozen=True)
class ScatteredSky:
    """Settings of a sky.

    Parameters
    ----------
    model : str    `NISHITA`, `SINGLE` or `MULTIPLE`.
    elevation, rotation : float    Of the sun; turned clockwise from +y. [rad]
    altitude : float    Of the eye above sea level. [m]
    air, dust, ozone : float    Densities relative to a usual atmosphere. [-]
    sun_size : float    Angular diameter of the sun. [rad]
    sun_intensity : float    What its disk is multiplied with. [-]
    """

    model: str
    elevation: float
    rotation: float
    altitude: float
    air: float
    dust: float
    ozone: float
    sun_size: float = 0.0
    sun_intensity: float = 0.0

    @property
    def towards_sun(self) -> np.ndarray:
        """Unit vector to the sun. (3,)"""
        return towards(*wrap(self.elevation, self.rotation))

    @property
    def sun_angle(self) -> float:
        """Angular diameter of the disk. [rad]"""
        return max(self.sun_size, LEAST_SUN)

    @property
    def _air(self) -> tuple[float, ...]:
        return self.altitude, self.air, self.dust, self.ozone


def find_colours(sky: ScatteredSky, directions, shows_sun: bool = False) -> np.ndarray:
    """Return linear Rec. 709 components as Blender has them, where 1 stands for 1 W/(m2 sr).

    Parameters
    ----------
    sky : ScatteredSky
    directions : (..., 3) array    Unit vectors.
    shows_sun : bool    Whether the sun's disk is there.

    Returns
    -------
    (..., 3) float64 array    Not below 0.
    """
    elevation, rotation = wrap(sky.elevation, sky.rotation)
    sky = replace(sky, elevation=elevation, rotation=rotation)
    light = _find_sky(sky, directions)
    if shows_sun:
        disk, is_in_it = _find_disk(sky, directions)
        # Before version 5 the disk stood in the sky's place.
        light = np.where(is_in_it[..., None], 0.0, light) if sky.model == NISHITA else light
        light = light + disk
    return np.maximum(light @ XYZ_TO_REC709.T, 0.0)


def _find_sky(sky: ScatteredSky, directions) -> np.ndarray:
    u, v = columns_of(directions, sky.towards_sun), rows_of(directions)
    if sky.model == MULTIPLE:
        return look_up(multiple_scattering.make_table(sky.elevation, *sky._air), u, v)
    is_early = sky.model == NISHITA
    light = look_up(single_scattering.make_table(sky.elevation, *sky._air, is_early), u, v)
    if is_early:
        light = light * single_scattering.fade(np.minimum(directions[..., 2], 0.0))[..., None]
    return light


def _find_disk(sky: ScatteredSky, directions) -> tuple[np.ndarray, np.ndarray]:
    """Return the disk's light, 0 elsewhere (..., 3), and where it is (...)."""
    half = 0.5 * sky.sun_angle
    angle, height = angle_to(directions, sky.towards_sun), elevations(directions)
    is_early = sky.model == NISHITA
    lowest = 0.0 if is_early else -_horizon_dip(sky.altitude)
    is_in_it = (angle < half) & ((height >= 0.0) if is_early else (height > lowest))
    bottom, top = (_find_sun(sky, sky.elevation + side * half) for side in (-1.0, 1.0))
    place = (height - sky.elevation) / sky.sun_angle + 0.5
    upper = sky.elevation + half
    if is_early and sky.elevation <= half:
        place = height / upper if upper > 0.0 else np.zeros_like(height)
        top = top if upper > 0.0 else np.zeros(3)
        bottom = bottom if upper > 0.0 else np.zeros(3)
    cosine = np.sqrt(np.maximum(1.0 - (angle / half) ** 2, 0.0))
    light = bottom + (top - bottom) * place[..., None]
    light = light * (sky.sun_intensity * (1.0 - LIMB * (1.0 - cosine)))[..., None]
    return np.where(is_in_it[..., None], light, 0.0), is_in_it


def _find_sun(sky: ScatteredSky, elevation: float) -> np.ndarray:
    """X, Y, Z of a sun that shines through the air from an elevation. (3,)"""
    # The brightness of small suns in Blender depends on the few digits that its single precision leaves here.
    solid_angle = 2.0 * np.pi * float(np.float32(1.0) - np.cos(np.float32(0.5 * sky.sun_angle)))
    if sky.model == MULTIPLE:
        passed = multiple_scattering.sun_transmittance(elevation, *sky._air)
        return multiple_scattering.IRRADIANCE * passed @ multiple_scattering.TO_XYZ / solid_angle
    return single_scattering.sun_light(elevation, *sky._air[:3]) / solid_angle


def _horizon_dip(altitude: float) -> float:
    """How far below the level the horizon lies. [m] -> [rad]"""
    earth = multiple_scattering.EARTH
    return 0.5 * np.pi - float(np.arcsin(earth / (earth + altitude / 1000.0)))
