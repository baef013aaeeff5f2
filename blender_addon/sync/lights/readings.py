"""One light in all photometric quantities."""

from dataclasses import dataclass

import numpy as np

from ....engine.photometry import units


@dataclass(frozen=True)
class Reading:
    """One light in all units; None where a quantity has no meaning for it.

    Parameters
    ----------
    flux : float or None    Total emitted. [lm]
    intensity : float or None    On the axis. [cd]
    illuminance : float or None    At 1 m on the axis by the inverse-square law; of a sun, facing it. [lx]
    luminance : float or None    Of the luminous surface, on the axis. [cd/m2]
    """

    flux: float | None = None
    intensity: float | None = None
    illuminance: float | None = None
    luminance: float | None = None


def read_point(quantity: str, value: float, radius: float = 0.0) -> Reading:
    """All quantities of a point or a uniform sphere.

    Parameters
    ----------
    quantity : str    LUMINOUS_FLUX [lm], LUMINOUS_INTENSITY [cd], ILLUMINANCE [lx at 1 m] or LUMINANCE [cd/m2].
    value : float    Its amount.
    radius : float    0 is a point. [m]
    """
    per_lumen = units.intensity_from_flux_isotropic(1.0)
    per_candela = units.luminance_from_intensity_sphere(1.0, radius) if radius > 0.0 else None
    if quantity == "LUMINOUS_FLUX":
        intensity = value * per_lumen
    elif quantity == "LUMINANCE":
        intensity = value / per_candela if per_candela else 0.0
    else:
        intensity = value
    surface = intensity * per_candela if per_candela else None
    return Reading(intensity / per_lumen, intensity, intensity, surface)


def read_spot(quantity: str, value: float, half_angle: float, blend: float) -> Reading:
    """All quantities of a spot. ``half_angle`` [rad]; ``blend``: share of the soft edge. [-]"""
    solid_angle = units.spot_solid_angle(half_angle, blend)
    intensity = value / solid_angle if quantity == "LUMINOUS_FLUX" else value
    return Reading(intensity * solid_angle, intensity, intensity)


def read_area(quantity: str, value: float, area: float, spread: float = np.pi) -> Reading:
    """All quantities of a flat one-sided source. ``area`` [m2]; ``spread``: Blender's, pi is Lambertian. [rad]"""
    per_lumen = units.luminance_from_flux_lambertian(1.0, area) * units.spread_axis_factor(spread)
    if quantity == "LUMINOUS_FLUX":
        surface = value * per_lumen
    elif quantity == "LUMINANCE":
        surface = value
    else:
        surface = value / area
    return Reading(surface / per_lumen, surface * area, surface * area, surface)


def read_line(quantity: str, value: float, length: float, radius: float) -> Reading:
    """All quantities of a tube, whose axis for intensities is across it. ``length``, ``radius``: above 0 [m]."""
    per_lumen = units.luminance_from_flux_lambertian(1.0, 2.0 * np.pi * radius * length)
    seen = 2.0 * radius * length
    if quantity == "LUMINOUS_FLUX":
        surface = value * per_lumen
    else:
        surface = value if quantity == "LUMINANCE" else value / seen
    return Reading(surface / per_lumen, surface * seen, surface * seen, surface)


def read_sun(quantity: str, value: float, angle: float) -> Reading:
    """All quantities of a sun. ``angle``: angular diameter. [rad]"""
    per_lux = units.luminance_from_illuminance_disk(1.0, 0.5 * angle) if angle > 0.0 else None
    if quantity == "LUMINANCE":
        return Reading(illuminance=value / per_lux if per_lux else 0.0, luminance=value)
    return Reading(illuminance=value, luminance=value * per_lux if per_lux else None)
