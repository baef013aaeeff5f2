"""How much light reaches what lies under a layer, and comes out again, with neither side preferred.

A layer that reflects C(cos_i) leaves T = 1 - C to its base, whose reflectance from a direction should be T(cos_i) times
what it is without the layer. The base's distribution times g(cos_i) g(cos_o) is reciprocal and does that, with the one g
for which

    g(cos_i) * (mean of g over what the base sends out for light from there) = T(cos_i).

Absorption in the layer, t at normal incidence and t^d(cos) on slanted ways, is spread over both ways in the same manner, to
the first order in log t: t^(h(cos_i) + h(cos_o)), where h and its mean over what the base sends out add up to d.

All tables are over the cosine (see `facets`).
"""

from functools import lru_cache

import numpy as np

from .facets import (
    COSINES,
    cosines,
    directional_reflectance,
    fresnel,
    mean_reflectance,
    smith_root,
    visible_facets,
)

ROUNDS = 60
"""Of the iteration for g, each of which halves what is left at least."""


@lru_cache(maxsize=64)
def spreading(alpha: float, eta: float = np.inf, scale: float = 1.0) -> np.ndarray:
    """Where light goes at facets over a white base: shares by the cosine of what leaves, for each that comes. (64, 64) [-]

    ``alpha``, ``eta``: as of `directional_reflectance`; ``scale``: of what facets reflect. Rows add up to 1.
    """
    shares = np.zeros((COSINES, COSINES))
    once = scale * directional_reflectance(alpha, eta)
    if scale > 0.0:
        cos_i, dot, height = visible_facets(alpha)
        cos_o = 2.0 * dot * height - cos_i
        root_i, root_o = smith_root(cos_i, alpha), smith_root(cos_o, alpha)
        seen = cos_o * (cos_i + root_i) / np.maximum(cos_o * root_i + cos_i * root_o, 1e-12)
        mirror = 1.0 if np.isinf(eta) else fresnel(np.clip(dot, 0.0, 1.0), eta)
        weight = np.where(cos_o > 0.0, scale * mirror * seen, 0.0) / dot.shape[1]
        place = np.sqrt(np.clip(cos_o, 0.0, 1.0)) * (COSINES - 1)
        below = np.minimum(place.astype(np.int64), COSINES - 2)
        for row in range(COSINES):
            part = place[row] - below[row]
            for step, share in ((0, 1.0 - part), (1, part)):
                shares[row] += np.bincount(below[row] + step, weight[row] * share, COSINES)
    even = (1.0 - once) * even_shares() / max(1.0 - mean_reflectance(once), 1e-6)
    shares += (1.0 - once)[:, None] * even
    return shares / shares.sum(axis=1, keepdims=True)


@lru_cache(maxsize=1)
def even_shares() -> np.ndarray:
    """Shares of even light by its cosine, which sum a table to its hemispherical mean. (64,) [-]"""
    return np.array([mean_reflectance(row) for row in np.eye(COSINES)])


def passing(left: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """The factor g of one way of light. (64,) [-]

    ``left``: T (64,); ``shares``: as `spreading` has them, or these times what both ways have in common already.
    """
    factor = np.sqrt(np.maximum(left, 1e-9))
    for _ in range(ROUNDS):
        factor = np.sqrt(factor * left / np.maximum(shares @ factor, 1e-9))
    return factor


def slant(eta: float) -> np.ndarray:
    """Length of a way through a layer of an index over that along the normal. (64,) [-]"""
    return 1.0 / np.sqrt(1.0 - (1.0 - cosines().astype(np.float64) ** 2) / eta**2)


def absorbing(lengths: np.ndarray, shares: np.ndarray) -> tuple[np.ndarray, float]:
    """The exponent h of one way, and the mean variance of h over what leaves. (64,), float [-]"""
    exponent = np.linalg.solve(np.eye(COSINES) + shares, lengths)
    variance = shares @ exponent**2 - (shares @ exponent) ** 2
    return exponent, float(np.maximum(variance, 0.0) @ even_shares())
