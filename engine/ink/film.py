"""What realisations come to: the share of light that goes on as one wave, and how the rest is spread over directions.

Directions are told by their tangential part s (n sin theta; the cell's orders lie lambda / L apart in it), in which
scattering of power per d2s is symmetric between both ways and the same as a BRDF in air. Orders are single samples of
speckle, exponentially distributed about the mean, so the mean is what is fitted: a series of few terms in both cosines
and the azimuth, symmetric where reciprocity wants it, by least squares, which keeps totals.

The power of the order that goes on is that of the coherent wave and what is scattered there: the latter follows from the
orders about it.

How well a kernel is known follows from the same speckle: a sample v of mean m scatters by m, and v^2 / 2 is m^2 on the mean.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .composition import Ink
from .ensemble import Ensemble
from .plan import Plan
from .realisation import SIDES

SAMPLES_PER_TERM = 2
"""Orders that it takes at least."""

DEGREES = (3, 2, 1, 0)
"""Largest sum of both cosines' degrees, by the mode of the azimuth."""


@dataclass(frozen=True, eq=False)
class Film:
    """Mean scattering of a film, by the scalar equation.

    Parameters
    ----------
    sines : (k,) float64 array    Of incidence in the half-space where light comes from.
    coherent, diffuse : dict of str to (2, w, k) float64 arrays
        Shares reflected and transmitted, by the side that light comes from; both sides are there.
    kernels : dict of str to (w, t) float64 arrays
        Coefficients of ``reflection_above``, ``transmission`` (from above to below) and ``reflection_below``.
    scatter : dict of str to (w, t, t) float64 arrays    Covariances of these coefficients.
    is_symmetric : bool    Whether both sides are alike.
    below : float    Index there.
    """

    sines: np.ndarray
    coherent: dict[str, np.ndarray]
    diffuse: dict[str, np.ndarray]
    kernels: dict[str, np.ndarray]
    scatter: dict[str, np.ndarray]
    is_symmetric: bool
    below: float

    def absorbed(self, side: str) -> np.ndarray:
        """Share that is absorbed. (w, k)"""
        return 1.0 - self.coherent[side].sum(axis=0) - self.diffuse[side].sum(axis=0)

    def kernel(self, name: str, first, second, turn) -> np.ndarray:
        """Scattering per d2s. Cosines at both ends (first of where light comes from), cosine of the azimuth -> (n, w)"""
        return self._terms_at(name, first, second, turn) @ self.kernels[name].T

    def kernel_error(self, name: str, first, second, turn) -> np.ndarray:
        """Standard error of `kernel` by the speckle of its samples. (n, w)"""
        terms = self._terms_at(name, first, second, turn)
        square = np.einsum("nt,wtu,nu->nw", terms, self.scatter[name], terms)
        return np.sqrt(np.maximum(square, 0.0))

    def _terms_at(self, name: str, first, second, turn) -> np.ndarray:
        return series(first, second, turn, name != "transmission" or self.is_symmetric)


def series(first, second, turn, is_even: bool) -> np.ndarray:
    """Terms of a kernel: P_j P_k of the cosines, times (sin sin)^m cos(m phi). (n,) each -> (n, t)"""
    first, second, turn = (np.asarray(each, np.float64) for each in (first, second, turn))
    both = np.sqrt(np.maximum((1.0 - first**2) * (1.0 - second**2), 0.0))
    angle = np.arccos(np.clip(turn, -1.0, 1.0))
    one, two = (
        np.polynomial.legendre.legvander(2.0 * each - 1.0, DEGREES[0]) for each in (first, second)
    )
    columns = []
    for mode, j, k in _terms(is_even):
        product = one[..., j] * two[..., k]
        if is_even and j != k:
            product = product + one[..., k] * two[..., j]
        columns.append(product * both**mode * np.cos(mode * angle))
    return np.stack(columns, axis=-1)


@lru_cache
def _terms(is_even: bool) -> tuple[tuple[int, int, int], ...]:
    return tuple(
        (mode, j, k)
        for mode, degree in enumerate(DEGREES)
        for j in range(degree + 1)
        for k in range(j if is_even else 0, degree + 1 - j)
    )


@lru_cache
def _known_terms(is_even: bool, samples: int, incidences: int) -> np.ndarray:
    """Numbers of the terms that so many orders tell: in a narrow cell few, and a series of more would be anything between.

    Samples are those of half the realisations, so that halves, by which errors are told, have the same terms.
    """
    terms = _terms(is_even)
    for degree in range(DEGREES[0], -1, -1):
        known = [n for n, (mode, j, k) in enumerate(terms) if mode + j + k <= degree]
        if degree < incidences and samples >= SAMPLES_PER_TERM * len(known):
            return np.array(known)
    return np.array([0])


