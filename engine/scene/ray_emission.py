"""What a ray set says of a light: rays to generate others from, as pure data."""

from dataclasses import dataclass, field

import numpy as np

from .memo import recall

GROUP = 64
"""Rays in a row that share a fluctuation."""

NARROWEST = 2e-3
"""Fluctuation of directions below which hardly any start sends light to a point. [-]"""

EVERYWHERE = 1e9
"""Distance within which everything lies. [m]"""

SPARED = 0.005
"""Relative error of light in lux maps that is put up with where little of it lands near, see `RayEmission`. [-]"""

LEAST_WEIGHT, LARGEST_WEIGHT = 0.25, 4.0
"""Bounds of the weight by direction. [-]"""

BANDS = 64
"""About the axis of a light, by which its weight by direction is told."""

PLANE, SPHERE, HULL = "plane", "sphere", "hull"
"""Kinds of bodies."""


@dataclass(frozen=True, eq=False)
class RayBody:
    """Surface that rays start from.

    Parameters
    ----------
    kind : str    ``plane``, ``sphere`` or ``hull``.
    centre : (3,) float64 array    Of the plane or sphere. [m]
    normal : (3,) float64 array    Of the plane, on the side to which the light goes.
    is_one_sided : bool    Whether all light of a plane goes to that side.
    radius : float    Of the sphere. [m]
    slabs : (k, 5) float32 array    Normals, lowest and highest height [m] of the points along them: the bounds of a hull, or
        of a plane's edge.
    """

    kind: str
    centre: np.ndarray
    normal: np.ndarray
    is_one_sided: bool
    radius: float
    slabs: np.ndarray


@dataclass(frozen=True, eq=False)
class DirectionWeight:
    """What generated rays count for by their direction, see `engine/raysets/direction_weight.py`.

    Parameters
    ----------
    axis : (3,) float64 array    About which there are bands.
    middle : float    Square of the tangent of half the angle from the axis at which the middle band begins. [-]
    bands : (BANDS + 1,) float64 array    Factor at the edges of the bands, linear between them.
    moments : (9,) float64 array    Coefficients of `direction_basis`, for another factor.
    mean : float    Of the product over generated rays. [-]
    """

    axis: np.ndarray
    middle: float
    bands: np.ndarray
    moments: np.ndarray
    mean: float = 1.0

    @classmethod
    def even(cls, axis=(0.0, 0.0, 1.0), middle: float = 1.0) -> "DirectionWeight":
        """One of 1 for all directions."""
        axis = np.asarray(axis, dtype=np.float64)
        return cls(axis, middle, np.ones(BANDS + 1), np.zeros(9))

    def place(self, direction: np.ndarray) -> np.ndarray:
        """Where directions lie among the edges of the bands. (n, 3) unit vectors -> (n,) 0 to `BANDS`"""
        # One less the cosine, which loses no digits next to the axis.
        off = np.minimum(0.5 * ((direction - self.axis) ** 2).sum(axis=1), 2.0)
        return BANDS * off / (off + self.middle * (2.0 - off))

    def of(self, direction: np.ndarray) -> np.ndarray:
        """Weights of directions. (n, 3) unit vectors -> (n,) [-]"""
        bands = np.interp(self.place(direction), np.arange(BANDS + 1), self.bands)
        product = bands * (1.0 + direction_basis(direction) @ self.moments)
        return np.clip(product, LEAST_WEIGHT, LARGEST_WEIGHT) / self.mean


def direction_basis(direction: np.ndarray) -> np.ndarray:
    """Functions that span all spherical harmonics up to the second degree. (n, 3) -> (n, 9)"""
    x, y, z = direction.T
    return np.stack([x * x, y * y, z * z, x * y, y * z, z * x, x, y, z], axis=1)


@dataclass(frozen=True, eq=False)
class RayEmission:
    """Rays in a luminaire's axes, about its centre, see `engine/raysets/cloud.py` for what they mean.

    Parameters
    ----------
    position : (n, 3) float32 array    Middles of starting points. [m]
    direction : (n, 3) float32 array
    factor : (g, 6, 6) float32 array    Lower triangular, for ``GROUP`` rays in a row. [m], [-]
    threshold : (n,) float32 array    Alias table: share that a place keeps.
    other : (n,) uint32 array    Who gets the rest.
    wavelength : (n,) float32 array or None    [nm] None: all rays have the light's spectrum.
    body : RayBody
    axis : (2, 3) float64 array or None    A point [m] and a direction about which rays are turned.
    weight : DirectionWeight
    size : float    Largest extent of the starting points. [m]
    half : (3,) float64 array    Half sides of a box about the centre that holds them. [m]
    near : float    Distance from the centre within which the light is not that of a point. [m]
    information_error : float    Relative error for want of rays, of the light in a cell with a 192nd of it. [-]
    far_distances : (k,) float64 array    Distances from the centre. [m]
    far_errors : (k,) float64 array    Relative error of the illuminance there by the light's distribution of intensity. [-]
    spared : float    Relative error that a lux map may have where a point stands for rays within ``near``, as little of the
        light lands there. [-]
    """

    position: np.ndarray
    direction: np.ndarray
    factor: np.ndarray
    threshold: np.ndarray
    other: np.ndarray
    wavelength: np.ndarray | None
    body: RayBody
    axis: np.ndarray | None
    weight: DirectionWeight
    size: float
    half: np.ndarray
    near: float
    information_error: float
    far_distances: np.ndarray = field(default_factory=lambda: np.zeros(0))
    far_errors: np.ndarray = field(default_factory=lambda: np.zeros(0))
    spared: float = SPARED

    @property
    def is_narrow(self) -> bool:
        """Whether directions of a hundredth of the rays or more hardly fluctuate, so that none is found by chance."""
        return recall(self.factor, "narrow", _are_narrow)

    @property
    def open_error(self) -> float:
        """The information error, 0 of rays that hardly fluctuate: none is missing between others. [-]"""
        return 0.0 if self.is_narrow else self.information_error

    def point_errors(self, distances) -> np.ndarray:
        """Relative errors of taking the light for a point, on lines through the logarithms. (n,) [m] -> (n,) [-]"""
        if not len(self.far_distances):
            return np.zeros(np.shape(distances))
        distances = np.maximum(distances, self.far_distances[0])
        errors = np.log(np.maximum(self.far_errors, 1e-9))
        return np.exp(np.interp(np.log(distances), np.log(self.far_distances), errors))


def _are_narrow(factor: np.ndarray) -> bool:
    own = factor[:, 3:, 3:].astype(np.float64)
    if not len(own):
        return True
    # The narrowest of the three widths is along the direction itself.
    across = np.linalg.svd(own, compute_uv=False)
    return bool(np.quantile(np.sqrt(across[:, 0] * across[:, 1]), 0.01) < NARROWEST)
