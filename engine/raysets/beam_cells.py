"""Cells of the sphere around a source that get as much of its light each, however narrow its beam is."""

import numpy as np

BEAM = 0.05
"""Length of the mean direction below which light has no axis of its own, and z is taken."""


class BeamCells:
    """Bands about the axis of the light with equal flux each, cut into equal sectors.

    Parameters
    ----------
    position, direction : (n, 3) array    Rays that tell where the light goes. [m]
    weight : (n,) array    Their flux.
    centre : (3,) array    Of the sphere. [m]
    radius : float    Of the sphere; infinite: cells are those of directions. [m]
    bands, sectors : int
    """

    def __init__(self, position, direction, weight, centre, radius, bands: int, sectors: int):
        self.centre, self.bands, self.sectors = np.asarray(centre, np.float64), bands, sectors
        weight = weight.astype(np.float64)
        mean = weight @ direction.astype(np.float64) / weight.sum()
        length = np.linalg.norm(mean)
        axis = mean / length if length > BEAM else np.array([0.0, 0.0, 1.0])
        first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        first /= np.linalg.norm(first)
        self._frame = np.stack([first, np.cross(axis, first), axis], axis=1)
        height = _height(self._unit(position, direction, radius) @ self._frame)
        order = np.argsort(height)
        steps = np.cumsum(weight[order]) / weight.sum()
        inner = np.searchsorted(steps, np.arange(1, bands) / bands)
        self._edges = height[order][np.minimum(inner, len(order) - 1)]

    def __len__(self) -> int:
        return self.bands * self.sectors

    def numbers(self, position, direction, radius: float) -> np.ndarray:
        """Cells in which rays cross a sphere, or into which they go where it is infinite. (n,)"""
        local = self._unit(position, direction, radius) @ self._frame
        band = np.searchsorted(self._edges, _height(local), side="right")
        turn = np.arctan2(local[:, 1], local[:, 0]) / (2.0 * np.pi) + 0.5
        return band * self.sectors + np.minimum((self.sectors * turn).astype(int), self.sectors - 1)

    def shares(self, position, direction, weight, radius: float) -> np.ndarray:
        """Shares of the light in the cells. (bands x sectors,)"""
        flux = np.bincount(self.numbers(position, direction, radius), weight, len(self))
        return flux / flux.sum()

    def _unit(self, position, direction, radius: float) -> np.ndarray:
        """Where rays cross the sphere, seen from its centre."""
        direction = direction.astype(np.float64)
        if not np.isfinite(radius):
            return direction
        away = position.astype(np.float64) - self.centre
        along = (away * direction).sum(axis=1)
        square = along**2 - (away * away).sum(axis=1) + radius**2
        way = np.sqrt(np.maximum(square, 0.0)) - along
        return (away + way[:, None] * direction) / radius


def _height(local: np.ndarray) -> np.ndarray:
    """Angle from the axis, as a number that loses no digits next to it."""
    return np.arctan2(np.hypot(local[:, 0], local[:, 1]), local[:, 2])
