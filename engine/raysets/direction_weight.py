"""What generated rays count for by their direction, so that light that fluctuation blurs goes where the file's rays go.

Where directions end, at the horizon of a flat source or the edge of a beam, fluctuation takes light away and moves it
inwards, by several percent. So generated rays are weighed twice: by bands about the axis of the light, where the set has
rays enough to tell that a band has too much or too little; and by a polynomial that gives all directions the mean and the
second moments of the file's.
"""

import numpy as np

from ..scene.ray_emission import (
    BANDS,
    LARGEST_WEIGHT,
    LEAST_WEIGHT,
    DirectionWeight,
    direction_basis,
)

BEAM = 0.05
"""Length of the mean direction below which light has no axis of its own, and z is taken."""

COARSEST = 4
"""Bands of the first comparison; each further one has twice as many, up to `BANDS`."""

SURE = 2.0
"""Standard errors by which light in a band must differ to be weighed otherwise. [-]"""


def fit_weight(
    made: np.ndarray, direction: np.ndarray, weight: np.ndarray, axis=None
) -> DirectionWeight:
    """Find the weight by direction.

    Parameters
    ----------
    made : (m, 3) array    Directions of generated rays, that all count as much.
    direction, weight : (n, 3), (n,) array    Of the file's rays.
    axis : (3,) array or None    About which there are bands; None: the mean direction, where there is one.
    """
    weight = weight.astype(np.float64) / weight.sum(dtype=np.float64)
    direction = direction.astype(np.float64)
    if axis is None:
        mean = weight @ direction
        length = float(np.linalg.norm(mean))
        axis = mean / length if length > BEAM else (0.0, 0.0, 1.0)
    found = DirectionWeight.even(axis, _middle_of(direction - np.asarray(axis), weight))
    found = _with_bands(found, _fit_bands(found, made, direction, weight), np.zeros(9))
    found = _with_bands(found, found.bands, _match_moments(found, made, direction, weight))
    return _with_bands(found, found.bands, found.moments, float(found.of(made).mean()))


# ---- private ----


def _with_bands(weight: DirectionWeight, bands, moments, mean: float = 1.0) -> DirectionWeight:
    return DirectionWeight(weight.axis, weight.middle, bands, moments, mean)


def _middle_of(apart: np.ndarray, weight: np.ndarray) -> float:
    """Square of the tangent of half the angle within which half of the light goes. [-]

    ``apart``: directions less the axis. (n, 3)
    """
    off = 0.5 * (apart**2).sum(axis=1)
    order = np.argsort(off)
    half = off[order[np.searchsorted(np.cumsum(weight[order]), 0.5).clip(max=len(order) - 1)]]
    return float(np.clip(half / max(2.0 - half, 1e-12), 1e-12, 1e12))


def _fit_bands(even: DirectionWeight, made, direction, weight) -> np.ndarray:
    """Factor at the edges of the bands. (BANDS + 1,)

    From few wide bands to many narrow ones, each comparison with what the ones before have put right: what is alike over
    many bands is known better than what is not. A difference d that chance scatters by s counts with 1 - (2 s / d)^2.
    """
    edges = np.arange(BANDS + 1)
    places = even.place(made), even.place(direction)
    bands = np.ones(BANDS + 1)
    wide = COARSEST
    while wide <= BANDS:
        step = BANDS // wide
        counts = np.interp(places[0], edges, bands)
        own = _tell_shares(places[0] / step, counts / counts.sum(), wide)
        asked = _tell_shares(places[1] / step, weight, wide)
        # Of both the variance by chance, as of independent rays.
        chance = sum(
            _tell_shares(place / step, share**2, wide, square=True)
            for place, share in ((places[0], counts / counts.sum()), (places[1], weight))
        )
        apart = asked - own
        kept = np.maximum(1.0 - SURE**2 * chance / np.maximum(apart**2, 1e-300), 0.0)
        factor = 1.0 + kept * apart / np.maximum(own, 1e-300)
        factor = np.clip(factor, LEAST_WEIGHT, LARGEST_WEIGHT)
        bands = bands * np.interp(edges / step, np.arange(wide + 1), factor)
        wide *= 2
    return np.clip(bands, LEAST_WEIGHT, LARGEST_WEIGHT)


def _tell_shares(
    place: np.ndarray, share: np.ndarray, wide: int, square: bool = False
) -> np.ndarray:
    """Light about the edges of bands, falling linearly to the next ones. (n,), (n,) -> (wide + 1,)

    ``square``: sum of the squares of these parts instead.
    """
    lower = np.minimum(place.astype(np.int64), wide - 1)
    upper = place - lower
    parts = (1.0 - upper, upper)
    if square:
        parts = tuple(part**2 for part in parts)
    return np.bincount(lower, parts[0] * share, wide + 1) + np.bincount(
        lower + 1, parts[1] * share, wide + 1
    )


def _match_moments(bands: DirectionWeight, made, direction, weight) -> np.ndarray:
    """Coefficients of the polynomial that gives all directions the moments that those of the rays have. (9,)"""
    counts = bands.of(made)
    counts /= counts.sum()
    basis = direction_basis(made)
    wanted = weight @ direction_basis(direction) - counts @ basis
    values, vectors = np.linalg.eigh(basis.T @ (counts[:, None] * basis))
    kept = values > 1e-4 * values[-1]
    vectors, values = vectors[:, kept], values[kept]
    return vectors @ ((vectors.T @ wanted) / values)
