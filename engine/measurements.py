"""What measuring gives: illuminance at sensors, and what a goniometer reads of a surface."""

from dataclasses import dataclass, replace

import numpy as np

from .photometry.units import LUMINOUS_EFFICACY
from .scene.provenance import Provenance


@dataclass(frozen=True)
class SensorSpectra:
    """Spectra of the light at sensors.

    Parameters
    ----------
    edges : (b + 1,) float64    Of the bands. [nm]
    bands, bands_error : (n, b) float64    Mean spectral irradiance and its standard error. [W/(m2 nm)]
    equivalent_daylight : (n, 5) float64
        Alpha-opic equivalent daylight (D65) illuminances in the order of `photometry.alpha_opic.RECEPTORS`. [lx]
    equivalent_daylight_error : (n, 5) float64    Standard errors. [lx]
    """

    edges: np.ndarray
    bands: np.ndarray
    bands_error: np.ndarray
    equivalent_daylight: np.ndarray
    equivalent_daylight_error: np.ndarray


@dataclass(frozen=True)
class Measurement:
    """Illuminance at sensors.

    Parameters
    ----------
    illuminance, standard_error : (n,) float64    [lx]
    tristimulus : (n, 3) float64 or None    X, Y, Z with Y the illuminance, where colour was asked for. [lx]
    tristimulus_error : (n, 3) float64 or None    Standard errors. [lx]
    balance : dict or None    Energy of the whole by the pilot from the lights, see `WitnessReport.balance`. [lm]
    method : str    How light beyond the first bounce was found and why so, for people.
    spectra : SensorSpectra or None    Where they were asked for.
    has_common_errors : bool    Whether errors of sensors have much in common, such as cells that all read.
    floors : (n,) float64 or None    Part of the errors that more samples do not lower, in all channels; None: nothing. [lx]
    """

    illuminance: np.ndarray
    standard_error: np.ndarray
    provenance: Provenance
    tristimulus: np.ndarray | None = None
    tristimulus_error: np.ndarray | None = None
    balance: dict | None = None
    method: str = ""
    spectra: SensorSpectra | None = None
    has_common_errors: bool = False
    floors: np.ndarray | None = None

    def widened(self, floors: np.ndarray) -> "Measurement":
        """Return it with errors that hold what sensors may be off by as well. (n,) [lx]"""
        lux, spectra = floors[:, None], self.spectra
        fields = {
            "standard_error": np.hypot(self.standard_error, floors),
            "floors": floors if self.floors is None else np.hypot(self.floors, floors),
        }
        if self.tristimulus_error is not None:
            fields["tristimulus_error"] = np.hypot(self.tristimulus_error, lux)
        if spectra is not None:
            doses = np.hypot(spectra.equivalent_daylight_error, lux)
            bands = np.hypot(spectra.bands_error, lux / LUMINOUS_EFFICACY)
            fields["spectra"] = replace(spectra, equivalent_daylight_error=doses, bands_error=bands)
        return replace(self, **fields)


@dataclass(frozen=True)
class SurfaceProbe:
    """What a goniometer reads of a surface.

    Parameters
    ----------
    angles : (n,) float64 or None    Between the normal and the direction that light came from; None: even light. [deg]
    reflectance, transmittance : (n,) float64    Shares of the arriving energy, into all directions together. [-]
    reflectance_error, transmittance_error : (n,) float64    Standard errors. [-]
    """

    angles: np.ndarray | None
    reflectance: np.ndarray
    transmittance: np.ndarray
    reflectance_error: np.ndarray
    transmittance_error: np.ndarray
