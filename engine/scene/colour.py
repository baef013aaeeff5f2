"""Quantities of a surface that may depend on the wavelength and on the place."""

from dataclasses import replace

import numpy as np

from .spectrum import Constant, Rgb, Spectrum, Tabulated
from .texture import ImageTexture

Colour = Spectrum | ImageTexture
"""A quantity per wavelength that may vary over the surface."""

Scalar = float | ImageTexture
"""A plain number that may vary over the surface (one-channel texture)."""


def largest_of(colour: Colour) -> float:
    """Largest value of a spectrum or picture. [-]"""
    match colour:
        case Constant():
            return colour.value
        case Rgb():
            return max(colour.red, colour.green, colour.blue)
        case Tabulated():
            return float(colour.values.max())
        case ImageTexture():
            return float(colour.pixels.max())
    return 0.0


def scale(colour: Colour, factor: float) -> Colour:
    """Return ``factor`` times as much."""
    match colour:
        case Constant():
            return Constant(colour.value * factor)
        case Rgb():
            return Rgb(colour.red * factor, colour.green * factor, colour.blue * factor)
        case Tabulated():
            return replace(colour, values=colour.values * factor)
        case ImageTexture():
            return replace(colour, pixels=colour.pixels * np.float32(factor))
    return colour
