"""Noisy values on a hemisphere, with holes, made smooth: penalised splines of the logarithm, all bands together.

Coordinates are the radial angle from the mirror direction, as its square root, and the azimuth about it, in which both sides
of the plane of incidence are alike. The logarithm is a sum of cubic B-splines times cosines of multiples of the azimuth. How
smooth it is along each is chosen by generalised cross-validation. Bands share their shapes: a few of them, as many as stand
out of the noise.

References
----------
Eilers & Marx, Flexible smoothing with B-splines and penalties, doi:10.1214/ss/1038425655
Golub, Heath & Wahba, Generalized cross-validation, doi:10.1080/00401706.1979.10489751
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

INTERVALS = 26
"""Of the splines along the square root of the radial angle, at most."""

MULTIPLES = 6
"""Of the azimuth, of which cosines are summed up."""

LAMBDAS = 10.0 ** np.arange(-5.0, 4.1, 1.0)
"""Weights of roughness along the radial angle that are tried."""

TURN_LAMBDAS = 10.0 ** np.arange(-5.0, 4.1, 1.5)
"""Weights of roughness along the azimuth that are tried."""

MOST_SHAPES = 5
"""Shapes that bands share."""

ROUNDS = 3
"""In which holes of single bands are filled from the others."""

SMALLEST = 1e-3
"""Share of the median that is added before the logarithm is taken."""

PEAK_STIFFNESS = 1e-2
"""Factor on the roughness within twice the instrument's resolution of the mirror direction."""

FEWEST_LEFT = 0.05
"""Share of the measured directions that must be left when the degrees of freedom are taken off."""

HEADROOM = 0.3
"""By how much the logarithm may leave the range of the measured directions."""


@dataclass(frozen=True, eq=False)
class SmoothSlice:
    """A smooth function of directions.

    Parameters
    ----------
    knots : (k,) float64 array    Evenly spaced, of the square root of the radial angle. [sqrt(rad)]
    coefficients : (c, w) float64 array    Of splines times cosines, the cosines of each spline together.
    added : float    Added before the logarithm. [1/sr]
    low, high : (w,) float64 arrays    Range of the logarithm.
    residual : (d, w) float64 array    Of the logarithm at the measured directions: what was left out; nan at holes.
    noise : float    Standard deviation of the logarithm of one measured value. [-]
    error : float    That of the smooth function at the measured directions, root mean square. [-]
    """

    knots: np.ndarray
    coefficients: np.ndarray
    added: float
    low: np.ndarray
    high: np.ndarray
    residual: np.ndarray
    noise: float
    error: float

    def read(self, radial, azimuth) -> np.ndarray:
        """Values in directions. (n,), (n,) -> (n, w) [1/sr]"""
        made = _design(self.knots, radial, azimuth) @ self.coefficients
        return np.maximum(np.exp(np.clip(made, self.low, self.high)) - self.added, 0.0)


def smooth_slice(radial, azimuth, values, variance, resolution: float = 0.0) -> SmoothSlice:
    """Fit a smooth function to measured values and fill what is missing.

    Parameters
    ----------
    radial, azimuth : (d,) arrays    Directions about the mirror direction. [rad]
    values : (d, w) array    Positive; nan where nothing was measured. Something is for every band. [1/sr]
    variance : (d, w) array    Relative; only ratios count. [-]
    resolution : float    Of the instrument: the peak is not smoothed within twice of it. [rad]
    """
    added = SMALLEST * float(np.nanmedian(values))
    with np.errstate(invalid="ignore"):
        relative = variance * (values / (values + added)) ** 2
        # The logarithm of a noisy value is too low by half its variance.
        target = np.log(values + added) + 0.5 * relative
    used = np.isfinite(target).any(axis=1)
    radial, azimuth, target, relative = (m[used] for m in (radial, azimuth, target, relative))
    known = np.isfinite(target)
    weight = 1.0 / np.maximum(np.nanmean(relative, axis=1), 1e-12)
    weight /= weight.mean()
    count = int(np.clip(len(np.unique(np.round(radial, 4))), 4, INTERVALS))
    step = np.sqrt(max(radial.max(), 0.01)) / count
    knots = step * np.arange(-3, count + 4)
    fitter = _Fitter(_design(knots, radial, azimuth), weight, _penalties(knots, resolution))
    filled = _fill_bands(target, known)
    weights = fitter.choose(filled)
    for _ in range(ROUNDS):
        coefficients, freedom = fitter.solve(filled, weights)
        coefficients, shapes = _share_shapes(fitter, coefficients, filled, freedom)
        made = fitter.design @ coefficients
        if known.all():
            break
        filled = np.where(known, target, made)
    residual = np.full(values.shape, np.nan)
    residual[used] = np.where(known, target - made, np.nan)
    bands = target.shape[1]
    parameters = shapes * (freedom + bands - shapes)
    left = max(known.sum() - parameters, 0.1 * known.sum())
    noise = float(np.sqrt(np.nansum(weight[:, None] * residual[used] ** 2) / left))
    return SmoothSlice(
        knots,
        coefficients,
        added,
        made.min(axis=0) - HEADROOM,
        made.max(axis=0) + HEADROOM,
        residual,
        noise,
        noise * float(np.sqrt(min(parameters / known.sum(), 1.0))),
    )


