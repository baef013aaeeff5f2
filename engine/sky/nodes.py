"""Nodes on the sky between which luminances are linear: what paths that leave a scene are scattered into.

Nodes lie in rows of one elevation, `steps` rows from the horizon to the zenith, each with about as many nodes as make them
equally far from each other. Between rows, and between neighbours in a row, everything is linear. So a path that leaves in
some direction counts for the four nodes around it, and a sky's light at a sensor is the sum over nodes of the sky's value
there times what the sensor has from there (its daylight coefficient). Patches of even luminance would be off by more: what
is linear between nodes is off in proportion to the square of their distance, not to the distance.

References
----------
P. R. Tregenza, I. M. Waters: Daylight coefficients, Lighting Research and Technology 15(2), 1983, 65-71
"""

from functools import lru_cache

import numpy as np

FEWEST_STEPS, MOST_STEPS = 4, 60
"""Rows of a sky."""

BETWEEN = 2
"""Directions of quadrature between two rows, and between neighbours in a row."""


class SkyNodes:
    """Nodes of the upper hemisphere.

    Parameters
    ----------
    steps : int    Rows from the horizon to the zenith.

    Attributes
    ----------
    counts, starts : (steps + 1,) int array    Nodes of every row, and the number of its first one.
    count : int    Of all nodes. What lies below the horizon is one more, behind them.
    """

    def __init__(self, steps: int):
        if not FEWEST_STEPS <= steps <= MOST_STEPS:
            raise ValueError(f"{steps} rows of a sky, expected {FEWEST_STEPS} to {MOST_STEPS}")
        self.steps = steps
        elevations = 0.5 * np.pi * np.arange(steps + 1) / steps
        self.counts = np.maximum(np.round(4 * steps * np.cos(elevations)).astype(int), 1)
        self.starts = np.concatenate([[0], np.cumsum(self.counts)[:-1]])
        self.count = int(self.counts.sum())

    def directions(self) -> np.ndarray:
        """Unit vectors to the nodes. (count, 3)"""
        row = np.repeat(np.arange(self.steps + 1), self.counts)
        turn = (np.arange(self.count) - self.starts[row]) / self.counts[row]
        return unit_vectors(0.5 * np.pi * row / self.steps, 2.0 * np.pi * turn)

    def locate(self, directions) -> tuple[np.ndarray, np.ndarray]:
        """Return the four nodes around directions and what they count there.

        Parameters
        ----------
        directions : (n, 3) array    Unit vectors; those below the horizon are taken at it.

        Returns
        -------
        (n, 4) int array and (n, 4) array    The latter of sum 1.
        """
        x, y, z = np.asarray(directions, dtype=np.float64).T
        height = np.arctan2(np.maximum(z, 0.0), np.hypot(x, y)) * (2.0 * self.steps / np.pi)
        row = np.minimum(height.astype(int), self.steps - 1)
        upper = height - row
        turn = np.arctan2(y, x) / (2.0 * np.pi) % 1.0
        nodes, weights = [], []
        for above, share in ((0, 1.0 - upper), (1, upper)):
            count = self.counts[row + above]
            place = turn * count
            left = np.minimum(place.astype(int), count - 1)
            for aside, part in ((0, 1.0 - (place - left)), (1, place - left)):
                nodes.append(self.starts[row + above] + (left + aside) % count)
                weights.append(share * part)
        return np.stack(nodes, axis=1), np.stack(weights, axis=1)

    def spread(self, directions) -> np.ndarray:
        """Return what nodes count in directions, as a matrix. (n, count)"""
        nodes, weights = self.locate(directions)
        made = np.zeros((len(nodes), self.count))
        np.add.at(made, (np.arange(len(nodes))[:, None], nodes), weights)
        return made


def unit_vectors(elevation, azimuth) -> np.ndarray:
    """Return unit vectors; the azimuth is from +x to +y. [rad], (...), (...) -> (..., 3)"""
    plan = np.cos(elevation)
    return np.stack([plan * np.cos(azimuth), plan * np.sin(azimuth), np.sin(elevation)], axis=-1)


class Projection:
    """From luminances of many directions to those values of nodes that stand for them best.

    Values are chosen so that what is left of a sky is at right angles to everything that is linear between the nodes (least
    squares over the solid angle). So light that comes evenly or linearly from all around is exact whatever the sky.

    Parameters
    ----------
    nodes : SkyNodes

    Attributes
    ----------
    directions : (q, 3) array    In which luminances are asked for.
    areas : (q,) array    Solid angles that they stand for. [sr]
    node_areas : (count,) array    Solid angle of every node. [sr]
    """

    def __init__(self, nodes: SkyNodes):
        self.directions, self.areas = _quadrature(nodes)
        self._spread = nodes.spread(self.directions).astype(np.float32)
        self.node_areas = self.areas @ self._spread
        gram = self._spread.T.astype(np.float64) @ (self._spread * self.areas[:, None])
        self._inverse = np.linalg.inv(gram).astype(np.float32)

    def project(self, luminances: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return values of nodes, and means around them, which differ by about what nodes do not resolve.

        Parameters
        ----------
        luminances : (n, q) array    [cd/m2]

        Returns
        -------
        (n, count), (n, count) float32 array    [cd/m2]
        """
        moments = (luminances * self.areas.astype(np.float32)) @ self._spread
        return moments @ self._inverse, moments / self.node_areas.astype(np.float32)


@lru_cache(maxsize=4)
def find_projection(steps: int) -> Projection:
    """Return the projection onto the nodes of a sky of so many rows."""
    return Projection(SkyNodes(steps))


def _quadrature(nodes: SkyNodes) -> tuple[np.ndarray, np.ndarray]:
    """Directions and solid angles: Gauss between rows, evenly in azimuth."""
    place, width = np.polynomial.legendre.leggauss(BETWEEN)
    directions, areas = [], []
    step = 0.5 * np.pi / nodes.steps
    for row in range(nodes.steps):
        count = BETWEEN * int(max(nodes.counts[row], nodes.counts[row + 1]))
        azimuth = 2.0 * np.pi * (np.arange(count) + 0.5) / count
        low, high = np.sin(row * step), np.sin((row + 1) * step)
        for point, share in zip(place, width, strict=True):
            # Even in the sine of the elevation, as solid angles are.
            sine = 0.5 * (low + high + (high - low) * point)
            directions.append(unit_vectors(np.full(count, np.arcsin(sine)), azimuth))
            areas.append(np.full(count, np.pi * share * (high - low) / count))
    return np.concatenate(directions), np.concatenate(areas)
