"""What spectra change of coloured light on coloured surfaces, beside programs that multiply three channels."""

from functools import lru_cache

import numpy as np

from ..scene.spectrum import Rgb
from .colour import REC709_LUMINANCE
from .spectra import GRID, evaluate_emission, evaluate_reflectance, luminous_efficiency


@lru_cache(maxsize=4096)
def excess_over_channels(light: Rgb, paint: Rgb) -> float:
    """Luminance of light that a surface has reflected once, over that of its three channels, less 1.

    Parameters
    ----------
    light, paint : Rgb    Linear Rec. 709 colours: of the light, whose scale does not count, and the reflectance.

    Returns
    -------
    float    0 where either is grey, and where nothing is reflected in three channels. [-]
    """
    sent, answered = (np.array([c.red, c.green, c.blue], float) for c in (light, paint))
    whole, reflected = REC709_LUMINANCE @ sent, REC709_LUMINANCE @ (sent * answered)
    if reflected <= 0.0:
        return 0.0
    seen = evaluate_emission(light, GRID) * luminous_efficiency()
    share = float(seen @ evaluate_reflectance(paint, GRID) / seen.sum())
    return share / (reflected / whole) - 1.0
