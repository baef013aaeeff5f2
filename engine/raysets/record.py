"""What a reader of ray files returns: where the rays lie in the file, what their numbers mean, and all else that it says.

A ray set is a measured or computed source as rays: where each starts, which way it goes, how much light it carries, and in
some files its wavelength. Files have up to billions of them, so none is read before it is asked for.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..reading.remarks import Remark

RADIANT, LUMINOUS = "radiant", "luminous"
"""What the weights of rays are: watts, or lumens."""

UNITS = {"m": 1.0, "inch": 0.0254, "cm": 0.01, "foot": 0.3048, "mm": 0.001, "um": 1e-6, "nm": 1e-9}
"""Lengths. [m]"""


@dataclass(frozen=True, eq=False)
class Rays:
    """Rays, one a row.

    Parameters
    ----------
    position : (n, 3) float32 array    [m]
    direction : (n, 3) float32 array    Unit vectors.
    weight : (n,) float32 array    Flux, in the file's quantity and scale.
    wavelength : (n,) float32 array or None    [nm]
    spectrum : (n,) int32 array or None    Which of the file's spectra, from 0.
    """

    position: np.ndarray
    direction: np.ndarray
    weight: np.ndarray
    wavelength: np.ndarray | None = None
    spectrum: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.weight)


@dataclass(frozen=True)
class Columns:
    """Which numbers of a row mean what; None: there is none such.

    Parameters
    ----------
    count : int    Numbers in a row.
    position, direction : int or None    First of three.
    weight : int
    wavelength, spectrum : int or None
    """

    count: int
    position: int | None
    direction: int
    weight: int
    wavelength: int | None = None
    spectrum: int | None = None


@dataclass(frozen=True, eq=False)
class RayFile:
    """A ray file whose head has been read.

    Parameters
    ----------
    path : Path
    format : str    Such as ``TM-25-13`` or ``LightTools binary``.
    count : int    Rays, those included that will turn out to be of no use.
    columns : Columns
    rows : callable    Each call yields all rows anew, piece by piece: (n, columns) float32 arrays.
    scale : float    Length of the file's unit. [m]
    quantity : str    `RADIANT` or `LUMINOUS`: what the weights are.
    is_relative : bool    Whether the weights only tell shares of the stated flux.
    luminous_flux, radiant_flux : float or None    As stated. [lm], [W]
    wavelength : float or None    The one of all rays. [nm]
    wavelength_scale : float    Length of the file's unit of wavelength. [nm]
    spectra : tuple of (wavelengths [nm], values)    Relative ones.
    metadata : dict of str to str
    remarks : tuple of Remark
    """

    path: Path
    format: str
    count: int
    columns: Columns
    rows: Callable[[], Iterator[np.ndarray]]
    scale: float
    quantity: str
    is_relative: bool = False
    luminous_flux: float | None = None
    radiant_flux: float | None = None
    wavelength: float | None = None
    wavelength_scale: float = 1.0
    spectra: tuple[tuple[np.ndarray, np.ndarray], ...] = ()
    metadata: dict[str, str] = field(default_factory=dict)
    remarks: tuple[Remark, ...] = ()

    @property
    def stated_flux(self) -> float | None:
        """Stated flux in the quantity of the weights. [lm or W]"""
        return self.luminous_flux if self.quantity == LUMINOUS else self.radiant_flux
