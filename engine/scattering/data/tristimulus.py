"""Colours of what is scattered, under a CIE illuminant."""

import numpy as np

from ...photometry.colour import XYZ_TO_REC709
from ...photometry.spectra import GRID, illuminant, observer


def weights_of(wavelengths, name: str = "D65") -> np.ndarray:
    """Weights by which values at wavelengths become X, Y, Z under an illuminant, where 1 at all gives Y = 1.

    Parameters
    ----------
    wavelengths : (w,) array    Ascending; values are linear in between, and the ends hold beyond. [nm]
    name : str    Of a CIE illuminant.

    Returns
    -------
    (w, 3) float64 array    [-]

    Raises
    ------
    SceneError    The illuminant is unknown.
    """
    tents = [np.interp(GRID, wavelengths, row) for row in np.eye(len(wavelengths))]
    seen = illuminant(GRID, name)[:, None] * observer()
    return np.array(tents) @ seen / seen[:, 1].sum()


def tristimulus(values, wavelengths, name: str = "D65") -> np.ndarray:
    """X, Y, Z of reflectances or transmittances under an illuminant; Y of the perfect diffuser is 1. (..., w) -> (..., 3)"""
    return np.asarray(values, dtype=np.float64) @ weights_of(wavelengths, name)


def linear_colour(values, wavelengths) -> np.ndarray:
    """Linear Rec. 709 of reflectances under D65; components outside the gamut are kept. (..., w) -> (..., 3)"""
    return tristimulus(values, wavelengths, "D65") @ XYZ_TO_REC709.T
