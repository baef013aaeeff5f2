"""The colour that a light's spectrum has in three channels, for programs that know no spectra."""

import numpy as np

from ..scene.spectrum import Spectrum
from .colour import XYZ_TO_REC709
from .spectra import GRID, evaluate_emission, observer


def light_colour(spectrum: Spectrum) -> np.ndarray:
    """Return the linear Rec. 709 colour of a light; components of colours outside the gamut are 0 at least.

    Parameters
    ----------
    spectrum : Spectrum    Relative spectral power.

    Returns
    -------
    (3,) array    The largest component is 1. [-]
    """
    colour = XYZ_TO_REC709 @ (evaluate_emission(spectrum, GRID) @ observer())
    colour = np.maximum(colour, 0.0)
    return colour / colour.max()