def _splines(knots, at) -> np.ndarray:
    """Cubic B-splines of evenly spaced knots; the ends hold. (n,) -> (n, k - 4)"""
    step = knots[1] - knots[0]
    place = (np.clip(at, knots[3], knots[-4]) - knots[0]) / step
    away = np.abs(place[:, None] - np.arange(2, len(knots) - 2))
    inner = 2.0 / 3.0 - away**2 + 0.5 * away**3
    outer = np.maximum(2.0 - away, 0.0) ** 3 / 6.0
    return np.where(away < 1.0, inner, outer)


def _design(knots, radial, azimuth) -> np.ndarray:
    """Splines of the square root of radial angles times cosines of multiples of azimuths. (n, c)"""
    splines = _splines(knots, np.sqrt(radial))
    cosines = np.cos(np.asarray(azimuth)[:, None] * np.arange(MULTIPLES + 1))
    return (splines[:, :, None] * cosines[:, None, :]).reshape(len(splines), -1)


def _penalties(knots, resolution: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Roughness along the radial angle, along the azimuth, and what must vanish at the mirror direction. (c, c) each"""
    count = len(knots) - 4
    second = np.diff(np.eye(count), 2, axis=0)
    middle = knots[3 : count + 1]
    stiff = np.where(middle < np.sqrt(2.0 * resolution), PEAK_STIFFNESS, 1.0)
    multiples = np.arange(MULTIPLES + 1.0)
    along = np.kron(second.T @ (stiff[:, None] * second), np.eye(MULTIPLES + 1))
    around = np.kron(np.eye(count), np.diag(multiples**4))
    # The mirror direction has no azimuth.
    centre = _splines(knots, np.zeros(1))
    pole = np.kron(centre.T @ centre, np.diag((multiples > 0.0).astype(float)))
    return along, around, pole


class _Fitter:
    """Weighted least squares with penalties for several bands that share directions and weights."""

    def __init__(self, design, weight, penalties):
        self.design = design
        self.weight = weight
        self.weighted = design * weight[:, None]
        self.normal = design.T @ self.weighted
        self.along, self.around, self.pole = penalties
        # Weights of roughness are told relative to that of the data.
        self.unit = np.trace(self.normal) / len(self.normal)

    def choose(self, target) -> tuple[float, float]:
        """Weights of roughness along the radial angle and the azimuth with the best cross-validation."""
        scores = {}
        for pair in product(LAMBDAS, TURN_LAMBDAS):
            made, freedom = self.solve(target, pair)
            square = (self.weight[:, None] * (target - self.design @ made) ** 2).sum()
            left = max(len(target) - freedom, FEWEST_LEFT * len(target))
            scores[pair] = square / left**2
        return min(scores, key=scores.get)

    def solve(self, target, weights: tuple[float, float]) -> tuple[np.ndarray, float]:
        """Coefficients (c, w) and their degrees of freedom."""
        radial, turn = weights
        system = self.normal + self.unit * (
            radial * self.along + turn * self.around + 1e3 * self.pole
        )
        # What no datum and no roughness tells is held at nothing.
        system[np.diag_indices_from(system)] += 1e-9 * self.unit
        right = self.weighted.T @ target
        solved = np.linalg.solve(system, np.concatenate([right, self.normal], axis=1))
        bands = target.shape[1]
        return solved[:, :bands], float(np.trace(solved[:, bands:]))


def _fill_bands(target, known) -> np.ndarray:
    """Holes of single bands filled with the mean shape of the bands. (d, w)"""
    level = np.nanmean(target, axis=0)
    shape = np.nanmean(target - level, axis=1)
    return np.where(known, target, shape[:, None] + level)


def _share_shapes(fitter, coefficients, target, freedom: float) -> tuple[np.ndarray, int]:
    """Coefficients with as many shapes as stand out of the noise, and how many these are."""
    bands = coefficients.shape[1]
    if bands == 1:
        return coefficients, 1
    root = np.sqrt(fitter.weight)[:, None]
    made = root * (fitter.design @ coefficients)
    spread = root * target - made
    noise = np.sqrt((spread**2).sum() / (max(len(target) - freedom, 1.0) * bands))
    _, sizes, spectra = np.linalg.svd(made, full_matrices=False)
    # Largest singular value of noise alone on so many degrees of freedom.
    limit = noise * (np.sqrt(freedom) + np.sqrt(bands))
    shapes = int(np.clip(np.count_nonzero(sizes > limit), 1, min(MOST_SHAPES, bands)))
    kept = spectra[:shapes]
    return coefficients @ kept.T @ kept, shapes
