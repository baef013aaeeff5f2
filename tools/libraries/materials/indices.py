"""Refractive indices of clear matter: Sellmeier's formula with published coefficients, and Cauchy's that comes nearest.

References
----------
Schott AG: Optical Glass, data sheets of N-BK7 and N-SF11.
I. H. Malitson: Interspecimen Comparison of the Refractive Index of Fused Silica, J. Opt. Soc. Am. 55, 1965.
I. H. Malitson: Refraction and Dispersion of Synthetic Sapphire, J. Opt. Soc. Am. 52, 1962.
M. Daimon, A. Masumura: Measurement of the refractive index of distilled water, Applied Optics 46, 2007 (20 °C).
N. Sultanova, S. Kasarova, I. Nikolov: Dispersion Properties of Optical Polymers, Acta Physica Polonica A 116, 2009.
F. Peter: Über Brechungsindizes und Absorptionskonstanten des Diamanten, Zeitschrift für Physik 15, 1923.
M. Rubin: Optical properties of soda lime silica glasses, Solar Energy Materials 12, 1985.
"""

from dataclasses import dataclass

import numpy as np

LINES = {"d": 587.5618, "F": 486.1327, "C": 656.2725}
"""Spectral lines of helium and hydrogen by which glasses are catalogued. [nm]"""


@dataclass(frozen=True)
class Sellmeier:
    """n^2 = 1 + sum of b w^2 / (w^2 - c), with the wavelength w and the root of c in micrometres. ``terms``: (b, c) each."""

    terms: tuple[tuple[float, float], ...]

    def index(self, wavelengths) -> np.ndarray:
        """Refractive index. [nm -> -]"""
        w2 = (1e-3 * np.asarray(wavelengths, dtype=np.float64)) ** 2
        return np.sqrt(1.0 + sum(b * w2 / (w2 - c) for b, c in self.terms))


@dataclass(frozen=True)
class Rubin:
    """n = a + b w^2 + c / w^2, with the wavelength w in micrometres."""

    a: float
    b: float
    c: float

    def index(self, wavelengths) -> np.ndarray:
        """Refractive index. [nm -> -]"""
        w2 = (1e-3 * np.asarray(wavelengths, dtype=np.float64)) ** 2
        return self.a + self.b * w2 + self.c / w2


CLEAR = {
    "N-BK7": Sellmeier(
        ((1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653))
    ),
    "N-SF11": Sellmeier(
        ((1.73759695, 0.013188707), (0.313747346, 0.0623068142), (1.89878101, 155.23629))
    ),
    "fused silica": Sellmeier(
        ((0.6961663, 0.0684043**2), (0.4079426, 0.1162414**2), (0.8974794, 9.896161**2))
    ),
    "sapphire": Sellmeier(
        ((1.4313493, 0.0726631**2), (0.65054713, 0.1193242**2), (5.3414021, 18.028251**2))
    ),
    "water": Sellmeier(
        (
            (0.5684027565, 0.005101829712),
            (0.1726177391, 0.01821153936),
            (0.02086189578, 0.02620722293),
            (0.1130748688, 10.69792721),
        )
    ),
    "PMMA": Sellmeier(((1.1819, 0.011313),)),
    "polycarbonate": Sellmeier(((1.4182, 0.021304),)),
    "diamond": Sellmeier(((0.3306, 0.1750**2), (4.3356, 0.1060**2))),
    "float glass": Rubin(1.5130, -0.003169, 0.003962),
}
"""By name."""


def abbe_number(matter) -> float:
    """Abbe's number (n_d - 1) / (n_F - n_C). [-]"""
    n = {line: float(matter.index(nm)) for line, nm in LINES.items()}
    return (n["d"] - 1.0) / (n["F"] - n["C"])


def cauchy_of(matter) -> tuple[float, float]:
    """Coefficients a and b of n = a + b / w^2 (w in micrometres) with the same n_d and the same Abbe number. [-], [um^2]"""
    inverse = {line: 1e6 / nm**2 for line, nm in LINES.items()}
    n = {line: float(matter.index(nm)) for line, nm in LINES.items()}
    b = (n["F"] - n["C"]) / (inverse["F"] - inverse["C"])
    return n["d"] - b * inverse["d"], b
