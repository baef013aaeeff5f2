"""From a stated output to the radiance or intensity that an emitter needs."""

from dataclasses import dataclass

import numpy as np

from ...errors import SceneError
from ...photometry import units
from ...photometry.spectra import GRID, efficacy, evaluate_emission, photometric_density
from ...scene.light import (
    AreaLight,
    LineLight,
    Luminaire,
    Output,
    PointLight,
    Quantity,
    SpotLight,
    SunLight,
)
from ...scene.spectrum import Spectrum
from .textures import is_spectral, number, table


@dataclass(frozen=True)
class Emitted:
    """An amount with its spectrum.

    ``amount`` is photometric (lm, cd, lx or cd/m2 as the maker says) and ``density`` (471,) the spectral density per
    unit of it [W/nm per lm]. For light without a visible part ``amount`` is radiant and the density sums to 1.
    """

    amount: float
    density: np.ndarray
    visible: bool = True

    @property
    def known_amount(self) -> float:
        """The amount as far as the variant knows of it: photometric ones have none of light without a visible part."""
        return self.amount if self.visible or is_spectral() else 0.0

    def texture(self) -> dict:
        """Texture of the spectral quantity, or of the photometric one in photometric variants."""
        if is_spectral():
            return table(self.amount * self.density)
        return number(self.known_amount)

    def scaled(self, factor: float) -> "Emitted":
        """Return the same light, ``factor`` times as much."""
        return Emitted(self.amount * factor, self.density, self.visible)


def luminous(amount: float, spectrum: Spectrum) -> Emitted:
    """Light of a photometric amount."""
    return Emitted(float(amount), photometric_density(spectrum))


def radiant(watts: float, spectrum: Spectrum) -> Emitted:
    """Light of a radiant amount within 360..830 nm, as lumens where it has any."""
    lumens_per_watt = efficacy(spectrum)
    if lumens_per_watt > 0.0:
        return luminous(watts * lumens_per_watt, spectrum)
    density = evaluate_emission(spectrum, GRID)
    return Emitted(float(watts), density / density.sum(), visible=False)


def _amount(output: Output) -> Emitted:
    if not (np.isfinite(output.value) and output.value >= 0.0):
        raise SceneError(
            f"a light's {output.quantity.value} is {output.value}, expected a number of at least 0"
        )
    if output.quantity is Quantity.RADIANT_FLUX:
        return radiant(output.value, output.spectrum)
    return luminous(output.value, output.spectrum)


def _unsupported(light, expected) -> SceneError:
    return SceneError(
        f"light '{light.name}': {light.output.quantity.value} is not defined for this kind of light, use {expected}"
    )


def point_intensity(light: PointLight) -> Emitted:
    """Intensity in every direction. [cd]"""
    given = _amount(light.output)
    match light.output.quantity:
        case Quantity.LUMINOUS_FLUX | Quantity.RADIANT_FLUX:
            return given.scaled(units.intensity_from_flux_isotropic(1.0))
        case Quantity.LUMINOUS_INTENSITY | Quantity.ILLUMINANCE:
            return given
        case Quantity.LUMINANCE if light.radius > 0.0:
            return given.scaled(np.pi * light.radius**2)
    raise _unsupported(light, "a flux, an intensity or an illuminance at 1 m")


def spot_intensity(light: SpotLight) -> Emitted:
    """Intensity on the axis. [cd]"""
    given = _amount(light.output)
    match light.output.quantity:
        case Quantity.LUMINOUS_FLUX | Quantity.RADIANT_FLUX:
            return given.scaled(1.0 / units.spot_solid_angle(light.half_angle, light.blend))
        case Quantity.LUMINOUS_INTENSITY | Quantity.ILLUMINANCE:
            return given
    raise _unsupported(light, "a flux, an intensity or an illuminance at 1 m")


def luminaire_flux(light: Luminaire) -> Emitted:
    """Total flux. [lm]"""
    given = _amount(light.output)
    if light.output.quantity in {Quantity.LUMINOUS_FLUX, Quantity.RADIANT_FLUX}:
        return given
    raise _unsupported(light, "a flux")


def sun_illuminance(light: SunLight) -> Emitted:
    """Illuminance of a plane facing the sun. [lx]"""
    given = _amount(light.output)
    match light.output.quantity:
        case Quantity.ILLUMINANCE | Quantity.RADIANT_FLUX:
            return given
        case Quantity.LUMINANCE if light.angle > 0.0:
            return given.scaled(np.pi * np.sin(0.5 * light.angle) ** 2)
    raise _unsupported(light, "the illuminance of a plane that faces it")


def area_luminance(light: AreaLight) -> Emitted:
    """Luminance along the normal, the spread included. [cd/m2]"""
    given = _amount(light.output)
    area = light.area
    match light.output.quantity:
        case Quantity.LUMINOUS_FLUX | Quantity.RADIANT_FLUX:
            lambertian = given.scaled(units.luminance_from_flux_lambertian(1.0, area))
            return lambertian.scaled(units.spread_axis_factor(light.spread))
        case Quantity.LUMINOUS_INTENSITY | Quantity.ILLUMINANCE:
            return given.scaled(1.0 / area)
        case Quantity.LUMINANCE:
            return given
    raise _unsupported(light, "a flux, an intensity or a luminance")


def line_luminance(light: LineLight) -> Emitted:
    """Luminance of the curved side. [cd/m2]"""
    given = _amount(light.output)
    match light.output.quantity:
        case Quantity.LUMINOUS_FLUX | Quantity.RADIANT_FLUX:
            return given.scaled(units.luminance_from_flux_lambertian(1.0, light.area))
        case Quantity.LUMINOUS_INTENSITY | Quantity.ILLUMINANCE:
            # Across the tube, where it looks like a rectangle.
            return given.scaled(1.0 / (2.0 * light.radius * light.length))
        case Quantity.LUMINANCE:
            return given
    raise _unsupported(light, "a flux, an intensity or a luminance")
