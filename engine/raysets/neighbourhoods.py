"""How wide the gaps between the rays of a set are, in position and direction at once: what fluctuation has to bridge.

A ray is a point with six numbers, its position over the size of the source and its direction. The nearest neighbours of a
ray there tell how far its light may be spread without blurring what the set knows: its fluctuation gets their covariance,
and its middle moves half-way to their mean, which takes back most of what the fluctuation blurs (data sharpening: E. Choi
and P. Hall, Data sharpening as a prelude to density estimation, Biometrika 86, 1999). Covariances are shared by rays that
lie next to each other, so that they cost little memory.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..errors import Cancelled

GROUP = 64
"""Rays that share a covariance."""

COMPARED = 1 << 22
"""Distances that are held at a time."""

FEW = 1 << 14
"""Rays among all of which neighbours are looked for."""

FEWEST, FEWEST_SEARCHED = 48, 1 << 11
"""Neighbours that are looked for in a selection of more rays than that, and the least size of such a selection."""

SPARED = 8
"""One in so many rays tells the covariance of its group."""


@dataclass(frozen=True, eq=False)
class Spread:
    """Rays as middles of what is generated from them.

    Parameters
    ----------
    position : (n, 3) float32 array    [m]
    direction : (n, 3) float32 array    Means of unit vectors, so shorter than those.
    factor : (g, 6, 6) float32 array    Lower triangular: times six standard normal numbers it is the fluctuation of position
        [m] and direction of ``GROUP`` rays in a row.
    """

    position: np.ndarray
    direction: np.ndarray
    factor: np.ndarray


def order_rays(position: np.ndarray, direction: np.ndarray, size: float) -> np.ndarray:
    """Return an order in which rays that are alike stand together: halves by the widest of their six numbers, and so on.

    Parameters
    ----------
    position, direction : (n, 3) array    [m]
    size : float    Of the source. [m]
    """
    place = _place(position, direction, size)
    order = np.arange(len(place))
    left = [(0, len(place))]
    while left:
        first, last = left.pop()
        if last - first <= GROUP:
            continue
        part = order[first:last]
        own = place[part]
        column = own[:, np.argmax(own.var(axis=0))]
        # Whole groups on one side, so that no group is left with strangers.
        middle = GROUP * -(-(last - first) // (2 * GROUP))
        order[first:last] = part[np.argpartition(column, middle)]
        left += [(first, first + middle), (first + middle, last)]
    return order


def spread_rays(
    position: np.ndarray,
    direction: np.ndarray,
    size: float,
    share: float,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Spread:
    """Find the fluctuation of rays that stand in order.

    Parameters
    ----------
    position, direction : (n, 3) array    As `order_rays` has put them. [m]
    size : float    Of the source. [m]
    share : float    Of all rays that are neighbours of one. [-]

    Raises
    ------
    Cancelled
    """
    count = len(position)
    rng = np.random.default_rng(seed)
    place = _place(position, direction, size)
    searched = count if count <= FEW else int(np.clip(FEWEST / share, FEWEST_SEARCHED, FEW))
    wanted = int(np.clip(round(share * searched), min(8, searched), searched))
    middle = np.empty_like(place)
    groups = -(-count // GROUP)
    square, told = np.zeros((groups, 6, 6)), np.zeros(groups)
    # Rays of a block stand far apart, so that what a selection has by chance is not common to neighbours.
    blocks = -(-count * searched // COMPARED)
    for block in range(blocks):
        if cancelled():
            raise Cancelled("cancelled")
        chosen = place if searched == count else place[rng.choice(count, searched, replace=False)]
        rays = np.arange(block, count, blocks)
        tells = rays % SPARED == 0
        mean, covariance = _neighbours(place[rays], chosen, wanted, tells)
        middle[rays] = 0.5 * (place[rays] + mean)
        np.add.at(square, rays[tells] // GROUP, covariance)
        np.add.at(told, rays[tells] // GROUP, 1)
        if progress is not None:
            progress((block + 1) / blocks)
    covariance = square / told[:, None, None]
    # Flat sources do not fluctuate across; a trace of it keeps the factors real.
    covariance += 1e-12 * np.eye(6)
    factor = np.linalg.cholesky(covariance)
    factor[:, :3] *= size
    middle[:, :3] *= size
    return Spread(
        middle[:, :3].astype(np.float32),
        middle[:, 3:].astype(np.float32),
        factor.astype(np.float32),
    )


def _neighbours(own: np.ndarray, chosen: np.ndarray, wanted: int, tells: np.ndarray):
    """Means of the nearest of the chosen ones, and covariances for those that tell. (n, 6), (m, 6) -> (n, 6), (k, 6, 6)"""
    # Near the origin squares lose no digits.
    origin = own.mean(axis=0)
    own, chosen = own - origin, chosen - origin
    distance = (chosen**2).sum(axis=1) - 2.0 * own @ chosen.T
    limit = np.partition(distance, wanted - 1, axis=1)[:, wanted - 1]
    near = (distance <= limit[:, None]).astype(np.float64)
    near /= near.sum(axis=1, keepdims=True)
    mean = near @ chosen
    pairs = (chosen[:, :, None] * chosen[:, None, :]).reshape(len(chosen), 36)
    own = mean[tells]
    covariance = (near[tells] @ pairs).reshape(-1, 6, 6) - own[:, :, None] * own[:, None, :]
    return mean + origin, covariance


def _place(position: np.ndarray, direction: np.ndarray, size: float) -> np.ndarray:
    """Rays as points with six numbers. (n, 6) float64"""
    return np.concatenate([position / size, direction], axis=1, dtype=np.float64)
