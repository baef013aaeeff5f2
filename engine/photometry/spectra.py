"""Evaluation of spectra on wavelengths and their photometric integrals."""

from functools import lru_cache

import numpy as np

from ...libraries import spectra as tables
from ..errors import SceneError
from ..scene.spectrum import (
    Blackbody,
    Constant,
    Daylight,
    Illuminant,
    Lines,
    Rgb,
    Spectrum,
    Tabulated,
)
from .sigmoid_table import fetch_coefficients
from .units import LUMINOUS_EFFICACY, MAXIMUM_WAVELENGTH, MINIMUM_WAVELENGTH

GRID = np.arange(MINIMUM_WAVELENGTH, MAXIMUM_WAVELENGTH + 0.5, 1.0)
"""The wavelengths on which integrals are taken, (471,). [nm]"""

SECOND_RADIATION_CONSTANT = 1.438776877e-2
"""c2 = h c / k. [m K] (CODATA 2018)"""


@lru_cache
def observer() -> np.ndarray:
    """Return x-bar, y-bar, z-bar of the CIE 1931 observer on `GRID`, shape (471, 3). [-]"""
    wavelengths, values = tables.observer()
    return np.stack([np.interp(GRID, wavelengths, values[:, i]) for i in range(3)], axis=1)


def luminous_efficiency() -> np.ndarray:
    """Return V(lambda) on `GRID`, shape (471,). [-]"""
    return observer()[:, 1]


def planck(wavelengths, temperature, c2=SECOND_RADIATION_CONSTANT) -> np.ndarray:
    """Relative spectral radiance of a blackbody, 1 at 560 nm. [nm, K -> -]"""

    def shape(nm):
        return nm**-5.0 / np.expm1(c2 / (nm * 1e-9 * temperature))

    return shape(np.asarray(wavelengths, dtype=np.float64)) / shape(560.0)


def daylight(wavelengths, temperature) -> np.ndarray:
    """Relative power of the CIE daylight phase, 100 at 560 nm. [nm, K -> -] (CIE 15:2018, 3.1.2)

    Raises
    ------
    SceneError    The temperature is outside 4000 K to 25000 K, where CIE daylight is not defined.
    """
    t = float(temperature)
    if not 4000.0 <= t <= 25000.0:
        raise SceneError(
            f"CIE daylight is defined from 4000 K to 25000 K, found {t:g} K; use a blackbody below 4000 K"
        )
    if t <= 7000.0:
        x = -4.6070e9 / t**3 + 2.9678e6 / t**2 + 0.09911e3 / t + 0.244063
    else:
        x = -2.0064e9 / t**3 + 1.9018e6 / t**2 + 0.24748e3 / t + 0.237040
    y = -3.000 * x**2 + 2.870 * x - 0.275
    m = 0.0241 + 0.2562 * x - 0.7341 * y
    m1 = round((-1.3515 - 1.7703 * x + 5.9114 * y) / m, 3)
    m2 = round((0.0300 - 31.4424 * x + 30.0717 * y) / m, 3)
    nm, s = tables.daylight_components()
    return np.interp(wavelengths, nm, s @ np.array([1.0, m1, m2]), left=0.0, right=0.0)


def illuminant(wavelengths, name: str) -> np.ndarray:
    """Relative power of a CIE illuminant. [nm -> -]

    Raises
    ------
    SceneError    The name is unknown.
    """
    if name == "A":
        return 100.0 * planck(wavelengths, 2848.0, c2=1.435e-2)
    if name in tables.ANALYTIC_ILLUMINANTS:
        nominal = 100.0 * float(name[1:])
        return daylight(wavelengths, nominal * 1.4388 / 1.4380)
    try:
        nm, values = tables.tabulated_illuminant(name)
    except KeyError:
        known = ", ".join(tables.illuminant_names())
        raise SceneError(f"unknown illuminant '{name}', expected one of {known}") from None
    return np.interp(wavelengths, nm, values, left=0.0, right=0.0)


def emission_lines(wavelengths, lines: Lines) -> np.ndarray:
    """Spectral density of emission lines, each a tent that falls to 0 within 1 nm. [nm -> 1/nm]

    The sum of a tent over the full nanometres is the line's power, and that of its product with a table is the table's
    value at the line, linear between full nanometres: no line is missed, doubled, or moved to the middle of a band.

    Raises
    ------
    SceneError    There are no lines, they are not within 360..830 nm, or a power is negative or not a finite number.
    """
    centres, powers = (
        np.atleast_1d(np.asarray(x, dtype=np.float64)) for x in (lines.wavelengths, lines.powers)
    )
    if centres.ndim != 1 or centres.shape != powers.shape or not centres.size:
        raise SceneError(
            f"emission lines need a row of wavelengths, at least one, and as many powers, found arrays of shape "
            f"{centres.shape} and {powers.shape}"
        )
    # A comparison with NaN is false.
    outside = ~((centres >= MINIMUM_WAVELENGTH) & (centres <= MAXIMUM_WAVELENGTH))
    if outside.any():
        raise SceneError(
            f"an emission line lies at {centres[outside][0]:g} nm, expected a wavelength from "
            f"{MINIMUM_WAVELENGTH:g} to {MAXIMUM_WAVELENGTH:g} nm"
        )
    unusable = ~(np.isfinite(powers) & (powers >= 0.0))
    if unusable.any():
        raise SceneError(
            f"the emission line at {centres[unusable][0]:g} nm has the power "
            f"{powers[unusable][0]:g}, expected a number of at least 0"
        )
    wavelengths = np.asarray(wavelengths, dtype=np.float64)
    tents = np.maximum(1.0 - np.abs(wavelengths[..., None] - centres), 0.0)
    return tents @ powers


