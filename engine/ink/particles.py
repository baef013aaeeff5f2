"""Particles as rigid chains of spheres along an axis: balls, grains of rice, cylinders."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

SHAPES = ("sphere", "rice", "cylinder")

LENGTH = 6.0
"""Length of rods over the radius of their middle. [-]"""

MEMBERS = 5
"""Spheres of a rod."""

TIP = 0.4
"""Radius of the end of a grain of rice over that of its middle. [-]"""

SLICES = 4096
"""Slices by which the volume of a chain is summed."""


@dataclass(frozen=True, eq=False)
class Chain:
    """Spheres of a particle of which the volume is that of a ball of diameter 1.

    Parameters
    ----------
    places : (m,) float64 array    Of the centres along the axis, about 0.
    radii : (m,) float64 array
    """

    places: np.ndarray
    radii: np.ndarray

    @property
    def reach(self) -> float:
        """Distance of the farthest point from the middle."""
        return float((np.abs(self.places) + self.radii).max())


@lru_cache
def chain_of(shape: str) -> Chain:
    """Chain of one of `SHAPES`, of unit equivalent diameter: the union of its spheres has the volume pi / 6."""
    if shape == "sphere":
        return Chain(np.zeros(1), np.full(1, 0.5))
    places = np.linspace(-2.0, 2.0, MEMBERS)
    radii = np.ones(MEMBERS)
    if shape == "rice":
        # An ellipse's radii, of which the last spheres end where the rod does.
        radii = TIP + (1.0 - TIP) * np.sqrt(1.0 - (places / (0.5 * LENGTH)) ** 2)
        places = places * (0.5 * LENGTH - radii[-1]) / 2.0
    scale = np.cbrt(np.pi / 6.0 / union_volume(places, radii))
    return Chain(places * scale, radii * scale)


def union_volume(places, radii) -> float:
    """Volume of the union of spheres on a line."""
    low, high = (places - radii).min(), (places + radii).max()
    at = low + (high - low) * (np.arange(SLICES) + 0.5) / SLICES
    squares = radii[:, None] ** 2 - (at - places[:, None]) ** 2
    return float(np.pi * np.maximum(squares.max(axis=0), 0.0).sum() * (high - low) / SLICES)


@dataclass(frozen=True)
class Population:
    """Particles that are alike in kind.

    Parameters
    ----------
    share : float    Of the layer's volume. [-]
    diameter : float    Median by number, of balls of the same volume. [um]
    log_spread : float    Standard deviation of its logarithm. [-]
    shape : str    One of `SHAPES`.
    alignment : float
        Energy by which axes turn to the horizontal (above 0) or upright (below 0), in units of the thermal one. [-]
    cluster_size : float    Mean number of particles that start about one place; up to 1: none do. [-]
    cluster_radius : float    Standard deviation of their distance from it per axis. [um]
    """

    share: float
    diameter: float
    log_spread: float = 0.0
    shape: str = "sphere"
    alignment: float = 0.0
    cluster_size: float = 1.0
    cluster_radius: float = 0.0