def analyse(ink: Ink, plan: Plan, ensemble: Ensemble, realisations) -> Film:
    """Mean of some realisations."""
    bands, angles = len(plan.wavelengths), len(plan.sines)
    is_symmetric = ink.is_alike_from_both_sides
    indices = {"above": 1.0, "below": ink.below}
    shares = {side: np.zeros((2, 2, bands, angles)) for side in SIDES}
    names = ("reflection_above", "transmission", "reflection_below")
    kernels = {
        name: np.zeros((bands, len(_terms(name != "transmission" or is_symmetric))))
        for name in names
    }
    scatter = {name: np.zeros((*each.shape, each.shape[1])) for name, each in kernels.items()}
    sides = SIDES[:1] if is_symmetric else SIDES
    for band, wavelength in enumerate(plan.wavelengths):
        units = [ensemble.units[k, band] for k in realisations]
        area = (wavelength * 1e-3 / plan.width) ** 2
        samples = {name: [] for name in names}
        for side in sides:
            other = SIDES[1 - SIDES.index(side)]
            for k, sine in enumerate(plan.sines):
                cosine = np.sqrt(1.0 - sine**2)
                for way, end in (("up", side), ("down", other)):
                    name = "transmission" if way == "down" else f"reflection_{side}"
                    rows = np.concatenate([unit[f"{side}.{k}.{way}"][1:] for unit in units])
                    length = np.hypot(rows[:, 0], rows[:, 1])
                    out = np.sqrt(np.maximum(1.0 - (length / indices[end]) ** 2, 0.0))
                    turn = rows[:, 0] / np.maximum(length, 1e-12)
                    here = np.full(len(rows), cosine)
                    # Light from below to above counts as its reverse.
                    ends = (
                        (out, here) if name == "transmission" and side == "below" else (here, out)
                    )
                    samples[name].append((*ends, turn, rows[:, 2] / area))
        for name in names:
            if not samples[name]:
                continue
            first, second, turn, values = (
                np.concatenate(each) for each in zip(*samples[name], strict=True)
            )
            is_even = name != "transmission" or is_symmetric
            terms = series(first, second, turn, is_even)
            told = len(values) * plan.realisations // (2 * len(realisations))
            known = _known_terms(is_even, told, angles)
            kernels[name][band, known], found = _fit(terms[:, known], values)
            scatter[name][band][np.ix_(known, known)] = found
        if is_symmetric:
            for each in (kernels, scatter):
                each["reflection_below"][band] = each["reflection_above"][band]
        for side in sides:
            other = SIDES[1 - SIDES.index(side)]
            for k, sine in enumerate(plan.sines):
                for number, (way, end) in enumerate((("up", side), ("down", other))):
                    rows = [unit[f"{side}.{k}.{way}"] for unit in units]
                    straight = float(np.mean([each[0, 2] for each in rows]))
                    rest = float(np.mean([each[1:, 2].sum() for each in rows]))
                    within = _scattered_there(
                        kernels, way, side, sine, indices[side], indices[end], band, is_symmetric
                    )
                    within = min(max(within * area, 0.0), straight)
                    shares[side][0, number, band, k] = straight - within
                    shares[side][1, number, band, k] = rest + within
    if is_symmetric:
        shares["below"] = shares["above"]
    return Film(
        np.array(plan.sines),
        {side: shares[side][0] for side in SIDES},
        {side: shares[side][1] for side in SIDES},
        kernels,
        scatter,
        is_symmetric,
        ink.below,
    )


def _scattered_there(kernels, way, side, sine, index, end_index, band, is_symmetric) -> float:
    """Kernel at the order that goes on. [per d2s]"""
    cosine = np.sqrt(1.0 - sine**2)
    out = 1.0 - (sine * index / end_index) ** 2
    if out <= 0.0:
        return 0.0
    out = np.sqrt(out)
    name = "transmission" if way == "down" else f"reflection_{side}"
    ends = (out, cosine) if name == "transmission" and side == "below" else (cosine, out)
    terms = series(*ends, np.ones(()), name != "transmission" or is_symmetric)
    return float(terms.ravel() @ kernels[name][band])


def _fit(terms, values) -> tuple[np.ndarray, np.ndarray]:
    """Least squares and their covariance; terms of which the samples know nothing are 0. (t,), (t, t)"""
    count = terms.shape[1]
    if not len(values) or not np.any(values > 1e-14):
        return np.zeros(count), np.zeros((count, count))
    scale = np.sqrt((terms**2).mean(axis=0))
    found = np.linalg.lstsq(terms / scale, values, rcond=1e-6)[0] / scale
    shares = np.linalg.pinv(terms / scale, rcond=1e-6) / scale[:, None] * values
    return found, 0.5 * shares @ shares.T
