"""What measuring gives: illuminance at sensors, and what a goniometer reads of a surface."""

from dataclasses import dataclass

import numpy as np

from .scene.provenance import Provenance


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
    """

    illuminance: np.ndarray
    standard_error: np.ndarray
    provenance: Provenance
    tristimulus: np.ndarray | None = None
    tristimulus_error: np.ndarray | None = None
    balance: dict | None = None
    method: str = ""


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
