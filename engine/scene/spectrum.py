"""Spectra as pure data: what was asked for, not yet evaluated on a wavelength grid."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Constant:
    """The same value at every wavelength (a neutral reflectance, an equal-energy light)."""

    value: float = 1.0


@dataclass(frozen=True)
class Rgb:
    """Linear Rec. 709 / D65 colour, upsampled to a smooth spectrum when it is evaluated.

    As a reflectance the components lie in [0, 1]; as the colour of a light only the chromaticity counts,
    because the amount of light is stated separately.
    """

    red: float
    green: float
    blue: float


@dataclass(frozen=True, eq=False)
class Tabulated:
    """Values at given wavelengths, linear in between.

    Parameters
    ----------
    wavelengths : (n,) float64 array    Strictly ascending. [nm]
    values : (n,) float64 array    Reflectance [-] or relative spectral power [1/nm].
    name : str    Where the table came from, for reports.
    """

    wavelengths: np.ndarray
    values: np.ndarray
    name: str = ""


@dataclass(frozen=True)
class Illuminant:
    """A CIE illuminant by its name in `libraries/spectra/illuminants.csv`, such as ``D65`` or ``FL11``."""

    name: str


@dataclass(frozen=True)
class Blackbody:
    """Planck radiator. ``temperature`` [K]."""

    temperature: float


@dataclass(frozen=True)
class Daylight:
    """CIE daylight phase of a correlated colour temperature, 4000 K to 25000 K. ``temperature`` [K]."""

    temperature: float


@dataclass(frozen=True, eq=False)
class Lines:
    """Emission lines, such as sodium's.

    Each is spread over the two neighbours on a grid of 1 nm in proportion to its nearness, so that its photometric
    integrals are those at the line itself, with tables linear between full nanometres.

    Parameters
    ----------
    wavelengths : (n,) float64 array    [nm]
    powers : (n,) float64 array    Relative power of each line. [-]
    name : str    For reports.
    """

    wavelengths: np.ndarray
    powers: np.ndarray
    name: str = ""


Spectrum = Constant | Rgb | Tabulated | Illuminant | Blackbody | Daylight | Lines
"""Any of the spectrum descriptions."""
