"""Quantities of matter as functions of the wavelength in nm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Curve:
    """Values that are linear between wavelengths and hold beyond the first and last.

    Parameters
    ----------
    wavelengths : (n,) float64 array    Ascending; one: the same at all. [nm]
    values : (n,) float64 or complex128 array
    """

    wavelengths: np.ndarray
    values: np.ndarray

    def at(self, wavelengths) -> np.ndarray:
        """Values at wavelengths. (w,) [nm] -> (w,)"""
        return np.interp(np.asarray(wavelengths, np.float64), self.wavelengths, self.values)


@dataclass(frozen=True)
class Cauchy:
    """Refractive index A + B / lambda2 + C / lambda4 with lambda in micrometres.

    Parameters
    ----------
    terms : tuple of float    A, B, C; [-], [um2], [um4]
    """

    terms: tuple[float, ...]

    def at(self, wavelengths) -> np.ndarray:
        """Index at wavelengths. (w,) [nm] -> (w,)"""
        squared = (np.asarray(wavelengths, np.float64) * 1e-3) ** 2
        return sum(term / squared**power for power, term in enumerate(self.terms))


Spectrum = Curve

Index = Curve | Cauchy
