"""Points and weights for means over rectangles and integrals over the sphere, where what is measured is smooth."""

import numpy as np


def plane_grid(corner, edge_u, edge_v, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre points of a parallelogram.

    Returns
    -------
    points : (count^2, 3) array
    weights : (count^2,) array    Sum to 1.
    """
    node, weight = np.polynomial.legendre.leggauss(count)
    place, share = 0.5 + 0.5 * node, 0.5 * weight
    corner, u, v = (np.asarray(x, dtype=np.float64) for x in (corner, edge_u, edge_v))
    points = corner + place[:, None, None] * u + place[None, :, None] * v
    return points.reshape(-1, 3), np.outer(share, share).ravel()


def sphere_grid(heights, rings: int, around: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions for an integral over the sphere: Gauss-Legendre in z, evenly around it.

    Parameters
    ----------
    heights : sequence of float    Ends of the panels in z, from -1 to 1.
    rings : int    In each panel.
    around : int    In each ring.

    Returns
    -------
    directions : (n, 3) array
    weights : (n,) array    Sum to 4 pi. [sr]
    """
    node, weight = np.polynomial.legendre.leggauss(rings)
    ends = np.asarray(heights, dtype=np.float64)
    half = 0.5 * np.diff(ends)[:, None]
    z = (0.5 * (ends[1:] + ends[:-1])[:, None] + half * node).ravel()
    share = (half * weight).ravel() * 2.0 * np.pi / around
    # Half a step off the axes, where nothing is special.
    phi = 2.0 * np.pi * (np.arange(around) + 0.5) / around
    flat = np.sqrt(1.0 - z**2)
    directions = np.stack(
        [
            np.outer(flat, np.cos(phi)),
            np.outer(flat, np.sin(phi)),
            np.outer(z, np.ones(around)),
        ],
        axis=-1,
    )
    return directions.reshape(-1, 3), np.repeat(share, around)
