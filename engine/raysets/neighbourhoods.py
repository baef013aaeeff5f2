"""How wide the gaps between the rays of a set are, in position and direction at once: what fluctuation has to bridge.

A ray is a point with six numbers, its position over the size of the source and its direction. The nearest neighbours of a
ray there tell how far its light may be spread without blurring what the set knows: its fluctuation gets their covariance,
and its middle moves half-way to their mean, which takes back most of what the fluctuation blurs (data sharpening: E. Choi
and P. Hall, Data sharpening as a prelude to density estimation, Biometrika 86, 1999). Covariances are shared by rays that
lie next to each other, so that they cost little memory.
"""

import os
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..errors import Cancelled
from ..scene.ray_emission import GROUP

COMPARED = 1 << 21
"""Distances that are held at a time."""

FEW = 1 << 14
"""Rays among all of which neighbours are looked for."""

FEWEST, FEWEST_SEARCHED = 48, 1 << 11
"""Neighbours that are looked for in a selection of more rays than that, and the least size of such a selection."""

MOST_THREADS = 8
"""Blocks in work at a time; NumPy lets threads run while it sorts and multiplies."""

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
    place = _place(position, direction, size)
    searched = count if count <= FEW else int(np.clip(FEWEST / share, FEWEST_SEARCHED, FEW))
    wanted = int(np.clip(round(share * searched), min(8, searched), searched))
    middle = np.empty_like(place)
    groups = -(-count // GROUP)
    square, told = np.zeros((groups, 6, 6)), np.zeros(groups)
    # Rays of a block stand far apart, so that what a selection has by chance is not common to neighbours.
    blocks = -(-count * searched // COMPARED)

    def search(block: int):
        if cancelled():
            raise Cancelled("cancelled")
        rng = np.random.default_rng([seed & 0xFFFFFFFF, block])
        chosen = place if searched == count else place[rng.choice(count, searched, replace=False)]
        rays = np.arange(block, count, blocks)
        tells = rays % SPARED == 0
        return rays, tells, *_neighbours(place[rays], chosen, wanted, tells)

    # A few blocks are in work at a time, and what they find is taken in their order.
    for block, (rays, tells, mean, covariance) in enumerate(_map_ahead(search, blocks)):
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


def _map_ahead(work: Callable, count: int):
    """Yield what ``work(0)``, ``work(1)`` ... return, in order, while threads work ahead."""
    threads = min(os.cpu_count() or 1, MOST_THREADS, count)
    with ThreadPoolExecutor(threads) as pool:
        coming = deque(pool.submit(work, number) for number in range(min(threads + 1, count)))
        for number in range(count):
            found = coming.popleft().result()
            if number + threads + 1 < count:
                coming.append(pool.submit(work, number + threads + 1))
            yield found


def _neighbours(own: np.ndarray, chosen: np.ndarray, wanted: int, tells: np.ndarray):
    """Means of the nearest of the chosen ones, and covariances for those that tell. (n, 6), (m, 6) -> (n, 6), (k, 6, 6)"""
    # Near the origin squares lose few digits, and single precision is enough to tell who is near.
    origin = own.mean(axis=0)
    exact = chosen - origin
    own, chosen = (own - origin).astype(np.float32), exact.astype(np.float32)
    distance = (chosen**2).sum(axis=1) - 2.0 * own @ chosen.T
    limit = np.partition(distance, wanted - 1, axis=1)[:, wanted - 1]
    near = (distance <= limit[:, None]).astype(np.float32)
    near /= near.sum(axis=1, keepdims=True)
    mean = near @ chosen
    # Covariances keep double precision: those of flat sources are singular, and must not become indefinite.
    share = near[tells].astype(np.float64)
    pairs = (exact[:, :, None] * exact[:, None, :]).reshape(len(exact), 36)
    middle = share @ exact
    square = (share @ pairs).reshape(-1, 6, 6)
    scale = share.sum(axis=1)[:, None, None]
    covariance = square / scale - middle[:, :, None] * middle[:, None, :] / scale**2
    return mean + origin, covariance


def _place(position: np.ndarray, direction: np.ndarray, size: float) -> np.ndarray:
    """Rays as points with six numbers. (n, 6) float64"""
    return np.concatenate([position / size, direction], axis=1, dtype=np.float64)
