"""What a reader of scattering files returns."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...reading.remarks import Remark
from ...scene.scattering import Scatter

SIDES = ("front_reflection", "back_reflection", "front_transmission", "back_transmission")
"""What a file may tell, by the names that `scene.material.Measured` has for it."""


@dataclass(frozen=True, eq=False)
class ScatteringFile:
    """A measured or computed material as its file states it.

    Parameters
    ----------
    path : Path
    format : str    For people, such as ``Zemax BSDF``.
    sides : dict of str to Scatter    By the names of `SIDES`; those that the file lacks are missing.
    name, description, source : str    As written; empty where the file does not tell.
    incidences : (s,) float64 array    Angles of incidence at which the file has data. [rad]
    stated : dict of str to (s,) array
        Hemispherical totals that the file itself states, by the names of `SIDES`, at ``incidences``; nan where it does not.
    factors : dict of str to list of (incidence [rad], factor)
        By which the values of a side were brought to what is stated, for every incidence, rotation and band.
    remarks : tuple of Remark    Departures, assumptions, and what was left out.
    """

    path: Path
    format: str
    sides: dict[str, Scatter]
    name: str = ""
    description: str = ""
    source: str = ""
    incidences: np.ndarray = field(default_factory=lambda: np.zeros(0))
    stated: dict[str, np.ndarray] = field(default_factory=dict)
    factors: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    remarks: tuple[Remark, ...] = ()
