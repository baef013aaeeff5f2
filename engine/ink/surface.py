"""A print as a surface, as pure data: its table, and what an instrument reads of it."""

from dataclasses import dataclass

import numpy as np

from ..scene.material import Measured


@dataclass(frozen=True, eq=False)
class PrintedSurface:
    """What a pigment layer on its substrate scatters.

    Parameters
    ----------
    surface : Measured
    wavelengths : (w,) float64 array    [nm]
    readings : (w,) float64 array    Reflectance factors at 45:0. [-]
    standard_errors : (w,) float64 array    Of them. [-]
    lab : (3,) float64 array    L*, a*, b* of them under D50 for the observer of 2 degrees.
    lab_error : float    Standard error as a colour difference.
    grid_error : float    As of `computed.Computed`. [-]
    realisations, seed : int
    key : str    Hash of all that the film follows from.
    notes : tuple of str    What is left out or assumed.
    """

    surface: Measured
    wavelengths: np.ndarray
    readings: np.ndarray
    standard_errors: np.ndarray
    lab: np.ndarray
    lab_error: float
    grid_error: float
    realisations: int
    seed: int
    key: str
    notes: tuple[str, ...] = ()
