"""Places at which illuminance is wanted, as pure data. They live on the engine's side and survive the host's edits."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class SensorSet:
    """Illuminance sensors.

    Parameters
    ----------
    id : str    Stable and unique.
    name : str    For people.
    positions : (n, 3) float64 array    World space. [m]
    normals : (n, 3) float64 array    Where each sensor faces; any length above 0.
    """

    id: str
    name: str
    positions: np.ndarray
    normals: np.ndarray
