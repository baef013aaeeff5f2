"""A cloth as a surface, as pure data: its tables, and what its data sheet would state."""

from dataclasses import dataclass

import numpy as np

from ..scene.material import Measured


@dataclass(frozen=True)
class Sheet:
    """Numbers of a data sheet.

    Parameters
    ----------
    openness : float    Straight share of light along the normal. [-]
    transmittance, reflectance, back_reflectance : float    Visible, of light along the normal, to all directions. [-]
    diffused : float    Part of the transmittance that does not go straight. [-]
    diffuse_transmittance, diffuse_reflectance : float    Visible, of light from everywhere onto the front. [-]
    cutoff_warp_deg, cutoff_weft_deg : float
        Angle from which on no direct light passes, light coming along the warp, and along the weft. [deg]
    transmittance_error, reflectance_error : float    Standard errors of those along the normal. [-]
    """

    openness: float
    transmittance: float
    reflectance: float
    back_reflectance: float
    diffused: float
    diffuse_transmittance: float
    diffuse_reflectance: float
    cutoff_warp_deg: float
    cutoff_weft_deg: float
    transmittance_error: float
    reflectance_error: float


@dataclass(frozen=True, eq=False)
class WovenSurface:
    """What a cloth scatters.

    Parameters
    ----------
    surface : Measured    The warp runs along its V.
    sheet : Sheet
    reflected, passed : (3,) float64 array
        Linear Rec. 709 of light along the normal that is reflected, and that passes through yarns, under D65; white is 1.
    table_error : float    Largest of the errors of its tables, see `ScatterTable`. [-]
    rays, seed : int    Rays in all.
    key : str    Hash of all that it follows from.
    notes : tuple of str    What is left out or assumed.
    """

    surface: Measured
    sheet: Sheet
    reflected: np.ndarray
    passed: np.ndarray
    table_error: float
    rays: int
    seed: int
    key: str
    notes: tuple[str, ...] = ()
