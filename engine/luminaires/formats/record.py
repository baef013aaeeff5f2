"""What a reader of photometric files returns: the distribution, the opening, and everything else that the file says."""

from dataclasses import dataclass, field

import numpy as np

from ...reading.remarks import Remark
from ...scene.distribution import IntensityDistribution, Opening

LUMINOUS, RADIANT = "luminous", "radiant"
"""What the intensities of a file are: candelas, or watts per steradian."""


@dataclass(frozen=True)
class Units:
    """Units of a kind of light, as they are written."""

    flux: str
    intensity: str
    luminance: str


UNITS = {LUMINOUS: Units("lm", "cd", "cd/m2"), RADIANT: Units("W", "W/sr", "W/(m2 sr)")}
"""Of a file's numbers, by its quantity."""


@dataclass(frozen=True)
class LampSet:
    """One equipment of lamps.

    Parameters
    ----------
    count : int    Of lamps, 0 if unknown.
    luminous_flux : float or None    Rated flux of all lamps of the set together. [lm]
    watts : float or None    Electrical, ballast included. [W]
    colour_temperature : float or None    [K]
    name, colour, colour_rendering : str    As written.
    """

    count: int = 1
    luminous_flux: float | None = None
    watts: float | None = None
    colour_temperature: float | None = None
    name: str = ""
    colour: str = ""
    colour_rendering: str = ""


@dataclass(frozen=True, eq=False)
class TiltTable:
    """Factor on all intensities by the tilt of the luminaire (LM-63 TILT).

    Parameters
    ----------
    geometry : int    1: lamp vertical, 2: lamp horizontal and stays so, 3: lamp horizontal and tilts with the luminaire.
    angles : (n,) float64 array    Ascending. [degree]
    factors : (n,) float64 array
    """

    geometry: int
    angles: np.ndarray
    factors: np.ndarray

    def factor(self, tilt: float) -> float:
        """Return the factor at a tilt [degree]; the nearest stated one outside the table."""
        return float(np.interp(abs(tilt), self.angles, self.factors))


@dataclass(frozen=True, eq=False)
class LuminaireFile:
    """A photometric file, read.

    Parameters
    ----------
    format : str    Such as ``LM-63-2002``, ``EULUMDAT`` or ``TM-33-18``.
    photometric_type : str    ``A``, ``B`` or ``C``.
    symmetry : str    ``rotational``, ``quadrant`` (about both planes), ``C0-C180``, ``C90-C270`` or ``none``.
    distribution : IntensityDistribution
        All around, in the unit of the quantity (candelas or W/sr): every factor of the file applied but the tilt.
    opening : Opening
    stored_azimuths, stored_polars : (n,) float64 array    Angles as stored in the file. [degree]
    is_absolute : bool    Whether the intensities do not refer to a rated flux of lamps.
    stated_flux : float or None    Rated flux of the lamps of the intensities [lm or W]; None: not stated (absolute).
    light_output_ratio : float or None    Stated share of the lamps' flux that leaves the luminaire (EULUMDAT LORL). [-]
    downward_fraction : float or None    Stated share of the luminaire's flux below the horizontal (EULUMDAT DFF). [-]
    watts : float or None    Electrical. [W]
    lamps : tuple of LampSet    The first is the one that the intensities are for.
    housing : (float, float, float) or None    Size of the body along the luminaire's x, y, z. [m] 0 in y: round.
    tilt : TiltTable or None
    spectrum : (wavelengths [nm], values) or None    Relative spectral power.
    metadata : dict of str to str    Keywords in the file's order, as written; several lines joined by newlines.
    remarks : tuple of Remark    Warnings.
    quantity : str    `LUMINOUS` or `RADIANT`: what intensities and fluxes are.
    """

    format: str
    photometric_type: str
    symmetry: str
    distribution: IntensityDistribution
    opening: Opening
    stored_azimuths: np.ndarray
    stored_polars: np.ndarray
    is_absolute: bool
    stated_flux: float | None = None
    light_output_ratio: float | None = None
    downward_fraction: float | None = None
    watts: float | None = None
    lamps: tuple[LampSet, ...] = ()
    housing: tuple[float, float, float] | None = None
    tilt: TiltTable | None = None
    spectrum: tuple[np.ndarray, np.ndarray] | None = None
    metadata: dict[str, str] = field(default_factory=dict)
    remarks: tuple[Remark, ...] = ()
    quantity: str = LUMINOUS

    @property
    def units(self) -> Units:
        """Units of its numbers."""
        return UNITS[self.quantity]
