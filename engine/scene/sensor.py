"""Places at which illuminance is wanted, as pure data. They live on the engine's side and survive the host's edits."""

from dataclasses import dataclass
from enum import Enum, IntEnum

import numpy as np


class SensorKind(Enum):
    """Which illuminance is meant (EN 12665, CIE S 017). The vertical is world +z."""

    PLANAR = "planar"  # of the side of a plane that the normal points to
    SPHERICAL = "spherical"  # mean over a small sphere; the normal has no meaning
    CYLINDRICAL = "cylindrical"  # mean over the side of a small vertical cylinder; no normal
    SEMICYLINDRICAL = "semicylindrical"  # over the half of it that the horizontal normal points to


class SensorColour(IntEnum):
    """What of the colour of light sensors tell beside the illuminance."""

    NONE = 0
    TRISTIMULUS = 1  # X and Z
    SPECTRUM = 2  # these, alpha-opic equivalent daylight illuminances and the spectrum in bands


@dataclass(frozen=True, eq=False)
class SensorSet:
    """Illuminance sensors.

    Parameters
    ----------
    id : str    Stable and unique.
    name : str    For people.
    positions : (n, 3) float64 array    World space. [m]
    normals : (n, 3) float64 array    Where each sensor faces; any length above 0.
    kind : SensorKind
    """

    id: str
    name: str
    positions: np.ndarray
    normals: np.ndarray
    kind: SensorKind = SensorKind.PLANAR
