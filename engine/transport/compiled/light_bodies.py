"""Bodies of lamps: what a `SurfacePool` has to know of a shape, and places on it."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Sphere:
    """``centre`` (3,) in the scene's frame and ``radius``. [m]"""

    centre: np.ndarray
    radius: float
    sine = 1.0

    def put_into(self, pool, number: int) -> None:
        """Tell a `SurfacePool` about the shape."""
        pool.add_sphere(number, self.centre)

    def places(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """Points and normals (n, 3), evenly by area for even numbers (n,) in [0, 1), and the area. [m, -, m2]"""
        z, (sine, cosine) = 2.0 * u - 1.0, _around(v)
        plan = np.sqrt(np.maximum(1.0 - z * z, 0.0))
        normal = np.stack([plan * cosine, plan * sine, z], axis=1)
        return self.centre + self.radius * normal, normal, 4.0 * np.pi * self.radius**2


@dataclass(frozen=True, eq=False)
class Flat:
    """Rectangle or ellipse that shines to one side.

    Parameters
    ----------
    frame : (4, 4) array    Rigid placement in the scene's frame; it shines along local -z. [m]
    size_x, size_y, area : float    Full width and height [m], and the luminous area. [m2]
    is_ellipse : bool
    spread : float    Of the beam; pi is Lambertian. [rad]
    """

    frame: np.ndarray
    size_x: float
    size_y: float
    area: float
    is_ellipse: bool
    spread: float

    @property
    def sine(self) -> float:
        """Sine of the largest angle to the normal at which it shines."""
        return float(np.sin(0.5 * min(self.spread, np.pi)))

    def put_into(self, pool, number: int) -> None:
        """As of `Sphere`."""
        pool.add_flat(number, -self.frame[:3, 2])

    def places(self, u, v):
        """As of `Sphere`."""
        x, y = u - 0.5, v - 0.5
        if self.is_ellipse:
            sine, cosine = _around(v)
            x, y = 0.5 * np.sqrt(u) * cosine, 0.5 * np.sqrt(u) * sine
        points = self.frame[:3, 3] + np.outer(x * self.size_x, self.frame[:3, 0])
        points += np.outer(y * self.size_y, self.frame[:3, 1])
        return points, np.broadcast_to(-self.frame[:3, 2], points.shape), self.area


@dataclass(frozen=True, eq=False)
class Tube:
    """Curved side of a cylinder.

    Parameters
    ----------
    frame : (4, 4) array    Rigid placement of its middle in the scene's frame; it lies along local x. [m]
    length, radius : float    [m]
    """

    frame: np.ndarray
    length: float
    radius: float
    sine = 1.0

    @property
    def start(self) -> np.ndarray:
        """Middle of the end from which it goes along its axis. (3,) [m]"""
        return self.frame[:3, 3] - 0.5 * self.length * self.frame[:3, 0]

    def put_into(self, pool, number: int) -> None:
        """As of `Sphere`."""
        pool.add_tube(number, self.frame[:3, 3], self.frame[:3, 0])

    def places(self, u, v):
        """As of `Sphere`."""
        sine, cosine = _around(v)
        normal = np.outer(cosine, self.frame[:3, 1]) + np.outer(sine, self.frame[:3, 2])
        points = self.start + np.outer(u * self.length, self.frame[:3, 0]) + self.radius * normal
        return points, normal, 2.0 * np.pi * self.radius * self.length


def _around(v):
    """Sine and cosine of a share of a whole turn."""
    return np.sin(2.0 * np.pi * v), np.cos(2.0 * np.pi * v)
