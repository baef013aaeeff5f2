"""The surface that rays start from, found from their starting points: a flat piece, a sphere, or a hull around all of them.

Rays that are made from others start where those would have: not inside the body that sent them, whose own mesh would stop
them, and not beyond it, where they would miss what stands close by.
"""

from dataclasses import dataclass

import numpy as np

FLAT = 1e-3
"""Largest distance from a plane, over the extent of the points, of points that lie in it."""

ROUND = 5e-3
"""Largest distance from a sphere, over its radius, of points that lie on it."""

SLABS = 40
"""Directions in which a hull is bounded."""


@dataclass(frozen=True, eq=False)
class Hull:
    """A convex body around all starting points: those with ``low`` <= ``normals`` . p <= ``high``. (k, 3), (k,) [m]"""

    normals: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def keep(self, position: np.ndarray) -> np.ndarray:
        """Bring points that lie outside back inside, mirrored at the side that they have left. (n, 3) [m]"""
        position = position.copy()
        for normal, low, high in zip(self.normals, self.low, self.high, strict=True):
            height = position @ normal
            out = np.flatnonzero((height > high) | (height < low))
            if len(out):
                was = height[out]
                mirrored = np.where(was > high, 2.0 * high - was, 2.0 * low - was)
                shift = np.clip(mirrored, low, high) - was
                position[out] += shift[:, None] * normal
        return position

    def place(self, position: np.ndarray, direction: np.ndarray):
        """Put rays where their lines leave the hull. (n, 3) [m], (n, 3) -> the same"""
        position = self.keep(position)
        leave = np.full(len(position), np.inf)
        for normal, low, high in zip(self.normals, self.low, self.high, strict=True):
            height, rate = position @ normal, direction @ normal
            way = np.where(rate > 0.0, high - height, low - height)
            with np.errstate(divide="ignore", invalid="ignore"):
                leave = np.fmin(leave, np.where(np.abs(rate) > 1e-9, way / rate, np.inf))
        return position + np.maximum(leave, 0.0)[:, None] * direction, direction

    def describe(self) -> str:
        """Say what it is."""
        size = 1e3 * (self.high - self.low)[:3]
        return f"a body of {size[0]:.3g} x {size[1]:.3g} x {size[2]:.3g} mm"


@dataclass(frozen=True, eq=False)
class Plane:
    """A flat source.

    Parameters
    ----------
    centre : (3,) float64 array    [m]
    normal : (3,) float64 array    On the side to which the light goes.
    is_one_sided : bool    Whether all of it goes to that side.
    edge : Hull    Around the points, within the plane.
    """

    centre: np.ndarray
    normal: np.ndarray
    is_one_sided: bool
    edge: Hull

    def place(self, position: np.ndarray, direction: np.ndarray):
        """Put rays onto the surface. (n, 3) [m], (n, 3) -> the same"""
        height = (position - self.centre) @ self.normal
        position = self.edge.keep(position - height[:, None] * self.normal)
        if self.is_one_sided:
            cosine = direction @ self.normal
            direction = direction - 2.0 * np.minimum(cosine, 0.0)[:, None] * self.normal
        return position, direction

    def describe(self) -> str:
        """Say what it is."""
        return "flat, one side" if self.is_one_sided else "flat, both sides"


@dataclass(frozen=True, eq=False)
class Sphere:
    """A sphere from which light goes outwards. ``centre`` (3,), ``radius`` [m]."""

    centre: np.ndarray
    radius: float

    def place(self, position: np.ndarray, direction: np.ndarray):
        """Put rays where their lines leave the sphere; those that pass it by start at its nearest point."""
        away = position - self.centre
        b = (away * direction).sum(axis=1)
        inside = b * b - (away * away).sum(axis=1) + self.radius**2
        away = away + (np.sqrt(np.maximum(inside, 0.0)) - b)[:, None] * direction
        length = np.linalg.norm(away, axis=1, keepdims=True)
        return self.centre + away * (self.radius / np.maximum(length, 1e-30)), direction

    def describe(self) -> str:
        """Say what it is."""
        return f"a sphere of {2e3 * self.radius:.3g} mm"


def find_body(position: np.ndarray, direction: np.ndarray) -> Plane | Sphere | Hull:
    """Find the surface of origin of rays. (n, 3) [m], (n, 3) unit vectors"""
    position = position.astype(np.float64)
    centre = position.mean(axis=0)
    away = position - centre
    size = np.abs(away).max()
    normal = np.linalg.eigh(away.T @ away / len(away))[1][:, 0]
    if np.abs(away @ normal).max() <= FLAT * max(size, 1e-9):
        cosine = direction @ normal
        if cosine.sum() < 0.0:
            normal, cosine = -normal, -cosine
        return Plane(centre, normal, bool(cosine.min() >= -1e-6), _fit_edge(position, normal))
    sphere = _fit_sphere(position)
    if sphere is not None:
        outward = ((position - sphere.centre) * direction).sum(axis=1)
        if outward.min() >= -1e-3 * sphere.radius:
            return sphere
    return fit_hull(position)


def fit_hull(position: np.ndarray) -> Hull:
    """Return the hull of points: a box along the axes, cut by planes spread evenly over all directions."""
    number = np.arange(SLABS - 3) + 0.5
    height = number / (SLABS - 3)
    turn = np.pi * (1.0 + 5.0**0.5) * number
    width = np.sqrt(1.0 - height**2)
    spread = np.stack([width * np.cos(turn), width * np.sin(turn), height], axis=1)
    normals = np.concatenate([np.eye(3), spread])
    return _bound(position, normals)


def _fit_edge(position: np.ndarray, normal: np.ndarray) -> Hull:
    """Return the hull of points within their plane."""
    first = np.linalg.svd(normal[None])[2][1]
    second = np.cross(normal, first)
    turn = np.pi * np.arange(SLABS // 2) / (SLABS // 2)
    return _bound(position, np.outer(np.cos(turn), first) + np.outer(np.sin(turn), second))


def _bound(position: np.ndarray, normals: np.ndarray) -> Hull:
    heights = position @ normals.T
    return Hull(normals, heights.min(axis=0), heights.max(axis=0))


def _fit_sphere(position: np.ndarray) -> Sphere | None:
    """Return the sphere on which points lie, by least squares; None where they do not."""
    middle = position.mean(axis=0)
    away = position - middle
    scale = np.abs(away).max()
    system = np.concatenate([2.0 * away / scale, np.ones((len(away), 1))], axis=1)
    solution, _, rank, _ = np.linalg.lstsq(system, ((away / scale) ** 2).sum(axis=1), rcond=None)
    if rank < 4:
        return None
    square = solution[3] + (solution[:3] ** 2).sum()
    if not square > 0.0:
        return None
    centre, radius = middle + scale * solution[:3], scale * float(np.sqrt(square))
    apart = np.abs(np.linalg.norm(position - centre, axis=1) - radius)
    return Sphere(centre, radius) if apart.max() <= ROUND * radius else None
