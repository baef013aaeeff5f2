"""What sensors have of every part of the sky and of the sun at every place: plain data, the same for all weather.

References
----------
P. R. Tregenza, I. M. Waters: Daylight coefficients, Lighting Research and Technology 15(2), 1983, 65-71
D. Bourgeois, C. F. Reinhart, G. Ward: Standard daylight coefficient model for dynamic daylighting simulations, Building
Research and Information 36(1), 2008, 68-82 (the sun apart from the sky)
"""

from dataclasses import dataclass

import numpy as np

from ..accuracy.estimate import Estimate
from ..accuracy.stopping import StopRule
from ..scene.provenance import Provenance

NEIGHBOURS = 3
"""Suns that stand for one together."""


@dataclass(frozen=True)
class DaylightOrder:
    """What is asked for.

    Parameters
    ----------
    suns : (k, 3) float64 array    Unit vectors to the sun, of every hour that has one.
    angle : float    Diameter of the sun's disk. [rad]
    rule : StopRule    ``samples``: paths of every sensor; ``error``: relative standard error of the light of a world that is
        evenly bright all around, root mean square over sensors. The first that is met ends the job.
    steps : int    Rows of the sky, as of `SkyNodes`.
    cells : int    About how many parts surfaces have, on each of which the sun is looked for.
    spacing : float    Suns closer together share what surfaces send on of them. [degree]
    seed : int
    """

    suns: np.ndarray
    angle: float
    rule: StopRule = StopRule(samples=4096)
    steps: int = 15
    cells: int = 2000
    spacing: float = 3.0
    seed: int = 0


@dataclass(frozen=True, eq=False)
class DaylightCoefficients:
    """Answers of all sensors.

    ``g`` independent groups of paths, ``n`` sensors, ``m`` suns that stand for all, ``k`` suns.

    Parameters
    ----------
    steps : int    Rows of the sky.
    sky : (g, n, nodes + 1) float32 array    Illuminance for a luminance of 1 cd/m2 at each node, last of all that is below
        the horizon. [lx m2/cd]
    reflected : (g, n, m) float32 array    Illuminance by the sun over surfaces for 1 lx on a plane that faces it. [-]
    doubts : (d, n, m) float32 array    By how much this may be off beyond what groups show, one cause each. [-]
    reading : (n,) float32 array    What ending paths at cells may change, relative to all light but the sun's own, one
        cause. [-]
    direct, direct_error : (n, k) float32 array    The same by the sun straight, with its standard error. [-]
    neighbours : (k, 3) int array    Which of the ``m`` suns stand for a sun.
    shares : (k, 3) array    What each of them counts, of sum 1. [-]
    samples : int    Paths of every sensor.
    lost : int    Paths that ended with no number.
    provenance : Provenance
    """

    steps: int
    sky: np.ndarray
    reflected: np.ndarray
    doubts: np.ndarray
    reading: np.ndarray
    direct: np.ndarray
    direct_error: np.ndarray
    neighbours: np.ndarray
    shares: np.ndarray
    samples: int
    lost: int
    provenance: Provenance

    @property
    def sensors(self) -> int:
        """Number of sensors."""
        return self.sky.shape[1]

    def error_of_even_world(self) -> float:
        """Relative standard error of the light of an even world, root mean square over sensors. [-]"""
        light = self.sky.sum(axis=2, dtype=np.float64)
        return Estimate.from_groups(light, self.samples).relative_error()


def gather_suns(suns: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return few directions that stand for many.

    Parameters
    ----------
    suns : (k, 3) array    Unit vectors.
    spacing : float    Width of the meshes of which all share one. [degree]

    Returns
    -------
    (m, 3) array, (k, 3) int array, (k, 3) array    Means of the suns of a mesh, which of them stand for each sun, the
        nearest first, and their shares by the inverse square of how far they are from it.
    """
    suns = np.asarray(suns, dtype=np.float64).reshape(-1, 3)
    if not len(suns):
        none = np.zeros((0, 3))
        return none, none.astype(np.int64), none
    elevation = np.degrees(np.arcsin(np.clip(suns[:, 2], -1.0, 1.0)))
    row = np.floor(elevation / spacing).astype(np.int64)
    width = spacing / np.maximum(np.cos(np.radians((row + 0.5) * spacing)), 0.02)
    azimuth = np.degrees(np.arctan2(suns[:, 1], suns[:, 0])) % 360.0
    column = np.floor(azimuth / width).astype(np.int64)
    _, mesh = np.unique(np.stack([row, column]), axis=1, return_inverse=True)
    mesh = mesh.reshape(-1)
    means = np.stack([np.bincount(mesh, suns[:, i]) for i in range(3)], axis=1)
    means /= np.linalg.norm(means, axis=1, keepdims=True)
    squares = np.maximum(2.0 - 2.0 * suns @ means.T, 0.0)
    near = min(NEIGHBOURS, len(means))
    neighbours = np.argsort(squares, axis=1, kind="stable")[:, :near]
    neighbours = np.pad(neighbours, ((0, 0), (0, NEIGHBOURS - near)), mode="edge")
    weights = 1.0 / np.maximum(np.take_along_axis(squares, neighbours, axis=1), 1e-12)
    return means, neighbours, weights / weights.sum(axis=1, keepdims=True)
