"""Conversions between photometric and radiometric quantities. The only place where these factors stand."""

from ...imports import loaded_when_used

with loaded_when_used():
    import numpy as np

LUMINOUS_EFFICACY = 683.002
"""K_m, maximum luminous efficacy of radiation for V(lambda). [lm/W] (CIE S 025, BIPM 2019: 683 at 540 THz, /V there)"""

BLENDER_EFFICACY = 177.83
"""Luminous efficacy that Cycles assumes for its own watts (D65). [lm/W]"""

RADIANCE_EFFICACY = 179.0
"""Luminous efficacy by which Radiance turns its pictures' values, in W/(m2 sr), into luminances. [lm/W]"""

MINIMUM_WAVELENGTH = 360.0
"""Shortest wavelength carried. [nm]"""

MAXIMUM_WAVELENGTH = 830.0
"""Longest wavelength carried. [nm]"""

VISIBLE = (380.0, 780.0)
"""Where ultraviolet ends and infrared begins. [nm] (CIE S 017)"""

EV100_LUMINANCE = 1.2
"""Luminance that saturates at EV100 = 0. [cd/m2] (ISO 12232:2019, saturation-based speed, with q = 0.65)"""


def intensity_from_flux_isotropic(flux):
    """Intensity of a source that emits alike in all directions: I = flux / (4 pi). [lm -> cd]"""
    return flux / (4.0 * np.pi)


def luminance_from_intensity_sphere(intensity, radius):
    """Luminance of a uniform sphere seen with the given intensity: I = L pi r^2. [cd, m -> cd/m2]"""
    return intensity / (np.pi * radius**2)


def luminance_from_flux_lambertian(flux, area):
    """Luminance of a one-sided Lambertian face: flux = pi L A. [lm, m2 -> cd/m2]"""
    return flux / (np.pi * area)


def luminance_from_illuminance_disk(illuminance, half_angle):
    """Luminance of a disk of given angular radius from E on a plane facing it: E = pi L sin^2. [lx, rad -> cd/m2]"""
    return illuminance / (np.pi * np.sin(half_angle) ** 2)


def luminance_from_ev100(ev100):
    """Luminance that becomes 1.0 at an exposure value for ISO 100. [- -> cd/m2]"""
    return EV100_LUMINANCE * np.exp2(ev100)


def spot_solid_angle(half_angle, blend):
    """Solid angle of a spot weighted by its smoothstep edge: flux / intensity on the axis. [rad, - -> sr]

    The edge is s(t) = 3 t^2 - 2 t^3 with t = (cos(theta) - cos(h)) / ((1 - cos(h)) blend), whose mean over the edge
    is 1/2, so the weight is the full cone less half of the edge.
    """
    cap = 2.0 * np.sin(0.5 * half_angle) ** 2
    return 2.0 * np.pi * cap * (1.0 - 0.5 * blend)


def spread_axis_factor(spread):
    """Ratio of the axial luminance of an area light with Blender's spread to the Lambertian one of equal flux. [rad -> -]

    The profile is max(0, 1 - tan(theta)/tan(h)), h = spread / 2, so the flux integral gives tan h / (tan h - h).
    """
    half = 0.5 * spread
    if half >= 0.5 * np.pi - 1e-4:
        return 1.0
    return np.tan(half) / (np.tan(half) - half)
