"""A paint as a surface, as pure data: its table with its flakes, and what multi-angle instruments read of it."""

from dataclasses import dataclass

import numpy as np

from ..scene.material import Measured


@dataclass(frozen=True, eq=False)
class PaintedSurface:
    """What a composition scatters.

    Parameters
    ----------
    surface : Measured
    angles : (g,) float64 array    Aspecular angles of the readings, light coming at 45 degrees. [deg]
    wavelengths : (w,) float64 array    [nm]
    readings : (g, w) float64 array    Reflectance factors. [-]
    lab : (g, 3) float64 array    L*, a*, b* of them under D65 for the observer of 10 degrees.
    convergence : float    As of `tabulation.Tabulated`. [-]
    notes : tuple of str    What is left out or assumed.
    """

    surface: Measured
    angles: np.ndarray
    wavelengths: np.ndarray
    readings: np.ndarray
    lab: np.ndarray
    convergence: float
    notes: tuple[str, ...] = ()