def evaluate_emission(spectrum: Spectrum, wavelengths) -> np.ndarray:
    """Relative spectral power of a light. Its scale has no meaning.

    Parameters
    ----------
    spectrum : Spectrum
    wavelengths : (n,) array    [nm]

    Returns
    -------
    (n,) float64 array    [-]

    Raises
    ------
    SceneError    The spectrum cannot be evaluated; the text says what is wrong.
    """
    wavelengths = np.asarray(wavelengths, dtype=np.float64)
    match spectrum:
        case Constant():
            return np.ones_like(wavelengths)
        case Rgb():
            return upsample(spectrum, wavelengths) * illuminant(wavelengths, "D65")
        case Tabulated():
            return np.interp(wavelengths, spectrum.wavelengths, spectrum.values, left=0, right=0)
        case Illuminant():
            return illuminant(wavelengths, spectrum.name)
        case Blackbody():
            return planck(wavelengths, spectrum.temperature)
        case Daylight():
            return daylight(wavelengths, spectrum.temperature)
        case Lines():
            return emission_lines(wavelengths, spectrum)
    raise SceneError(f"unknown kind of spectrum: {type(spectrum).__name__}")


def evaluate_reflectance(spectrum: Spectrum, wavelengths) -> np.ndarray:
    """Spectral reflectance or transmittance; tables go on with their end values. [nm -> -]"""
    wavelengths = np.asarray(wavelengths, dtype=np.float64)
    match spectrum:
        case Constant():
            return np.full_like(wavelengths, spectrum.value)
        case Rgb():
            return upsample(spectrum, wavelengths)
        case Tabulated():
            return np.interp(wavelengths, spectrum.wavelengths, spectrum.values)
    raise SceneError(f"a {type(spectrum).__name__} is a light, not a reflectance")


def upsample(rgb: Rgb, wavelengths) -> np.ndarray:
    """Smooth spectrum of a linear Rec. 709 colour by the sigmoid of a quadratic polynomial.

    The three coefficients come from Mitsuba's table; components above 1 scale the spectrum of the colour at half.

    References
    ----------
    W. Jakob, J. Hanika: A low-dimensional function space for efficient spectral upsampling, 2019,
    doi:10.1111/cgf.13626
    """
    colour = np.array([rgb.red, rgb.green, rgb.blue], dtype=np.float64)
    largest = colour.max()
    if largest <= 0.0:
        return np.zeros_like(wavelengths)
    scale = 1.0 if largest <= 1.0 else 2.0 * largest
    c0, c1, c2 = fetch_coefficients(*(colour / scale))
    if np.isinf(c2):
        return np.full_like(wavelengths, scale if c2 > 0 else 0.0)
    x = (c0 * wavelengths + c1) * wavelengths + c2
    return scale * (0.5 + 0.5 * x / np.sqrt(1.0 + x * x))


def integrate(values) -> float:
    """Integral over `GRID` by the 1 nm sum that photometry standards use. [x -> x nm]"""
    return float(np.sum(values))


def luminous_weight(spectrum: Spectrum) -> float:
    """Photometric integral K_m * sum(S V) of a relative emission spectrum, the scale-free luminous amount."""
    return LUMINOUS_EFFICACY * integrate(evaluate_emission(spectrum, GRID) * luminous_efficiency())


def efficacy(spectrum: Spectrum) -> float:
    """Luminous efficacy of radiation of a spectrum over 360..830 nm. [lm/W]

    Raises
    ------
    SceneError    The spectrum emits nothing between 360 and 830 nm.
    """
    power = integrate(evaluate_emission(spectrum, GRID))
    if power <= 0.0:
        raise SceneError("the spectrum of a light is zero everywhere between 360 and 830 nm")
    return luminous_weight(spectrum) / power


def efficacy_of_table(wavelengths, values) -> float:
    """Luminous efficacy of all the radiation in a table, ultraviolet and infrared included, or of one wavelength. [lm/W]

    Parameters
    ----------
    wavelengths, values : (n,) arrays    Ascending [nm]; relative spectral power [1/nm], linear in between.
    """
    if len(wavelengths) == 1:
        seen = np.interp(wavelengths[0], GRID, luminous_efficiency(), left=0.0, right=0.0)
        return LUMINOUS_EFFICACY * float(seen)
    power = 0.5 * float(np.diff(wavelengths) @ (values[1:] + values[:-1]))
    seen = np.interp(GRID, wavelengths, values, left=0.0, right=0.0)
    return LUMINOUS_EFFICACY * float(seen @ luminous_efficiency()) / power if power > 0.0 else 0.0


def efficacy_of_all(spectrum: Spectrum) -> float:
    """Luminous efficacy of a spectrum as far as it is known: of all of a table, of others within 360..830 nm. [lm/W]

    Raises
    ------
    SceneError    As of `efficacy`.
    """
    if isinstance(spectrum, Tabulated):
        return efficacy_of_table(spectrum.wavelengths, spectrum.values)
    return efficacy(spectrum)


def photometric_density(spectrum: Spectrum) -> np.ndarray:
    """Spectral density on `GRID` that carries exactly 1 lumen (or cd, lx, cd/m2 alike). [W/nm per lm]

    Raises
    ------
    SceneError    The spectrum gives no visible light, so that no lumens can be made of it.
    """
    weight = luminous_weight(spectrum)
    if weight <= 0.0:
        raise SceneError(
            "the spectrum of a light holds no visible light; state it in watts or change it"
        )
    return evaluate_emission(spectrum, GRID) / weight
