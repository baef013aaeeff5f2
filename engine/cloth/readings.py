"""What data sheets of cloths and screens state: openness, visible shares, cut-off angle, colours.

Visible shares are weighed by D65 and the eye (EN 410). By EN 14500 a transmittance is from one direction of light or from
everywhere (diffuse) to all directions; its straight part is told apart.

References
----------
EN 14500:2021: Blinds and shutters - Thermal and visual comfort. EN 410:2011 for the weights.
"""

import numpy as np

from ..photometry.colour import XYZ_TO_REC709
from ..photometry.spectra import GRID, illuminant, luminous_efficiency, observer
from ..scattering.data.evaluation import totals
from .surface import Sheet
from .woven import Woven

STEPS = 24
"""Points of the quadrature over angles of incidence."""

TURNS = 8
"""Rotations of the light over which diffuse shares are averaged."""


def visible_weights(wavelengths) -> np.ndarray:
    """Weights of shares at wavelengths in their mean under D65 as the eye sees it. (w,) [nm] -> (w,)"""
    seen = illuminant(GRID, "D65") * luminous_efficiency()
    tents = np.array([np.interp(GRID, wavelengths, row) for row in np.eye(len(wavelengths))])
    return tents @ seen / seen.sum()


def read_sheet(woven: Woven) -> Sheet:
    """Read a cloth as its data sheet would state it."""
    sides = woven.sides
    weights = visible_weights(sides["front_reflection"].wavelengths)

    def normal(side):
        return float(totals(sides[side], [0.0], [0.0])[0, 0] @ weights)

    def diffuse(side):
        nodes, own = np.polynomial.legendre.leggauss(STEPS)
        square = 0.5 * (nodes + 1.0)
        turns = 2.0 * np.pi * (np.arange(TURNS) + 0.5) / TURNS
        shares = totals(sides[side], np.arcsin(np.sqrt(square)), turns) @ weights
        return float(0.5 * (shares.mean(axis=0) @ own))

    transmittance = normal("front_transmission")
    along_warp, along_weft = np.degrees(woven.cutoffs)
    return Sheet(
        woven.openness,
        transmittance,
        normal("front_reflection"),
        normal("back_reflection"),
        transmittance - woven.openness,
        diffuse("front_transmission"),
        diffuse("front_reflection"),
        float(along_warp),
        float(along_weft),
        float(woven.errors["front_transmission"][0, 0] @ weights),
        float(woven.errors["front_reflection"][0, 0] @ weights),
    )


def hue_saturation_value(values, wavelengths) -> np.ndarray:
    """Hue 0 to 1, saturation and value of a spectrum of shares under D65, by linear Rec. 709. (w,) -> (3,)"""
    import colorsys

    return np.array(colorsys.rgb_to_hsv(*np.clip(linear_colour(values, wavelengths), 0.0, None)))


def linear_colour(values, wavelengths) -> np.ndarray:
    """Linear Rec. 709 of spectra of shares under D65, of which white is 1. (..., w) -> (..., 3)"""
    weights = illuminant(GRID, "D65")[:, None] * observer()
    tents = np.array([np.interp(GRID, wavelengths, row) for row in np.eye(len(wavelengths))])
    xyz = np.asarray(values) @ (tents @ weights) / weights[:, 1].sum()
    return xyz @ np.asarray(XYZ_TO_REC709).T
