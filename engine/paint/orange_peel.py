"""Long waves of a paint's surface: the whole film tilts with them, and reflects as each place of it does.

With Gaussian slopes, a wave as wide as many layers are thick turns the frame in which its film scatters; light goes there by
the faces that it sees, without shadows, which slopes of some degrees do not cast:

    f(wi, wo) = E[ (wi . n)(wo . n) / n_z f(wi, wo; n) ] / (cos_i cos_o)

and the mirror of the film becomes the lobe F(c) D(h) / (4 cos_i cos_o).
"""

from itertools import product

import numpy as np

from .orientation import density
from .solution import Solution

FEWEST_TILTS, MOST_TILTS = 5, 13
"""Slopes along each axis by which the film's scattering is averaged."""


def evaluate(solution: Solution, wi, wo) -> np.ndarray:
    """BRDF of a paint with its waves; a smooth one's mirror is not part of it. (n, 3), (n, 3) -> (n, w) [1/sr]"""
    slope = solution.paint.orange_peel
    if slope == 0.0:
        return solution.evaluate(wi, wo)
    wi, wo = np.asarray(wi, np.float64), np.asarray(wo, np.float64)
    places, weights = np.polynomial.hermite_e.hermegauss(_tilts(solution))
    weights = weights / weights.sum()
    total = 0.0
    for (along, first), (across, second) in product(
        zip(places * slope, weights, strict=True), repeat=2
    ):
        frame = _frame(along, across)
        own = [each @ frame.T for each in (wi, wo)]
        faces = np.maximum(own[0][:, 2], 0.0) * np.maximum(own[1][:, 2], 0.0) / frame[2, 2]
        total = total + (first * second * faces)[:, None] * solution.evaluate(*own)
    both = np.maximum(wi[:, 2] * wo[:, 2], 1e-9)
    half = wi + wo
    half = half / np.maximum(np.linalg.norm(half, axis=1, keepdims=True), 1e-12)
    met = np.clip((wi * half).sum(axis=1), 0.0, 1.0)
    shine = density(half[:, 2], slope)[:, None] * solution.mirror(np.sqrt(1.0 - met**2)) / 4.0
    above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
    return np.where(above[:, None], (total + shine) / both[:, None], 0.0)


def _tilts(solution: Solution) -> int:
    slopes = [flakes.slope for layer in solution.layers for flakes in layer.flakes]
    ratio = solution.paint.orange_peel / (min(slopes) if slopes else 1.0)
    return int(min(MOST_TILTS, max(FEWEST_TILTS, 2 * np.ceil(2.0 * ratio) + 3)))


def _frame(along: float, across: float) -> np.ndarray:
    """Rows x, y and the normal of a face with these slopes."""
    normal = np.array([-along, -across, 1.0])
    normal /= np.linalg.norm(normal)
    first = np.array([1.0, 0.0, along])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first), normal])
